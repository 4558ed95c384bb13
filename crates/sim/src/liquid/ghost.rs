//! φ inside solids: where the surface would go on at the contact angle.
//!
//! Stencils at a solid's surface reach into it, and a solid that moves leaves what was in it. There φ tends to the
//! surface's straight continuation under the contact angle: from a point at depth `d` the direction
//! `w = n sin θ − t cos θ`, with `n` the solid's normal and `t` that of φ's slope along the solid, leads out to a point
//! above the solid that has the same value (design, experiments part 2).

use crate::model::Model;
use crate::state::State;
use meniscus_numerics::grid::{Band, CutCells, Sampler};
use rayon::prelude::*;

/// Part of the way to the continuation that φ goes in a step: at once it lifts drops off, never it keeps what is stale.
const RELAXATION: f64 = 0.1;
/// Height above a solid, in cells, at which φ is taken.
const HEIGHT: f64 = 1.0;
/// Depth to which φ is continued, in cells.
const DEPTH: f64 = 5.0;
/// Least sine of the angle at which it is continued.
const FLATTEST: f64 = 0.25;

/// Brings φ in the band's cells within solids nearer to the surface's continuation.
pub fn extend_into_solids<const D: usize>(
    model: &Model<D>,
    state: &mut State<D>,
    band: &Band<D>,
    solids: &CutCells<D>,
) {
    let within: Vec<u32> = band
        .cells
        .iter()
        .copied()
        .filter(|c| (-DEPTH..0.0).contains(&solids.distance(*c as usize)))
        .collect();
    let relaxation: f64 = std::env::var("RELAX").map_or(RELAXATION, |v| v.parse().unwrap_or(0.1));
    let sampler = Sampler::cells(&model.grid, &state.phi.data, model.scalar_edges());
    let new: Vec<f64> = within
        .par_iter()
        .with_min_len(64)
        .map(|&c| {
            let (cell, old) = (c as usize, state.phi.data[c as usize]);
            let target = continued(model, state, &sampler, cell, -solids.distance(cell) * model.grid.dx);
            old + relaxation * (target.unwrap_or(old) - old)
        })
        .collect();
    within.iter().zip(new).for_each(|(&c, v)| state.phi.data[c as usize] = v);
}

/// φ where the straight continuation through a cell at a depth (m) comes out of its solid.
fn continued<const D: usize>(
    model: &Model<D>,
    state: &State<D>,
    phi: &Sampler<'_, D>,
    cell: usize,
    depth: f64,
) -> Option<f64> {
    let dx = model.grid.dx;
    let x = model.grid.center(model.grid.lattice().coordinates(cell));
    let number = model.nearest_solid(&state.solids, &x)?;
    let (solid, now) = (&model.solids[number], &state.solids[number]);
    let normal = solid.normal(now, &x, 0.01 * dx);
    let way = depth + HEIGHT * dx;
    let (_, slope) = phi.distance(&(x + normal * way));
    let along = slope - normal * slope.dot(&normal);
    let cosine = solid.cosine.clamp(-1.0, 1.0);
    let sine = (1.0 - cosine * cosine).sqrt().max(FLATTEST);
    let cosine = (1.0 - sine * sine).sqrt().copysign(cosine);
    let direction = along.try_normalize(1e-3).map_or(normal, |t| normal * sine - t * cosine);
    let rise = direction.dot(&normal);
    Some(phi.distance(&(x + direction * (way / rise))).0)
}
