//! Gaps between solids that the grid does not resolve.

use super::thin_liquid::Obstacles;
use crate::build::Setup;
use crate::file::{Scene, Warning};
use meniscus_numerics::{Vector, par};
use meniscus_sim::{SolidSurfaces, Solids};

/// Width, in cells, below which liquid in a gap is not resolved.
const RESOLVED_GAP_CELLS: f64 = 2.0;
/// Width, in cells, up to which solids count as touching.
const CONTACT_GAP_CELLS: f64 = 0.05;
/// Halvings of the step of the pattern search, which starts at half a cell.
const HALVINGS: u32 = 12;
/// Most steps of one length.
const MAX_STEPS_PER_LENGTH: u32 = 8;

/// Warnings of gaps narrower than two cells between solids at the start.
pub(crate) fn warnings<const D: usize>(scene: &Scene, setup: &Setup<D>) -> Vec<Warning> {
    let model = &setup.model;
    let states = &model.initial_solids();
    let solids = Solids { model, states, surfaces: &SolidSurfaces::new(&model.solids, states) };
    let obstacles = Obstacles::new(solids, model.grid.dx);
    let named = scene.solids.len();
    let mut out = Vec::new();
    for j in 1..named {
        for i in 0..j {
            let [a, b] = [solids.get(i), solids.get(j)];
            let width = |x: &Vector<D>| {
                let [p, q] = [a.liquid_distance(x), b.liquid_distance(x)];
                if p < 0.0 || q < 0.0 { f64::INFINITY } else { p + q }
            };
            let Some(narrowest) = narrowest_gap_center(&obstacles, setup, [i, j]) else { continue };
            let cells = pattern_search(width, narrowest, model.grid.dx) / model.grid.dx;
            if cells > CONTACT_GAP_CELLS && cells < RESOLVED_GAP_CELLS {
                let message = format!(
                    "the gap between `{}` and `{}` is {cells:.2} cells wide: liquid in it is not resolved (this needs at least 2 cells)",
                    scene.solids[i].name, scene.solids[j].name
                );
                out.push(Warning { path: format!("solid.{j}.shape"), message });
            }
        }
    }
    out
}

/// The centre of the cell where the gap between two solids is narrowest; none where it is wider than two cells everywhere.
fn narrowest_gap_center<const D: usize>(
    obstacles: &Obstacles<'_, D>,
    setup: &Setup<D>,
    pair: [usize; 2],
) -> Option<Vector<D>> {
    let grid = &setup.model.grid;
    let lattice = grid.lattice();
    let width = |i: usize| {
        let x = grid.center(lattice.coordinates(i));
        let both: Vec<f64> = obstacles.distances(&x).filter(|d| pair.contains(&d.0)).map(|d| d.1).collect();
        let between = both.len() == 2 && both.iter().all(|d| *d >= 0.0);
        between.then(|| (i, both[0] + both[1]))
    };
    let found = par::filter_map(lattice.len(), 64, width);
    let least = found.into_iter().min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)))?;
    Some(grid.center(lattice.coordinates(least.0)))
}

/// Pattern search for the minimum near a point, with steps along the axes that are halved.
fn pattern_search<const D: usize>(of: impl Fn(&Vector<D>) -> f64, mut at: Vector<D>, dx: f64) -> f64 {
    let (mut least, mut step) = (of(&at), 0.5 * dx);
    for _ in 0..HALVINGS {
        for _ in 0..MAX_STEPS_PER_LENGTH {
            let before = least;
            for direction in 0..2 * D {
                let mut next = at;
                next[direction / 2] += if direction % 2 == 0 { step } else { -step };
                let value = of(&next);
                if value < least {
                    (least, at) = (value, next);
                }
            }
            if least == before {
                break;
            }
        }
        step *= 0.5;
    }
    least
}
