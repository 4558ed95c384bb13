//! The surface inside solids: it goes on at the contact angle.
//!
//! Stencils at a solid's surface reach into it, and a solid that moves leaves what was in it. There φ tends to the
//! surface's straight continuation under the contact angle: from a point at depth `d` the direction
//! `w = n sin θ − t cos θ`, with `n` the solid's normal and `t` that of φ's slope along the solid, leads out to a point
//! above the solid that has the same value (design, experiments part 2).

use crate::model::Model;
use crate::solid::SolidState;
use meniscus_numerics::Vector;
use meniscus_numerics::grid::{Band, CellField, CutCells, Sampler};
use rayon::prelude::*;

/// Part of the way to the continuation that φ goes in a step: at once it lifts drops off, never it keeps what is stale.
const RELAXATION: f64 = 0.1;
/// Height above a solid, in cells, at which the surface is looked for.
const HEIGHT: f64 = 1.0;
/// Least sine of the angle at which it is continued.
const FLATTEST: f64 = 0.25;

/// A cell with its centre in a solid, and where the surface's continuation through it comes out.
#[derive(Clone, Copy, Debug)]
pub struct Ghost<const D: usize> {
    /// Its place in the band.
    pub slot: u32,
    /// A point of the continuation outside the solid, m.
    pub outside: Vector<D>,
}

/// The cells of the band within solids.
pub fn ghosts<const D: usize>(
    model: &Model<D>,
    solids: &[SolidState<D>],
    phi: &CellField<D>,
    band: &Band<D>,
    cut: &CutCells<D>,
) -> Vec<Ghost<D>> {
    let sampler = Sampler::cells(&model.grid, &phi.data, model.scalar_edges());
    let within = |c: &u32| cut.distance(*c as usize) < 0.0;
    let slots: Vec<u32> = (0..band.cells.len() as u32).filter(|s| within(&band.cells[*s as usize])).collect();
    let ghost = |&slot: &u32| {
        let cell = band.cells[slot as usize] as usize;
        let x = model.grid.center(model.grid.lattice().coordinates(cell));
        let depth = -cut.distance(cell) * model.grid.dx;
        Some(Ghost { slot, outside: comes_out(model, solids, &sampler, &x, depth)? })
    };
    slots.par_iter().with_min_len(64).filter_map(ghost).collect()
}

/// Where the straight continuation through a point at a depth (m) comes out of its solid.
fn comes_out<const D: usize>(
    model: &Model<D>,
    solids: &[SolidState<D>],
    phi: &Sampler<'_, D>,
    x: &Vector<D>,
    depth: f64,
) -> Option<Vector<D>> {
    let dx = model.grid.dx;
    let number = model.nearest_solid(solids, x)?;
    let (solid, now) = (&model.solids[number], &solids[number]);
    // Half-way between two sides of a solid there is none.
    let normal = solid.normal(now, x, 0.01 * dx).try_normalize(0.5)?;
    let way = depth + HEIGHT * dx;
    let (_, slope) = phi.distance(&(x + normal * way));
    let along = slope - normal * slope.dot(&normal);
    let young = solid.cosine_near(now, x, dx);
    let cosine = solid.wetting(young, slope.dot(&normal) / slope.norm().max(0.5)).0.clamp(-1.0, 1.0);
    let sine = (1.0 - cosine * cosine).sqrt().max(FLATTEST);
    let cosine = (1.0 - sine * sine).sqrt().copysign(cosine);
    let direction = along.try_normalize(1e-3).map_or(normal, |t| normal * sine - t * cosine);
    Some(x + direction * (way / direction.dot(&normal)))
}

/// Brings φ in the band's cells within solids nearer to the surface's continuation.
pub fn extend_into_solids<const D: usize>(
    model: &Model<D>,
    solids: &[SolidState<D>],
    phi: &mut CellField<D>,
    band: &Band<D>,
    cut: &CutCells<D>,
) {
    let ghosts = ghosts(model, solids, phi, band, cut);
    let sampler = Sampler::cells(&model.grid, &phi.data, model.scalar_edges());
    let target = |g: &Ghost<D>| sampler.distance(&g.outside).0;
    let targets: Vec<f64> = ghosts.par_iter().with_min_len(64).map(target).collect();
    for (ghost, target) in ghosts.iter().zip(targets) {
        let value = &mut phi.data[band.cells[ghost.slot as usize] as usize];
        *value += RELAXATION * (target - *value);
    }
}
