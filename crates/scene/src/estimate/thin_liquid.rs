//! Liquid that the grid does not resolve: films, threads and gaps thinner than two cells.
//!
//! The measure is a morphological opening. A point of the liquid is resolved if a ball of two cells in diameter fits into the liquid
//! within four cells of it; the rest is thin. Solids bound the liquid as air does; mirror sides of the domain do not. The reach of four
//! cells excludes the wedge at every contact line: at angles of 30 degrees and more its tip is closer than that to the ball. Between two
//! neighbours at depths a and b, in cells, the middle of a film has the depth (a + b + s) / 2, where s is the slope of the depth along
//! the axis.

use crate::build::Setup;
use meniscus_numerics::grid::{Grid, Lattice};
use meniscus_numerics::{Vector, par};
use meniscus_sim::{Simulation, SolidSurfaces, SolidView, Solids};

/// Radius of the ball that must fit, in cells.
const BALL_RADIUS_CELLS: f32 = 1.0;
/// Distance, in cells, from the ball up to which liquid is resolved.
const OPENING_REACH_CELLS: isize = 4;
/// Share of the liquid above which thin liquid gives a warning.
pub const WARNING_SHARE: f64 = 1e-3;

/// Liquid thinner than two cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinLiquid<const D: usize> {
    /// Its share of the liquid's volume, 0 to 1.
    pub share: f64,
    /// The centre of its deepest cell, m; none without thin liquid.
    pub place: Option<Vector<D>>,
}

/// The thin liquid of a simulation in its present state.
pub fn of_simulation<const D: usize>(simulation: &Simulation<D>) -> ThinLiquid<D> {
    let (model, state) = (&simulation.model, &simulation.state);
    let lattice = model.grid.lattice();
    let solids = Obstacles::new(simulation.solids(), model.grid.dx);
    measure_thin_liquid(&model.grid, |at| {
        let phi = state.phi.data[lattice.index(at)];
        if phi > model.grid.dx { phi } else { phi.max(-solids.distance(&model.grid.center(at))) }
    })
}

/// The thin liquid of the initial liquid bodies of a setup.
pub fn of_setup<const D: usize>(setup: &Setup<D>) -> ThinLiquid<D> {
    let (model, grid) = (&setup.model, &setup.model.grid);
    let states = &model.initial_solids();
    let solids = Solids { model, states, surfaces: &SolidSurfaces::new(&model.solids, states) };
    let obstacles = Obstacles::new(solids, grid.dx);
    measure_thin_liquid(grid, |at| {
        let x = grid.center(at);
        let phi = setup.bodies.iter().map(|(body, _)| body(&x)).fold(f64::INFINITY, f64::min);
        if phi > grid.dx { phi } else { phi.max(-obstacles.distance(&x)) }
    })
}

/// The thin part of the liquid whose signed distance (m, negative inside) at the centre of a cell is `distance`.
pub fn measure_thin_liquid<const D: usize>(
    grid: &Grid<D>,
    distance: impl Fn([usize; D]) -> f64 + Sync,
) -> ThinLiquid<D> {
    let lattice = grid.lattice();
    let cells = lattice.len();
    let depth = par::map(cells, 64, |i| (-distance(lattice.coordinates(i)) / grid.dx) as f32);
    let fits = par::map(cells, 64, |i| ball_fits(lattice, &depth, i));
    let near = cell_offsets_within_reach::<D>();
    let is_thin = |i: usize| {
        let at = lattice.coordinates(i);
        !near.iter().any(|step| neighbour_cell(lattice, at, step).is_some_and(|j| fits[j]))
    };
    let candidate = |i: usize| depth[i] > -0.5 && !fits[i];
    let thin = par::filter_map(cells, 64, |i| (candidate(i) && is_thin(i)).then_some(i));
    // The liquid fraction of a cell for an interface perpendicular to an axis.
    let part = |i: usize| f64::from((depth[i] + 0.5).clamp(0.0, 1.0));
    let all: f64 = (0..lattice.len()).map(part).sum();
    let some: f64 = thin.iter().map(|i| part(*i)).sum();
    let deepest = thin.iter().copied().reduce(|a, b| if depth[b] > depth[a] { b } else { a });
    let place = deepest.map(|i| grid.center(lattice.coordinates(i)));
    ThinLiquid { share: if all > 0.0 { some / all } else { 0.0 }, place }
}

/// Whether the ball fits around a cell's centre, or between it and a neighbour's. Between them the depth rises from both by its slope
/// along the axis on their outer sides.
fn ball_fits<const D: usize>(lattice: Lattice<D>, depth: &[f32], i: usize) -> bool {
    let own = depth[i];
    let at = lattice.coordinates(i);
    let between = |n: usize| {
        let mut step = [0; D];
        step[n / 2] = if n.is_multiple_of(2) { 1 } else { -1 };
        let to = |times: isize| neighbour_cell(lattice, at, &step.map(|s| s * times)).map(|j| depth[j]);
        let Some(other) = to(1).filter(|other| *other > 0.0) else { return false };
        let rises = [to(-1).map(|outer| own - outer), to(2).map(|outer| other - outer)];
        let slope = rises.into_iter().flatten().fold(1.0, f32::min).max(0.0);
        0.5 * (own + other + slope) >= BALL_RADIUS_CELLS
    };
    own >= BALL_RADIUS_CELLS || own > 0.0 && (0..2 * D).any(between)
}

/// Offsets to the cells up to [`OPENING_REACH_CELLS`] away, the shortest first.
fn cell_offsets_within_reach<const D: usize>() -> Vec<[isize; D]> {
    let cube = Lattice::<D>::new([2 * OPENING_REACH_CELLS as usize + 1; D]);
    let mut steps: Vec<[isize; D]> =
        (0..cube.len()).map(|i| cube.coordinates(i).map(|c| c as isize - OPENING_REACH_CELLS)).collect();
    let square = |step: &[isize; D]| step.iter().map(|s| s * s).sum::<isize>();
    steps.retain(|step| square(step) <= OPENING_REACH_CELLS * OPENING_REACH_CELLS);
    steps.sort_by_key(square);
    steps
}

fn neighbour_cell<const D: usize>(
    lattice: Lattice<D>,
    mut at: [usize; D],
    step: &[isize; D],
) -> Option<usize> {
    for a in 0..D {
        at[a] = at[a].checked_add_signed(step[a]).filter(|c| *c < lattice.extent[a])?;
    }
    Some(lattice.index(at))
}

/// The solids as boundaries of the liquid.
pub struct Obstacles<'a, const D: usize> {
    /// Each solid with a box around all points closer to it than two cells.
    solids: Vec<(SolidView<'a, D>, [Vector<D>; 2])>,
}

impl<'a, const D: usize> Obstacles<'a, D> {
    /// The solids at their present positions.
    pub fn new(solids: Solids<'a, D>, dx: f64) -> Self {
        let boxed = |solid: SolidView<'a, D>| {
            let [low, high] = solid.bounds();
            let reach = Vector::<D>::repeat(2.0 * dx + solid.padding);
            (solid, [low - reach, high + reach])
        };
        Self { solids: solids.iter().map(boxed).collect() }
    }

    /// Distance of a point to the nearest solid, m, negative inside; infinite beyond two cells.
    pub fn distance(&self, x: &Vector<D>) -> f64 {
        self.distances(x).map(|(_, d)| d).fold(f64::INFINITY, f64::min)
    }

    /// Distances, m, to the solids that may be closer than two cells, with their numbers.
    pub fn distances<'b>(&'b self, x: &'b Vector<D>) -> impl Iterator<Item = (usize, f64)> + 'b {
        let near = |[low, high]: &[Vector<D>; 2]| (0..D).all(|a| low[a] <= x[a] && x[a] <= high[a]);
        let all = self.solids.iter().enumerate().filter(move |(_, s)| near(&s.1));
        all.map(move |(i, (solid, _))| (i, solid.liquid_distance(x)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Thin share of a straight film of the given thickness (cells), rotated and shifted.
    fn film(thickness: f64, angle: f64, shift: f64) -> f64 {
        let grid = Grid::<2>::new([60, 60], 0.1);
        let normal = Vector::from([angle.sin(), angle.cos()]);
        let distance = |at: [usize; 2]| {
            let x = (grid.center(at) - Vector::from([3.0, 3.0])).dot(&normal) - shift * grid.dx;
            x.abs() - 0.5 * thickness * grid.dx
        };
        measure_thin_liquid(&grid, distance).share
    }

    #[test]
    fn films_of_known_thickness() {
        for angle in [0.0f64, 20.0, 30.0, 45.0, 90.0] {
            for shift in [0.0, 0.2, 0.37, 0.5, 0.8] {
                let share = |thickness| film(thickness, angle.to_radians(), shift);
                assert_eq!(share(0.8), 1.0, "{angle} {shift}");
                assert_eq!(share(1.65), 1.0, "{angle} {shift}");
                assert_eq!(share(2.05), 0.0, "{angle} {shift}");
                assert_eq!(share(6.0), 0.0, "{angle} {shift}");
            }
        }
    }

    #[test]
    fn drops_are_resolved_down_to_their_lines_and_what_runs_ahead_of_them_is_not() {
        let grid = Grid::<2>::new([120, 40], 1.0);
        // A cap of radius 30 on the line y = 10, and a film of one cell from its middle on.
        let cap = |at: [usize; 2], angle: f64, ahead: f64| {
            let x = grid.center(at);
            let centre = Vector::from([50.0, 10.0 - 30.0 * angle.cos()]);
            let film = (x[1] - 11.0).max(x[0] - ahead).max(50.0 - x[0]);
            ((x - centre).norm() - 30.0).min(film).max(10.0 - x[1])
        };
        for angle in [30.0f64, 60.0, 90.0] {
            let alone = measure_thin_liquid(&grid, |at| cap(at, angle.to_radians(), -1.0));
            assert!(alone.share < 2e-3, "{angle}: {alone:?}");
        }
        let with = measure_thin_liquid(&grid, |at| cap(at, 1.0, 110.0));
        assert!(with.share > 0.02 && with.place.is_some_and(|x| x[0] > 70.0), "{with:?}");
        let thread = Grid::<3>::new([24, 24, 24], 1.0);
        let of = |radius: f64| {
            measure_thin_liquid(&thread, |at| {
                (thread.center(at) - Vector::from([12.1, 12.3, 0.0])).xy().norm() - radius
            })
        };
        assert!(of(0.8).share == 1.0 && of(1.6).share == 0.0);
    }
}
