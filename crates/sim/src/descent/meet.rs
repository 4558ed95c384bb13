//! What may meet on the way from some places of all solids to others.

use super::points::{Owner, Places};
use crate::model::{Model, Wall};
use meniscus_contact::{Near, Plane};
use meniscus_numerics::Vector;

/// A point that meets something that has no facets.
#[derive(Clone, Copy, Debug)]
pub enum Meeting {
    /// A point and a rigid solid.
    Rigid(u32, usize),
    /// A point and a side of the domain.
    Side(u32, usize),
}

impl Meeting {
    /// The point, and its distance from the other, m, where points are `at` some places.
    pub fn distance<const D: usize>(&self, places: &Places<'_, D>, at: &[Vector<D>]) -> (u32, f64) {
        match *self {
            Self::Rigid(p, solid) => (p, places.distance_to_rigid(solid, &at[p as usize]).0),
            Self::Side(p, side) => (p, sides(places.model)[side].distance(&at[p as usize])),
        }
    }
}

/// What may meet.
#[derive(Clone, Debug, Default)]
pub struct Candidates {
    /// Points and facets, edges and edges.
    pub near: Near,
    /// Points and what has no facets.
    pub meetings: Vec<Meeting>,
}

impl Candidates {
    /// What comes nearer than `reach` (m) on the way, and some more.
    pub fn between<const D: usize>(one: &Places<'_, D>, other: &Places<'_, D>, reach: f64) -> Self {
        let (model, points) = (one.model, one.points);
        let (start, end) = (one.all(), other.all());
        let ways: Vec<Vector<D>> = end.iter().zip(&start).map(|(e, s)| e - s).collect();
        let rigid = |body: u32| model.solids[body as usize].elastic().is_none();
        let still = |p: u32| match points.owners[p as usize] {
            Owner::Vertex { solid, vertex } => points.held[points.first[solid] + vertex],
            Owner::Rigid { solid, .. } => model.solids[solid].motion.is_told(),
        };
        let near = points.surface.near(&start, &ways, reach, rigid, still);
        let mut meetings = Vec::new();
        for (side, plane) in sides(model).iter().enumerate() {
            let close = plane.near(&points.surface, &start, &ways, reach);
            meetings.extend(close.into_iter().filter(|p| !still(*p)).map(|p| Meeting::Side(p, side)));
        }
        for solid in (0..model.solids.len()).filter(|k| rigid(*k as u32) && model.wetting_walls() != Some(*k))
        {
            let told = model.solids[solid].motion.is_told();
            for p in points.surface.points() {
                let owner = &points.owners[*p as usize];
                if owner.solid() == solid || told && still(*p) {
                    continue;
                }
                let k = *p as usize;
                let wide = reach + points.surface.radius(*p);
                let way = relative((one, other), solid, (&start[k], &end[k]));
                if one.distance_to_rigid(solid, &start[k]).0 < wide + way {
                    meetings.push(Meeting::Rigid(*p, solid));
                }
            }
        }
        Candidates { near, meetings }
    }
}

/// The closed sides of the domain.
pub fn sides<const D: usize>(model: &Model<D>) -> Vec<Plane<D>> {
    let upper = model.grid.upper();
    let mut all = Vec::new();
    for a in 0..D {
        for (up, wall) in model.walls[a].iter().enumerate() {
            if *wall == Wall::Slip {
                let sign = 1.0 - 2.0 * up as f64;
                let normal = Vector::from_fn(|b, _| if a == b { sign } else { 0.0 });
                all.push(Plane { point: if up == 0 { Vector::zeros() } else { upper }, normal });
            }
        }
    }
    all
}

/// A bound of the way of a point as a rigid solid sees it, m, between two places of both.
pub fn relative<const D: usize>(
    (one, other): (&Places<'_, D>, &Places<'_, D>),
    solid: usize,
    (start, end): (&Vector<D>, &Vector<D>),
) -> f64 {
    (other.at_start(solid, end) - one.at_start(solid, start)).norm() * 1.5
}
