//! Broad phase of contact: pairs of features that may touch while all solids go from one configuration to another.

use super::places::Places;
use super::points::Meeting;
use meniscus_contact::Near;
use meniscus_numerics::Vector;

/// The pairs that the broad phase has found.
#[derive(Clone, Debug, Default)]
pub struct Candidates {
    /// Points and facets, edges and edges.
    pub near: Near,
    /// Points and rigid solids, points and sides of the domain.
    pub meetings: Vec<Meeting>,
}

impl Candidates {
    /// All pairs whose distance falls below `reach` and a `margin` (m) on one of the ways; a few that stay farther apart may be among
    /// them.
    pub fn on<const D: usize>(ways: &[Way<'_, D>], reach: f64, margin: f64) -> Self {
        let Some(Places { model, points, .. }) = ways.first().map(|way| way.from) else {
            return Self::default();
        };
        let configurations: Vec<_> = ways.iter().flat_map(|way| [way.from.all(), way.to.all()]).collect();
        let rigid = |body: u32| model.solids[body as usize].elastic().is_none();
        let near = points.surface.near(&configurations, reach, margin, rigid, |p| points.is_told(p));
        let ends = configurations.chunks_exact(2);
        let mut meetings: Vec<Meeting> = ways
            .iter()
            .zip(ends)
            .flat_map(|(way, ends)| meetings(*way, &ends[0], &ends[1], reach + margin))
            .collect();
        meetings.sort_unstable();
        meetings.dedup();
        Candidates { near, meetings }
    }

    /// Those of points with what has no facets.
    pub fn of_rigid<const D: usize>(way: Way<'_, D>, reach: f64) -> Vec<Meeting> {
        meetings(way, &way.from.all(), &way.to.all(), reach)
    }
}

/// Points and what has no facets whose distance falls below `reach` (m) on the way.
fn meetings<const D: usize>(
    way: Way<'_, D>,
    start: &[Vector<D>],
    end: &[Vector<D>],
    reach: f64,
) -> Vec<Meeting> {
    let Places { model, points, .. } = *way.from;
    let ways: Vec<Vector<D>> = end.iter().zip(start).map(|(e, s)| e - s).collect();
    let mut meetings = Vec::new();
    for (side, plane) in points.sides.iter().enumerate() {
        let close = plane.near(&points.surface, start, &ways, reach);
        meetings.extend(close.into_iter().filter(|p| !points.is_told(*p)).map(|p| Meeting::Side(p, side)));
    }
    let rigid = |k: &usize| model.solids[*k].elastic().is_none() && model.wetting_walls() != Some(*k);
    for solid in (0..model.solids.len()).filter(rigid) {
        let parts = model.solids[solid].shape.parts().len();
        let [low, high] = way.from.bounds(solid);
        for p in points.surface.points() {
            let k = *p as usize;
            let near = reach + points.surface.radius(*p) + way.seen_from(solid, &start[k], &end[k]);
            let far = |a: usize| (low[a] - start[k][a]).max(start[k][a] - high[a]) > near;
            if !(0..D).any(far) && points.may_meet(model, *p, solid) {
                let close = |part: &usize| way.from.distance_to_rigid((solid, *part), &start[k]) < near;
                meetings.extend((0..parts).filter(close).map(|part| Meeting::Rigid(*p, solid, part)));
            }
        }
    }
    meetings
}

/// Two configurations of all solids; points go straight from the one to the other.
#[derive(Clone, Copy)]
pub struct Way<'a, const D: usize> {
    /// Where it starts.
    pub from: &'a Places<'a, D>,
    /// Where it ends.
    pub to: &'a Places<'a, D>,
}

/// Length of a point's path in the frame of a rigid solid, over the distance of its ends there: where it turns, the path is an
/// arc, longer than its chord by `(θ/2)/sin(θ/2)`, less than this up to 2.6 radians a step.
const ARC: f64 = 1.5;

impl<const D: usize> Way<'_, D> {
    /// A bound, m, of the length of a point's path from `start` to `end` in the frame of a rigid solid.
    pub fn seen_from(&self, solid: usize, start: &Vector<D>, end: &Vector<D>) -> f64 {
        (self.to.at_start(solid, end) - self.from.at_start(solid, start)).norm() * ARC
    }
}
