//! Overlaps of rigid solids with each other and with sides of the domain.

use super::Overlap;
use crate::model::{Model, Wall};
use crate::solid::{Solid, SolidKind, SolidState};
use meniscus_numerics::Vector;
use meniscus_numerics::shape::SurfaceSample;

/// Spacing of the sample points, in cells.
const PROBE_SPACING_CELLS: f64 = 0.5;

/// All overlaps in the current configuration. Solids with prescribed motion may overlap each other.
pub fn overlaps<const D: usize>(model: &Model<D>, solids: &[SolidState<D>]) -> Vec<Overlap> {
    if model.solids.iter().all(|s| s.kind.is_prescribed()) {
        return Vec::new();
    }
    let probes: Vec<Vec<SurfaceSample<D>>> =
        model.solids.iter().enumerate().map(|(i, s)| probes(model, i, s)).collect();
    let soft = super::deformable::soft_overlaps(model, solids, &probes);
    let free = |i: usize| model.solids[i].kind == SolidKind::Rigid;
    let mut all = Vec::new();
    for (i, own) in probes.iter().enumerate() {
        let [low, high] = model.solids[i].bounds(&solids[i]);
        let placed: Vec<SurfaceSample<D>> = own
            .iter()
            .map(|p| SurfaceSample { position: model.solids[i].to_current(&solids[i], &p.position), ..*p })
            .chain(inscribed(&model.solids[i], &solids[i]))
            .collect();
        if free(i) {
            let depth = placed.iter().map(|p| depth_beyond_sides(model, p)).fold(0.0, f64::max);
            all.push((i, None, depth));
        }
        for j in (0..probes.len()).filter(|j| i != *j && !own.is_empty() && (free(i) || free(*j))) {
            let other = &model.solids[j];
            let [lower, upper] = other.bounds(&solids[j]);
            let apart = |a: usize| low[a].max(lower[a]) > high[a].min(upper[a]);
            if other.elastic().is_some() || model.wetting_wall_solid() == Some(j) || (0..D).any(apart) {
                continue;
            }
            let depth = |p: &SurfaceSample<D>| p.radius - other.distance(&solids[j], &p.position);
            all.push((i, Some(j), placed.iter().map(depth).fold(0.0, f64::max)));
        }
    }
    all.into_iter().filter(|o| o.2 > 0.0).chain(soft).collect()
}

/// Initial sample points of a rigid solid; none for the sides of the domain, which are tested as planes.
fn probes<const D: usize>(model: &Model<D>, number: usize, solid: &Solid<D>) -> Vec<SurfaceSample<D>> {
    let own = model.wetting_wall_solid() != Some(number) && solid.elastic().is_none();
    if own { solid.shape.surface_samples(PROBE_SPACING_CELLS * model.grid.dx) } else { Vec::new() }
}

/// Ball around the centre of mass that lies within the solid. It detects a solid inside another one with the same surface.
fn inscribed<const D: usize>(solid: &Solid<D>, now: &SolidState<D>) -> Option<SurfaceSample<D>> {
    let radius = -solid.shape.signed_distance(&solid.mass_properties.center);
    (radius > 0.0 && radius.is_finite()).then_some(SurfaceSample {
        position: now.center,
        radius,
        sharp: false,
    })
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
