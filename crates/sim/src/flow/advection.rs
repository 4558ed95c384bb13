//! Semi-Lagrangian advection of the interface and the velocity along third-order Runge–Kutta paths.

use crate::model::Model;
use meniscus_numerics::grid::{
    Band, CellField, CutCells, FaceField, Grid, Lattice, Runs, Sampler, Segment, VelocitySampler,
};
use meniscus_numerics::lanes::{ALL_LANES, LANES, Lanes, VectorLanes};
use meniscus_numerics::{Vector, par};
use std::ops::{Add, Mul, Sub};

/// Vectors, of one point or of the points in all lanes.
trait Linear: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<f64, Output = Self> {}
impl<V: Copy + Add<Output = V> + Sub<Output = V> + Mul<f64, Output = V>> Linear for V {}

/// Terms of second and third order in `dt` of the displacement, m, along the path that arrives at `x` with the velocity `arrival`, by Ralston's
/// third-order Runge–Kutta method. The term of first order is `dt · arrival`.
#[inline(always)]
fn path_bend<V: Linear>(x: V, arrival: V, dt: f64, velocity: impl Fn(&V) -> V) -> V {
    let second = velocity(&(x - arrival * (0.5 * dt)));
    let third = velocity(&(x - second * (0.75 * dt)));
    ((second - arrival) * 3.0 + (third - arrival) * 4.0) * (dt / 9.0)
}

/// Departure point of the path that arrives at `x` with the velocity `arrival` after `dt`.
fn departure_point<V: Linear>(x: V, arrival: V, dt: f64, velocity: impl Fn(&V) -> V) -> V {
    x - arrival * dt - path_bend(x, arrival, dt, velocity)
}

/// Distance from the interface, in cells, within which paths use cubic interpolation of the velocity.
const CUBIC_INTERPOLATION_DISTANCE_CELLS: f64 = 2.5;

/// |∇φ| below which an air cell lies between two fronts. At the ridge it is the cosine of half the angle between their normals, so 0.5
/// means a wedge of 60 degrees. With 0.9 (130 degrees) the groove around a new contact filled with liquid (3 % of the volume in eight
/// steps).
const RIDGE_GRADIENT_NORM: f64 = 0.5;

/// Distance from a cell, in cells, that the stencil at its departure point reaches along an axis: two cells, and a path of at most a cell.
/// Its corners, `√D` times as far, are not looked at.
const STENCIL_REACH_CELLS: f64 = 3.0;

/// Advected values of φ in the segments of the band, one behind the other.
///
/// φ within a solid continues the surface of one side. A cell near a thin solid therefore reads only the values that open faces connect to it, if
/// these have one sign: else the surface of one side would appear on the other (experiment E36).
///
/// In a gap of one cell between two fronts the extended velocity is their mean, close to zero, so that the air cushion would never
/// close. There each front moves with the velocity of the adjacent liquid cell, and the nearer front counts.
pub fn advect_interface<const D: usize>(
    model: &Model<D>,
    phi: &CellField<D>,
    band: &Band<D>,
    velocity: &FaceField<D>,
    cut: &CutCells<D>,
    dt: f64,
) -> Vec<f64> {
    let (grid, flow) = (&model.grid, model.velocity_sampler(velocity));
    let distance = Sampler::cells(grid, &phi.data, model.scalar_boundary());
    let (lattice, first_layer) = (grid.lattice(), band.first_layers(1).end);
    let packed = pack(&band.segments);
    let mut values = vec![0.0; packed.last().map_or(0, |s| s.end)];
    par::for_each_segment(&mut values, 0, &packed, |s, part| {
        let from = &band.segments[s.row];
        let mut at = lattice.coordinates(from.row * lattice.extent[0]);
        for i in (0..part.len()).step_by(LANES) {
            at[0] = from.start + i;
            let cell = lattice.index(at);
            let departure = departure_points(&flow, grid, at, Lanes::load(&phi.data, cell), dt);
            distance.distance_lanes(&departure).store(part, i);
            let departure = departure.to_array();
            for (l, value) in part[i..].iter_mut().enumerate().take(LANES) {
                let (cell, mut at) = (cell + l, at);
                at[0] += l;
                let is_at_interface = band.slot(cell).is_some_and(|slot| slot < first_layer);
                if is_at_interface
                    && phi.data[cell] >= 0.0
                    && distance.gradient(at).norm() < RIDGE_GRADIENT_NORM
                {
                    *value = nearer_front(&flow, &distance, grid, phi, at, dt);
                } else if (0.0..STENCIL_REACH_CELLS).contains(&cut.distance_cells(cell)) {
                    *value = distance.distance_on_side(&departure[l], |first| own_side(cut, at, first));
                }
            }
        }
    });
    values
}

/// Departure points of the paths that arrive at consecutive cells of a row, from `at` on, where φ has the values `phi`.
#[inline(always)]
fn departure_points<const D: usize>(
    flow: &VelocitySampler<'_, D>,
    grid: &Grid<D>,
    at: [usize; D],
    phi: Lanes,
    dt: f64,
) -> VectorLanes<D> {
    let x = grid.centers(at);
    let is_near = phi.abs().less_than(Lanes::splat(CUBIC_INTERPOLATION_DISTANCE_CELLS * grid.dx));
    let near = || departure_point(x, flow.cubic_at_cells(at), dt, |x| flow.cubic_lanes(x));
    let far = || departure_point(x, flow.at_cells(at), dt, |x| flow.linear_lanes(x));
    match is_near.bits() {
        ALL_LANES => near(),
        0 => far(),
        _ => VectorLanes::select(is_near, near(), far()),
    }
}

/// Advected value of φ in an air cell between two fronts: that of the nearer front, which moves with its liquid cell.
fn nearer_front<const D: usize>(
    flow: &VelocitySampler<'_, D>,
    distance: &Sampler<'_, D>,
    grid: &Grid<D>,
    phi: &CellField<D>,
    at: [usize; D],
    dt: f64,
) -> f64 {
    let (lattice, x) = (grid.lattice(), grid.center(at));
    let liquid = lattice.neighbours(lattice.index(at)).filter(|n| phi.data[*n] < 0.0);
    let fronts = liquid.map(|n| {
        let liquid = lattice.coordinates(n);
        let (beside, arrival) = (grid.center(liquid), flow.cubic_at_cell(liquid));
        let departure = departure_point(beside, arrival, dt, |x| flow.cubic(x));
        distance.distance(&(x + departure - beside))
    });
    fronts.fold(f64::INFINITY, f64::min)
}

/// The points of a stencil (4 along each axis from `first` on, a bit each) outside solids that open faces connect to the cell `at`; none if
/// the stencil does not contain it.
fn own_side<const D: usize>(cut: &CutCells<D>, at: [usize; D], first: [isize; D]) -> u64 {
    let lattice = cut.open_fraction.grid.lattice();
    let low: [usize; D] = std::array::from_fn(|a| first[a].max(0) as usize);
    let high: [usize; D] = std::array::from_fn(|a| lattice.extent[a].min((first[a] + 4).max(0) as usize));
    if (0..D).any(|a| !(low[a]..high[a]).contains(&at[a])) {
        return 0;
    }
    let outside = |p: &&[usize; D]| cut.distance_cells(lattice.index(**p)) >= 0.0;
    let bit = |p: &[usize; D]| (0..D).rev().fold(0, |bit, a| 4 * bit + (p[a] as isize - first[a]));
    cut.connected_cells(at, [low, high]).iter().filter(outside).map(|p| 1 << bit(p)).sum()
}

/// Depth, in cells, up to which the interpolation of the velocity along an axis reads extrapolated values: faces up to two cells away, where
/// faces are known to half a cell beyond the interface. Limit: the departure points of deeper liquid are not corrected.
const EXTRAPOLATION_REACH_CELLS: f64 = 1.5;

/// The signed distance before a step and after it.
struct Depths<'a, const D: usize> {
    cells_before: &'a CellField<D>,
    before: Sampler<'a, D>,
    after: Sampler<'a, D>,
    cut: &'a CutCells<D>,
}

impl<const D: usize> Depths<'_, D> {
    /// The departure points of the liquid that arrives at `count` consecutive faces normal to `axis`, from `face` on, moved back into the
    /// liquid to the depth that it has after the step.
    ///
    /// Near the interface liquid keeps its depth where the interface moves with the flow. Where the contact angle, hysteresis or the volume
    /// correction hold the interface against an inflow, the path would begin beyond it, in the extrapolated velocity. With the slope `s`
    /// behind the surface and the Courant number `c`, the velocity would grow by `c s` in each step, without a bound (experiment E7).
    #[inline(always)]
    fn corrected(
        &self,
        departure: VectorLanes<D>,
        axis: usize,
        face: [usize; D],
        count: usize,
    ) -> VectorLanes<D> {
        let is_deep = self.are_deep(&departure, face);
        if is_deep & ((1 << count) - 1) == (1 << count) - 1 {
            return departure;
        }
        let (departure, first) = (departure.to_array(), face[0]);
        VectorLanes::from_fn(|l| {
            if l >= count || is_deep >> l & 1 == 1 {
                return departure[l];
            }
            let mut face = face;
            face[0] = first + l;
            self.corrected_at_interface(departure[l], axis, face)
        })
    }

    /// The bits of the lanes whose departure points are certainly too deep for a correction. Away from solids φ is a distance, which
    /// changes by no more than the way, and of which linear interpolation is off by less than a cell.
    #[inline(always)]
    fn are_deep(&self, departure: &VectorLanes<D>, face: [usize; D]) -> u32 {
        let grid = &self.cut.open_fraction.grid;
        let deep = Lanes::splat(-(EXTRAPOLATION_REACH_CELLS + 1.0) * grid.dx);
        let mut at: [usize; D] = std::array::from_fn(|a| face[a].min(grid.cells[a] - 1));
        at[0] = 0;
        let (row, last) = (grid.lattice().index(at), grid.cells[0] - 1);
        at[0] = face[0];
        let mut is_deep = 0;
        if face[0] + LANES <= last {
            let depth = Lanes::load(&self.cells_before.data, row + face[0]);
            is_deep = (depth + (*departure - grid.centers(at)).norms()).less_than(deep).bits();
        }
        if is_deep != ALL_LANES {
            is_deep |= self.before.linear_lanes(departure).less_than(deep).bits();
        }
        let is_far = |l: &usize| self.cut.distance_cells(row + (face[0] + l).min(last)) > STENCIL_REACH_CELLS;
        is_deep & (0..LANES).filter(is_far).map(|l| 1 << l).sum::<u32>()
    }

    /// The departure point of the liquid that arrives at a face, moved back to the depth that it has after the step.
    fn corrected_at_interface(&self, departure: Vector<D>, axis: usize, face: [usize; D]) -> Vector<D> {
        let grid = &self.cut.open_fraction.grid;
        let before = self.before.distance(&departure);
        if before < -EXTRAPOLATION_REACH_CELLS * grid.dx {
            return departure;
        }
        let excess = before - self.after.distance_at_face(grid, axis, face);
        if excess <= 0.0 {
            return departure;
        }
        let gradient = self.before.distance_with_gradient(&departure).1;
        gradient.try_normalize(0.0).map_or(departure, |normal| departure - normal * excess)
    }
}

/// The bends of the paths that arrive at the centres of the liquid's cells and of those beside them ([`path_bend`]).
struct CellPaths<const D: usize> {
    segments: Vec<Segment>,
    /// The segments packed one behind the other.
    packed: Vec<Segment>,
    /// The components, m, one behind the other.
    bends: Vec<f64>,
}

impl<const D: usize> CellPaths<D> {
    fn new(grid: &Grid<D>, flow: &VelocitySampler<'_, D>, liquid: &Runs, dt: f64) -> Self {
        let segments = liquid.with_neighbours(grid);
        let (packed, lattice) = (pack(&segments), grid.lattice());
        let length = packed.last().map_or(0, |s| s.end);
        let mut bends = vec![0.0; D * length];
        par::map_component_segments(&mut bends, length, &packed, |number, s, mut parts: [&mut [f64]; D]| {
            let from = &segments[number];
            let mut at = lattice.coordinates(from.row * lattice.extent[0]);
            for i in (0..s.end - s.start).step_by(LANES) {
                at[0] = from.start + i;
                let bend = path_bend(grid.centers(at), flow.at_cells(at), dt, |x| flow.linear_lanes(x));
                parts.iter_mut().zip(&bend.0).for_each(|(part, values)| values.store(part, i));
            }
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

/// The cells of the liquid and their faces.
#[derive(Clone, Copy)]
pub struct LiquidFaces<'a, const D: usize> {
    /// The cells.
    pub cells: &'a Runs,
    /// Their faces normal to each axis.
    pub faces: &'a [Vec<Segment>; D],
}

/// The bends of the cells on both sides of the faces of a row, component by component.
struct Beside<'a, const D: usize> {
    lower: [&'a [f64]; D],
    upper: [&'a [f64]; D],
    /// Number of faces at the start of the row without a lower cell.
    without_lower: usize,
}

impl<'a, const D: usize> Beside<'a, D> {
    /// Beside the faces normal to `axis` from the place `at` on.
    fn new(paths: &'a CellPaths<D>, cells: &Lattice<D>, axis: usize, mut at: [usize; D]) -> Self {
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
    fn mean_bends(&self, i: usize) -> VectorLanes<D> {
        VectorLanes(std::array::from_fn(|a| {
            let (lower, upper) = (self.lower[a], self.upper[a]);
            if let Some(first) = i.checked_sub(self.without_lower)
                && first + LANES <= lower.len()
                && i + LANES <= upper.len()
            {
                return (Lanes::load(lower, first) + Lanes::load(upper, i)) * 0.5;
            }
            Lanes::from_fn(|l| {
                let lower = (i + l).checked_sub(self.without_lower).and_then(|i| lower.get(i));
                match (lower, upper.get(i + l)) {
                    (Some(lower), Some(upper)) => (lower + upper) * 0.5,
                    (one, other) => one.or(other).copied().unwrap_or(0.0),
                }
            })
        }))
    }
}

/// Advected velocity on the faces of the `liquid`: one list of values per axis, segment after segment. `phi` is the signed distance before
/// the step and after it, `cut` are the cells beside solids.
///
/// The bend of the path that arrives at a face is the mean of those at the two cells beside it. The difference from a path of its own is of
/// second order in the cell size and in the step.
pub fn advect_velocity<const D: usize>(
    model: &Model<D>,
    phi: [&CellField<D>; 2],
    velocity: &FaceField<D>,
    liquid: LiquidFaces<'_, D>,
    cut: &CutCells<D>,
    dt: f64,
) -> [Vec<f64>; D] {
    let (grid, flow) = (&model.grid, model.velocity_sampler(velocity));
    let [before, after] = phi.map(|phi| Sampler::cells(grid, &phi.data, model.scalar_boundary()));
    let depths = Depths { cells_before: phi[0], before, after, cut };
    let LiquidFaces { cells: liquid, faces } = liquid;
    let paths = CellPaths::new(grid, &flow, liquid, dt);
    std::array::from_fn(|axis| {
        let (lattice, cells) = (grid.face_lattice(axis), grid.lattice());
        let packed = pack(&faces[axis]);
        let mut values = vec![0.0; packed.last().map_or(0, |s| s.end)];
        par::for_each_segment(&mut values, 0, &packed, |s, part| {
            let from = &faces[axis][s.row];
            let mut at = lattice.coordinates(from.row * lattice.extent[0]);
            at[0] = from.start;
            let beside = Beside::new(&paths, &cells, axis, at);
            for i in (0..part.len()).step_by(LANES) {
                at[0] = from.start + i;
                let departure =
                    grid.face_centers(axis, at) - flow.at_faces(axis, at) * dt - beside.mean_bends(i);
                let count = LANES.min(part.len() - i);
                let departure = depths.corrected(departure, axis, at, count);
                flow.component(axis).cubic_lanes(&departure).store(part, i);
            }
        });
        values
    })
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::workspace::Workspace;
    use crate::state::State;
    use meniscus_numerics::grid::{Grid, scatter_segments};

    /// Largest speed after `steps` steps of transport in a layer whose top face row flows in at the speed 1, the others at 0.1. The
    /// interface is `held` where it is, or moves with the flow.
    fn speed_after(steps: usize, held: bool) -> f64 {
        let model = Model::of_test(Grid::<2>::new([16, 32], 1.0), Vec::new());
        let (mut state, lattice) = (State::empty(model.grid), model.grid.lattice());
        for i in 0..lattice.len() {
            state.phi.data[i] = (lattice.coordinates(i)[1] as f64 - 15.5).clamp(-5.0, 5.0);
        }
        let mut work = Workspace::new(&model, &mut state);
        let faces = model.grid.face_lattice(1);
        for f in 0..faces.len() {
            state.velocity.axes[1][f] = match faces.coordinates(f)[1] {
                16 => -1.0,
                y if y > 0 && y < 16 => -0.1,
                _ => 0.0,
            };
        }
        for _ in 0..steps {
            work.rebuild_velocity_extension(&model, &mut state);
            let values =
                advect_interface(&model, &state.phi, &work.band, &state.velocity, &work.cut_cells, 0.1);
            let mut phi = state.phi.clone();
            if !held {
                scatter_segments(&mut phi.data, model.grid.cells[0], &work.band.segments, &values);
            }
            let segments = work.known_faces.liquid_faces().clone();
            let phis = [&state.phi, &phi];
            let liquid = LiquidFaces { cells: &work.liquid, faces: &segments };
            let moved = advect_velocity(&model, phis, &state.velocity, liquid, &work.cut_cells, 0.1);
            for (a, axis) in moved.iter().enumerate() {
                let row = model.grid.face_lattice(a).extent[0];
                let own = segments[a].iter().flat_map(|s| s.row * row + s.start..s.row * row + s.end);
                own.zip(axis).for_each(|(f, v)| state.velocity.axes[a][f] = *v);
            }
            if !held {
                state.phi = phi;
                work.find_liquid(&model, &state);
            }
        }
        let row = faces.extent[0];
        let liquid = work.known_faces.liquid_faces()[1].iter();
        let speeds = liquid.flat_map(|s| &state.velocity.axes[1][s.row * row + s.start..s.row * row + s.end]);
        speeds.fold(0.0, |most, v| most.max(v.abs()))
    }

    /// Without the correction the speed is about `1.1^30 = 17`: it grows by the Courant number in each step.
    #[test]
    fn inflow_through_a_held_interface_does_not_grow() {
        let most = speed_after(30, true);
        assert!(most < 1.05, "{most}");
    }

    /// No value is larger than that extrapolated in the first step, `2 · 1 − 0.1`.
    #[test]
    fn a_jet_that_moves_with_its_interface_does_not_exceed_the_extrapolated_speed() {
        let most = speed_after(10, false);
        assert!(most < 1.9, "{most}");
    }
}
