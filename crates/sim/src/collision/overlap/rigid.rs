//! Overlaps of rigid solids with each other and with sides of the domain.

use super::Overlap;
use crate::model::{Model, Wall};
use crate::solid::{Solid, SolidSurfaces, SolidView, Solids};
use meniscus_numerics::Vector;
use meniscus_numerics::shape::SurfaceSample;

/// Spacing of the sample points, in cells.
const PROBE_SPACING_CELLS: f64 = 0.5;

/// All overlaps at the start.
pub fn initial_overlaps<const D: usize>(model: &Model<D>) -> Vec<Overlap> {
    let states = &model.initial_solids();
    overlaps(Solids { model, states, surfaces: &SolidSurfaces::new(&model.solids, states) })
}

/// All overlaps in the current configuration. Solids with prescribed motion may overlap each other.
pub fn overlaps<const D: usize>(solids: Solids<'_, D>) -> Vec<Overlap> {
    let model = solids.model;
    if !model.has_dynamic_solids() {
        return Vec::new();
    }
    let probes: Vec<Vec<SurfaceSample<D>>> =
        model.solids.iter().enumerate().map(|(i, s)| probes(model, i, s)).collect();
    let deformable = super::deformable::deformable_overlaps(solids, &probes);
    let free = |i: usize| model.solids[i].kind.is_free_rigid();
    let mut all = Vec::new();
    for (i, (one, own)) in solids.iter().zip(&probes).enumerate() {
        let ([low, high], rigid) = (one.bounds(), one.state.as_rigid());
        let placed: Vec<SurfaceSample<D>> = own
            .iter()
            .map(|p| SurfaceSample { position: one.to_current(&rigid, &p.position), ..*p })
            .chain(inscribed(&one))
            .collect();
        if free(i) {
            let depth = placed.iter().map(|p| depth_beyond_sides(model, p)).fold(0.0, f64::max);
            all.push((i, None, depth));
        }
        for j in (0..probes.len()).filter(|j| i != *j && !own.is_empty() && (free(i) || free(*j))) {
            let other = solids.get(j);
            let [lower, upper] = other.bounds();
            let apart = |a: usize| low[a].max(lower[a]) > high[a].min(upper[a]);
            if other.elastic().is_some() || model.wetting_wall_solid() == Some(j) || (0..D).any(apart) {
                continue;
            }
            let depth = |p: &SurfaceSample<D>| p.radius - other.distance(&p.position);
            all.push((i, Some(j), placed.iter().map(depth).fold(0.0, f64::max)));
        }
    }
    all.into_iter().filter(|o| o.2 > 0.0).chain(deformable).collect()
}

/// Initial sample points of a rigid solid; none for the sides of the domain, which are tested as planes.
fn probes<const D: usize>(model: &Model<D>, number: usize, solid: &Solid<D>) -> Vec<SurfaceSample<D>> {
    let own = model.wetting_wall_solid() != Some(number) && solid.elastic().is_none();
    if own { solid.shape.surface_samples(PROBE_SPACING_CELLS * model.grid.dx) } else { Vec::new() }
}

/// Ball around the centre of mass that lies within the solid. It detects a solid inside another one with the same surface.
fn inscribed<const D: usize>(SolidView { solid, state, .. }: &SolidView<'_, D>) -> Option<SurfaceSample<D>> {
    let radius = -solid.shape.signed_distance(&solid.mass_properties.center);
    let position = state.center_of_mass();
    (radius > 0.0 && radius.is_finite()).then_some(SurfaceSample { position, radius, sharp: false })
}

/// Depth of a sample point beyond the closed sides, m.
fn depth_beyond_sides<const D: usize>(model: &Model<D>, p: &SurfaceSample<D>) -> f64 {
    let upper: Vector<D> = model.grid.domain_upper();
    let side = |a: usize| {
        let past = |wall: Wall, depth: f64| if wall == Wall::Slip { depth } else { f64::NEG_INFINITY };
        past(model.walls[a][0], p.radius - p.position[a])
            .max(past(model.walls[a][1], p.position[a] + p.radius - upper[a]))
    };
    (0..D).map(side).fold(f64::NEG_INFINITY, f64::max)
}
