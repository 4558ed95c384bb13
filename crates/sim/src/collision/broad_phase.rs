//! Broad phase of contact: pairs of features that may touch while all solids go from one configuration to another.

use super::configuration::Configuration;
use super::points::SdfPair;
use meniscus_contact::FeaturePairs;
use meniscus_numerics::Vector;

/// The pairs that the broad phase has found.
#[derive(Clone, Debug, Default)]
pub struct CandidatePairs {
    /// Points and facets, edges and edges.
    pub feature_pairs: FeaturePairs,
    /// Points and rigid solids, points and sides of the domain.
    pub sdf_pairs: Vec<SdfPair>,
}

impl CandidatePairs {
    /// All pairs whose distance falls below `reach` and a `margin` (m) on one of the ways; a few that stay farther apart may be among
    /// them.
    pub fn on<const D: usize>(ways: &[Sweep<'_, D>], reach: f64, margin: f64) -> Self {
        let Some(Configuration { model, points, .. }) = ways.first().map(|way| way.from) else {
            return Self::default();
        };
        let configurations: Vec<_> =
            ways.iter().flat_map(|way| [way.from.positions(), way.to.positions()]).collect();
        let rigid = |body: u32| model.solids[body as usize].elastic().is_none();
        let feature_pairs =
            points.surface.nearby_pairs(&configurations, reach, margin, rigid, |p| points.is_prescribed(p));
        let ends = configurations.chunks_exact(2);
        let mut sdf_pairs: Vec<SdfPair> = ways
            .iter()
            .zip(ends)
            .flat_map(|(way, ends)| find_sdf_pairs(*way, &ends[0], &ends[1], reach + margin))
            .collect();
        sdf_pairs.sort_unstable();
        sdf_pairs.dedup();
        CandidatePairs { feature_pairs, sdf_pairs }
    }

    /// Those of points with what has no facets.
    pub fn sdf_pairs_along<const D: usize>(sweep: Sweep<'_, D>, reach: f64) -> Vec<SdfPair> {
        find_sdf_pairs(sweep, &sweep.from.positions(), &sweep.to.positions(), reach)
    }
}

/// Points and what has no facets whose distance falls below `reach` (m) on the way.
fn find_sdf_pairs<const D: usize>(
    sweep: Sweep<'_, D>,
    start: &[Vector<D>],
    end: &[Vector<D>],
    reach: f64,
) -> Vec<SdfPair> {
    let Configuration { model, points, .. } = *sweep.from;
    let displacements: Vec<Vector<D>> = end.iter().zip(start).map(|(e, s)| e - s).collect();
    let mut meetings = Vec::new();
    for (side, plane) in points.domain_sides.iter().enumerate() {
        let close = plane.near_points(&points.surface, start, &displacements, reach);
        meetings
            .extend(close.into_iter().filter(|p| !points.is_prescribed(*p)).map(|p| SdfPair::Side(p, side)));
    }
    let rigid = |k: &usize| model.solids[*k].elastic().is_none() && model.wetting_wall_solid() != Some(*k);
    for solid in (0..model.solids.len()).filter(rigid) {
        let parts = model.solids[solid].shape.parts().len();
        let [low, high] = sweep.from.bounds(solid);
        for p in points.surface.points() {
            let k = *p as usize;
            let near = reach + points.surface.radius(*p) + sweep.path_length_bound(solid, &start[k], &end[k]);
            let far = |a: usize| (low[a] - start[k][a]).max(start[k][a] - high[a]) > near;
            if !(0..D).any(far) && points.may_collide(model, *p, solid) {
                let close = |part: &usize| sweep.from.distance_to_rigid((solid, *part), &start[k]) < near;
                meetings.extend((0..parts).filter(close).map(|part| SdfPair::Rigid(*p, solid, part)));
            }
        }
    }
    meetings
}

/// Two configurations of all solids; points go straight from the one to the other.
#[derive(Clone, Copy)]
pub struct Sweep<'a, const D: usize> {
    /// Where it starts.
    pub from: &'a Configuration<'a, D>,
    /// Where it ends.
    pub to: &'a Configuration<'a, D>,
}

/// Length of a point's path in the frame of a rigid solid, over the distance of its ends there: where it turns, the path is an
/// arc, longer than its chord by `(θ/2)/sin(θ/2)`, less than this up to 2.6 radians a step.
const MAX_ARC_CHORD_RATIO: f64 = 1.5;

impl<const D: usize> Sweep<'_, D> {
    /// A bound, m, of the length of a point's path from `start` to `end` in the frame of a rigid solid.
    pub fn path_length_bound(&self, solid: usize, start: &Vector<D>, end: &Vector<D>) -> f64 {
        (self.to.to_reference(solid, end) - self.from.to_reference(solid, start)).norm() * MAX_ARC_CHORD_RATIO
    }
}
