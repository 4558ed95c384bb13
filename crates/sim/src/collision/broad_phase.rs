//! Broad phase of contact: pairs of features that may touch while all solids move from one configuration to another.

use super::configuration::Configuration;
use super::points::SdfPair;
use meniscus_contact::FeaturePairs;
use meniscus_numerics::Vector;

/// Pairs that the broad phase found.
#[derive(Clone, Debug, Default)]
pub struct CandidatePairs {
    /// Point–facet and edge–edge pairs.
    pub feature_pairs: FeaturePairs,
    /// Pairs of a point and a rigid solid or a side of the domain.
    pub sdf_pairs: Vec<SdfPair>,
}

impl CandidatePairs {
    /// All pairs whose distance falls below `reach` (m) during one of the sweeps `ways`. A few others may be included.
    pub fn on<const D: usize>(ways: &[Sweep<'_, D>], reach: f64) -> Self {
        let Some(Configuration { model, points, .. }) = ways.first().map(|way| way.from) else {
            return Self::default();
        };
        if ways.iter().all(|way| way.are_solids_apart(reach)) {
            return Self::default();
        }
        let configurations: Vec<_> =
            ways.iter().flat_map(|way| [way.from.positions(), way.to.positions()]).collect();
        let rigid = |body: u32| model.solids[body as usize].elastic().is_none();
        let feature_pairs =
            points.surface.nearby_pairs(&configurations, reach, rigid, |p| points.is_prescribed(p));
        let ends = configurations.chunks_exact(2);
        let mut sdf_pairs: Vec<SdfPair> = ways
            .iter()
            .zip(ends)
            .flat_map(|(way, ends)| find_sdf_pairs(*way, &ends[0], &ends[1], reach))
            .collect();
        sdf_pairs.sort_unstable();
        sdf_pairs.dedup();
        CandidatePairs { feature_pairs, sdf_pairs }
    }

    /// Pairs of points with rigid solids and sides only.
    pub fn sdf_pairs_along<const D: usize>(sweep: Sweep<'_, D>, reach: f64) -> Vec<SdfPair> {
        find_sdf_pairs(sweep, &sweep.from.positions(), &sweep.to.positions(), reach)
    }
}

/// Pairs of points with rigid solids and sides whose distance falls below `reach` (m) during the sweep.
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
                let close = |part: &usize| sweep.from.distance_to_rigid(solid, *part, &start[k]) < near;
                meetings.extend((0..parts).filter(close).map(|part| SdfPair::Rigid(*p, solid, part)));
            }
        }
    }
    meetings
}

/// Two configurations of all solids; points move on straight paths between them.
#[derive(Clone, Copy)]
pub struct Sweep<'a, const D: usize> {
    /// The start.
    pub from: &'a Configuration<'a, D>,
    /// The end.
    pub to: &'a Configuration<'a, D>,
}

/// Bound of the length of a point's path in the frame of a rigid solid, relative to its chord. For a rotation
/// by `θ` the ratio is `(θ/2)/sin(θ/2)`, which stays below this value up to 2.99 radians a step. For a general
/// relative motion it is a bound to second order in `θ` only.
const MAX_ARC_CHORD_RATIO: f64 = 1.5;

impl<const D: usize> Sweep<'_, D> {
    /// Bound, m, of the length of a point's path from `start` to `end` in the frame of a rigid solid
    /// ([`MAX_ARC_CHORD_RATIO`]).
    pub fn path_length_bound(&self, solid: usize, start: &Vector<D>, end: &Vector<D>) -> f64 {
        (self.to.to_reference(solid, end) - self.from.to_reference(solid, start)).norm() * MAX_ARC_CHORD_RATIO
    }

    /// Whether boxes around rigid solids show that no point comes within `reach` (m) of another solid or side; `false` if one deforms.
    fn are_solids_apart(&self, reach: f64) -> bool {
        let solids = &self.from.model.solids;
        solids.iter().all(|solid| solid.elastic().is_none())
            && (0..solids.len()).all(|solid| self.is_apart(solid, reach).unwrap_or(false))
    }

    /// Whether the points of a rigid solid keep a distance of `reach` (m), by the box around it; `None` if a box is not bounded. The length
    /// of a point's path relative to another solid is a convex function of its initial position, and thus largest at a corner of the box.
    fn is_apart(&self, solid: usize, reach: f64) -> Option<bool> {
        let (start, end) = (self.from.box_corners(solid)?, self.to.box_corners(solid)?);
        let nearest_side = self
            .from
            .points
            .domain_sides
            .iter()
            .flat_map(|side| start.iter().chain(&end).map(|corner| side.distance(corner)));
        let [low, high] = self.from.bounds(solid);
        let is_far = |other: usize| {
            let [other_low, other_high] = self.from.bounds(other);
            let path = start.iter().zip(&end).map(|(s, e)| self.path_length_bound(other, s, e));
            let gap = (other_low - high).sup(&(low - other_high)).max();
            gap > reach + path.fold(0.0, f64::max)
        };
        let mut others = (0..self.from.model.solids.len()).filter(|other| *other != solid);
        Some(nearest_side.fold(f64::INFINITY, f64::min) > reach && others.all(is_far))
    }
}
