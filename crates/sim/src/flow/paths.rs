//! Paths of the liquid through the velocity field, by Ralston's third-order Runge–Kutta method.
//!
//! A path that arrives at `x` with the velocity `u` began at `x − dt u − b`. The bend `b` holds the terms of second and third order.
//! Bends are found at the centres of cells; a face takes the mean of those of the two cells beside it. Limit: the mean differs from the
//! bend of the face's own path by terms of second order in the cell size and in the step.

use meniscus_numerics::grid::{Grid, Lattice, Runs, Segment, VelocitySampler};
use meniscus_numerics::lanes::{Instructions, LANES, LaneWork, Lanes, VectorLanes, run_with_widest};
use meniscus_numerics::{each_lanes, par};
use std::ops::{Add, Mul, Sub};

/// Vectors, of one point or of the points in all lanes.
pub(crate) trait Linear:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<f64, Output = Self>
{
}
impl<V: Copy + Add<Output = V> + Sub<Output = V> + Mul<f64, Output = V>> Linear for V {}

/// Terms of second and third order in `dt` of the displacement, m, along the path that arrives at `x` with the velocity `arrival`, by
/// Ralston's third-order Runge–Kutta method. The term of first order is `dt · arrival`.
#[inline(always)]
fn path_bend<V: Linear>(x: V, arrival: V, dt: f64, velocity: impl Fn(&V) -> V) -> V {
    let second = velocity(&(x - arrival * (0.5 * dt)));
    let third = velocity(&(x - second * (0.75 * dt)));
    ((second - arrival) * 3.0 + (third - arrival) * 4.0) * (dt / 9.0)
}

/// Departure point of the path that arrives at `x` with the velocity `arrival` after `dt`.
#[inline(always)]
pub(crate) fn departure_point<V: Linear>(x: V, arrival: V, dt: f64, velocity: impl Fn(&V) -> V) -> V {
    x - arrival * dt - path_bend(x, arrival, dt, velocity)
}

/// The bends of the paths that arrive at the centres of the liquid's cells and of those beside them ([`path_bend`]).
pub(super) struct CellPaths<const D: usize> {
    segments: Vec<Segment>,
    /// The segments packed one behind the other.
    packed: Vec<Segment>,
    /// The components, m, one behind the other.
    bends: Vec<f64>,
}

/// The components of the bends in consecutive cells, from `at` on.
struct BendSegment<'a, const D: usize> {
    grid: &'a Grid<D>,
    flow: &'a VelocitySampler<'a, D>,
    dt: f64,
    at: [usize; D],
    parts: [&'a mut [f64]; D],
}

impl<const D: usize> LaneWork for BendSegment<'_, D> {
    type Output = ();

    #[inline(always)]
    fn run<I: Instructions>(self, with: I) {
        let Self { grid, flow, dt, mut at, mut parts } = self;
        let start = at[0];
        for i in (0..parts[0].len()).step_by(LANES) {
            at[0] = start + i;
            let (x, arrival) = (grid.centers(with, at), flow.at_cells(with, at));
            let bend = path_bend(x, arrival, dt, |x| flow.linear_lanes(x));
            parts.iter_mut().zip(&bend.0).for_each(|(part, values)| values.store(part, i));
        }
    }
}

impl<const D: usize> CellPaths<D> {
    pub(super) fn new(grid: &Grid<D>, flow: &VelocitySampler<'_, D>, liquid: &Runs, dt: f64) -> Self {
        let segments = liquid.with_neighbours(grid);
        let (packed, lattice) = (pack(&segments), grid.lattice());
        let length = packed.last().map_or(0, |s| s.end);
        let mut bends = vec![0.0; D * length];
        par::map_component_segments(&mut bends, length, &packed, |number, _, parts: [&mut [f64]; D]| {
            let from = &segments[number];
            let mut at = lattice.coordinates(from.row * lattice.extent[0]);
            at[0] = from.start;
            run_with_widest(BendSegment { grid, flow, dt, at, parts });
        });
        Self { segments, packed, bends }
    }

    /// The components of the bends of cells of a row from `start` on.
    fn from(&self, row: usize, start: usize) -> [&[f64]; D] {
        let next = self.segments.partition_point(|s| (s.row, s.start) <= (row, start));
        match next.checked_sub(1).map(|i| (&self.segments[i], &self.packed[i])) {
            Some((s, packed)) if s.row == row && start < s.end => {
                let length = self.bends.len() / D;
                let cells = packed.start + start - s.start..packed.end;
                std::array::from_fn(|a| &self.bends[a * length + cells.start..a * length + cells.end])
            }
            _ => [&[]; D],
        }
    }
}

/// The bends of the cells on both sides of the faces of a row, component by component.
pub(super) struct Beside<'a, const D: usize> {
    lower: [&'a [f64]; D],
    upper: [&'a [f64]; D],
    /// Number of faces at the start of the row without a lower cell.
    without_lower: usize,
}

impl<'a, const D: usize> Beside<'a, D> {
    /// The bends beside the faces normal to `axis`, from the place `at` on.
    pub(super) fn new(paths: &'a CellPaths<D>, cells: &Lattice<D>, axis: usize, mut at: [usize; D]) -> Self {
        let of = |at: [usize; D]| paths.from(cells.index(at) / cells.extent[0], at[0]);
        let has_upper = axis == 0 || at[axis] < cells.extent[axis];
        let upper = if has_upper { of(at) } else { [&[][..]; D] };
        let without_lower = usize::from(axis == 0 && at[0] == 0);
        let has_lower = axis == 0 || at[axis] > 0;
        at[axis] = at[axis].saturating_sub(1);
        Self { lower: if has_lower { of(at) } else { [&[][..]; D] }, upper, without_lower }
    }

    /// The mean bends beside the faces from `i` on.
    #[inline(always)]
    pub(super) fn mean_bends<I: Instructions>(&self, with: I, i: usize) -> VectorLanes<I, D> {
        VectorLanes(each_lanes!(with, |a| {
            let (lower, upper) = (self.lower[a], self.upper[a]);
            match i.checked_sub(self.without_lower) {
                Some(first) if first + LANES <= lower.len() && i + LANES <= upper.len() => {
                    (Lanes::load(with, lower, first) + Lanes::load(with, upper, i)) * 0.5
                }
                _ => Lanes::from_fn(with, |l| self.mean_bend(a, i + l)),
            }
        }))
    }

    /// The component along `a` of the mean bend beside face `i`, or of the one bend there is.
    fn mean_bend(&self, a: usize, i: usize) -> f64 {
        let lower = i.checked_sub(self.without_lower).and_then(|i| self.lower[a].get(i));
        match (lower, self.upper[a].get(i)) {
            (Some(lower), Some(upper)) => (lower + upper) * 0.5,
            (one, other) => one.or(other).copied().unwrap_or(0.0),
        }
    }
}

/// Packs segments one behind the other; `row` is the number of the segment.
pub fn pack(segments: &[Segment]) -> Vec<Segment> {
    let mut at = 0;
    segments
        .iter()
        .enumerate()
        .map(|(row, s)| {
            let start = at;
            at += s.end - s.start;
            Segment { row, start, end: at }
        })
        .collect()
}
