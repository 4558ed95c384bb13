//! Points of all solids' surfaces, and what moves them.
//!
//! A solid that deforms moves with the nodes of its mesh, a rigid one with two: its velocity, and its angular velocity (2D: the
//! first component). Points are functions of the nodes' velocities `v`: `x + a v` of a vertex, `c + a v + exp(a ω) r` of a point
//! of a rigid solid.

use super::meet::{Candidates, Meeting, Way};
use crate::model::{Model, Wall};
use crate::solid::{Motion, Solid, SolidState};
use meniscus_contact::{Plane, Surface};
use meniscus_elastic::{Assembly, Elastic};
use meniscus_numerics::{Matrix, Vector};
use std::collections::BTreeMap;

/// Reach of the barrier, in cells: two surfaces in contact are within half a cell of each other, so that the grid does not see the gap
/// between them.
pub const REACH: f64 = 0.25;
/// The least reach of a point, over [`REACH`]: one that touches something at the start needs some distance over which the barrier
/// rises, and the barrier's energy of a contact is proportional to it.
const LEAST: f64 = 0.1;
/// Distance of probes of rigid solids, in cells.
const EDGE: f64 = 0.5;

/// What a point is part of.
#[derive(Clone, Copy, Debug)]
pub enum Owner<const D: usize> {
    /// A vertex of a solid that deforms: its node.
    Vertex {
        /// Number of the solid.
        solid: usize,
        /// Number of the vertex in its mesh.
        vertex: usize,
    },
    /// A place of a rigid solid at the start.
    Rigid {
        /// Number of the solid.
        solid: usize,
        /// Where it was at the start, m.
        at: Vector<D>,
    },
}

impl<const D: usize> Owner<D> {
    /// Number of the solid.
    pub fn solid(&self) -> usize {
        match self {
            Self::Vertex { solid, .. } | Self::Rigid { solid, .. } => *solid,
        }
    }
}

/// The points of a model's solids.
#[derive(Clone, Debug, Default)]
pub struct Points<const D: usize> {
    /// Their surfaces: facets of those that deform, and points of the others.
    pub surface: Surface<D>,
    /// What each point is part of.
    pub owners: Vec<Owner<D>>,
    /// The first node of each solid.
    pub first: Vec<usize>,
    /// Which nodes have velocities that are told.
    pub held: Vec<bool>,
    /// Pressure of each solid's weight on one of the `2 D` sides of its surface, Pa; 0 of those that are told.
    pub weights: Vec<f64>,
    /// Closed sides of the domain.
    pub sides: Vec<Plane<D>>,
    /// Distance, m, that is added to that of a point and something without facets, where they touch or overlap at the start (a solid
    /// on the floor; one that is held within a rigid solid).
    lifts: BTreeMap<Meeting, f64>,
    /// How the solids' matrices stand in one; none where no solid deforms, or memory does not suffice.
    pub assembly: Option<Assembly>,
}

impl<const D: usize> Points<D> {
    /// Of a model.
    pub fn of(model: &Model<D>) -> Self {
        let (mut owners, mut facets, mut rest, mut bodies) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let (mut first, mut nodes) = (Vec::new(), 0);
        for (solid, is) in model.solids.iter().enumerate() {
            first.push(nodes);
            nodes += is.elastic().map_or(2, |elastic| elastic.masses().len());
            let Some(elastic) = is.elastic() else { continue };
            let (surface, vertices) = elastic.mesh().surface();
            let from = owners.len() as u32;
            owners.extend(vertices.iter().map(|v| Owner::Vertex { solid, vertex: *v as usize }));
            rest.extend_from_slice(&surface.positions);
            facets.extend(surface.facets.iter().map(|f| f.map(|v| v + from)));
        }
        bodies.extend(owners.iter().map(|o: &Owner<D>| o.solid() as u32));
        let (edge, mut probes) = (EDGE * model.grid.dx, Vec::new());
        for (solid, is) in model.solids.iter().enumerate() {
            if is.elastic().is_some() || model.wetting_walls() == Some(solid) {
                continue;
            }
            for probe in is.shape.probes(edge) {
                probes.push((owners.len() as u32, edge.powi(D as i32 - 1), probe.radius));
                owners.push(Owner::Rigid { solid, at: probe.at });
                rest.push(probe.at);
                bodies.push(solid as u32);
            }
        }
        let surface = Surface::new(facets, &rest, bodies).with_points(probes);
        let mut areas = vec![0.0; model.solids.len()];
        surface.points().iter().for_each(|p| areas[owners[*p as usize].solid()] += surface.area(*p));
        let weight = |(solid, area): (&Solid<D>, &f64)| {
            let told = solid.motion.is_told() || *area == 0.0;
            if told { 0.0 } else { solid.body.mass * model.gravity.norm() * (2 * D) as f64 / area }
        };
        let weights = model.solids.iter().zip(&areas).map(weight).collect();
        let held = held(model);
        let deforming = model.solids.iter().zip(&first).filter_map(|(s, first)| Some((*first, s.elastic()?)));
        let deforming: Vec<(usize, &Elastic<D>)> = deforming.collect();
        let assembly = if deforming.is_empty() { None } else { Assembly::new(&deforming, held.clone()) };
        let (sides, lifts) = (sides(model), BTreeMap::new());
        let mut all = Self { surface, owners, first, held, weights, sides, lifts, assembly };
        all.fit_to_start(model);
        all
    }

    /// Reduces the reach of points that are within the barrier's reach of something at the start to that distance, so that no contact
    /// pushes at the start. No reach is less than a part [`LEAST`] of the barrier's.
    fn fit_to_start(&mut self, model: &Model<D>) {
        let (reach, still) = (REACH * model.grid.dx, vec![Vector::zeros(); self.nodes()]);
        let start: Vec<SolidState<D>> = model.solids.iter().map(Solid::start).collect();
        let places = Places::new(model, &start, self, &still, 0.0);
        let at = places.all();
        // A rigid solid that a facet touches is kept off by the distances of the facet's points from it.
        let near = Candidates::on(Way { from: &places, to: &places }, reach).near;
        let touching = near.distances(&at).filter(|(_, gap)| *gap < LEAST * reach);
        let rigid = |p: u32| matches!(self.owners[p as usize], Owner::Rigid { .. });
        let solid = |p: u32| self.owners[p as usize].solid() as u32;
        let apart = touching.filter(|([p, _], _)| rigid(*p)).map(|([p, q], _)| (p, solid(q))).collect();
        self.surface = std::mem::take(&mut self.surface).without(apart);
        let places = Places::new(model, &start, self, &still, 0.0);
        let candidates = Candidates::on(Way { from: &places, to: &places }, reach);
        let mut reaches = candidates.near.least_distances(&at);
        let mut lifts = BTreeMap::new();
        for meeting in &candidates.meetings {
            let p = meeting.point();
            let distance = meeting.distance(&places, &at[p as usize]) - self.surface.radius(p);
            let nearest = LEAST * reach;
            if distance < nearest {
                lifts.insert(*meeting, nearest - distance);
            }
            reaches[p as usize] = reaches[p as usize].min(distance.max(nearest));
        }
        reaches.iter_mut().for_each(|r| *r = if *r < reach { r.max(LEAST * reach) } else { f64::INFINITY });
        self.surface = std::mem::take(&mut self.surface).with_reaches(reaches);
        self.lifts = lifts;
    }

    /// Distance, m, that counts as none between a point and something without facets.
    pub fn thickness(&self, meeting: &Meeting) -> f64 {
        self.surface.radius(meeting.point()) - self.lifts.get(meeting).copied().unwrap_or(0.0)
    }

    /// Velocities of the nodes as solids move now.
    pub fn velocities(&self, model: &Model<D>, solids: &[SolidState<D>]) -> Vec<Vector<D>> {
        let mut all = Vec::with_capacity(self.nodes());
        for (_, now) in model.solids.iter().zip(solids) {
            match &now.soft {
                Some(soft) => all.extend_from_slice(&soft.body.velocities),
                None => all.extend([now.velocity, turning(&now.spin)]),
            }
        }
        all
    }

    /// Gives the solids the velocities of the nodes.
    pub fn give(&self, model: &Model<D>, solids: &mut [SolidState<D>], velocities: &[Vector<D>]) {
        for (k, (solid, now)) in model.solids.iter().zip(solids).enumerate() {
            let own = &velocities[self.first[k]..];
            if let (Some(soft), Some(elastic)) = (&mut now.soft, solid.elastic()) {
                let count = soft.body.velocities.len();
                soft.body.velocities.copy_from_slice(&own[..count]);
                now.follow(elastic);
            } else if solid.motion == Motion::Free {
                (now.velocity, now.spin) = (own[0], spin(&own[1]));
            }
        }
    }

    /// Number of nodes.
    pub fn nodes(&self) -> usize {
        self.held.len()
    }
}

/// The narrowest gap, m, between surfaces of solids that deform, each other's or their own, where they start, with the numbers of the
/// two solids; nothing where all gaps are wider than the barrier's reach. A run needs a gap: the barrier is infinite where there is none.
pub fn narrowest_gap<const D: usize>(model: &Model<D>) -> Option<(usize, usize, f64)> {
    let points = Points::of(model);
    let start: Vec<SolidState<D>> = model.solids.iter().map(Solid::start).collect();
    let still = vec![Vector::zeros(); points.nodes()];
    let places = Places::new(model, &start, &points, &still, 0.0);
    let near = Candidates::on(Way { from: &places, to: &places }, REACH * model.grid.dx).near;
    let at = places.all();
    let ([one, other], gap) = near.distances(&at).min_by(|a, b| a.1.total_cmp(&b.1))?;
    let solid = |p: u32| points.owners[p as usize].solid();
    Some((solid(one), solid(other), gap))
}

/// The closed sides of the domain.
fn sides<const D: usize>(model: &Model<D>) -> Vec<Plane<D>> {
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

/// Which nodes have velocities that are told.
fn held<const D: usize>(model: &Model<D>) -> Vec<bool> {
    let of = |solid: &Solid<D>| match solid.elastic() {
        Some(elastic) => elastic.held().to_vec(),
        None => vec![solid.motion.is_told(); 2],
    };
    model.solids.iter().flat_map(of).collect()
}

/// An angular velocity as a node has it.
pub fn turning<const D: usize>(spin: &[f64; 3]) -> Vector<D> {
    Vector::from_fn(|a, _| {
        if D == 3 {
            spin[a]
        } else if a == 0 {
            spin[2]
        } else {
            0.0
        }
    })
}

/// A node's angular velocity.
pub fn spin<const D: usize>(node: &Vector<D>) -> [f64; 3] {
    if D == 3 { std::array::from_fn(|a| node[a]) } else { [0.0, 0.0, node[0]] }
}

/// Solids somewhere on the way of a step.
pub struct Places<'a, const D: usize> {
    /// The model.
    pub model: &'a Model<D>,
    solids: &'a [SolidState<D>],
    /// The solids' points.
    pub points: &'a Points<D>,
    /// Velocities of the nodes.
    velocities: &'a [Vector<D>],
    /// For how long they go on, s.
    time: f64,
    frames: Vec<Frame<D>>,
}

/// Where a rigid solid is.
#[derive(Clone, Copy, Debug)]
struct Frame<const D: usize> {
    center: Vector<D>,
    rotation: Matrix<D>,
    /// What its angular velocity does to the rate at which it turns at the end: the left Jacobian of the exponential.
    rate: Matrix<3>,
}

/// How a point follows a node: the node, and the derivative of the point's position by the node's velocity over the time.
pub type Lever<const D: usize> = (usize, Matrix<D>);

impl<'a, const D: usize> Places<'a, D> {
    /// After a time with these velocities.
    pub fn new(
        model: &'a Model<D>,
        solids: &'a [SolidState<D>],
        points: &'a Points<D>,
        velocities: &'a [Vector<D>],
        time: f64,
    ) -> Self {
        let frame = |(k, now): (usize, &SolidState<D>)| {
            if now.soft.is_some() {
                return Frame {
                    center: Vector::zeros(),
                    rotation: Matrix::identity(),
                    rate: Matrix::identity(),
                };
            }
            let [velocity, turn] = [velocities[points.first[k]], velocities[points.first[k] + 1]];
            let turn = Vector::<3>::from(spin(&turn)) * time;
            let rotation = nalgebra::Rotation3::new(turn).into_inner();
            let rotation = Matrix::<D>::from_fn(|r, c| rotation[(r, c)]) * now.rotation;
            Frame { center: now.center + velocity * time, rotation, rate: left(&turn) }
        };
        let frames = solids.iter().enumerate().map(frame).collect();
        Self { model, solids, points, velocities, time, frames }
    }

    /// Where a point is, m.
    pub fn at(&self, owner: &Owner<D>) -> Vector<D> {
        match *owner {
            Owner::Vertex { solid, vertex } => {
                let from =
                    self.solids[solid].soft.as_ref().map_or(Vector::zeros(), |s| s.body.positions[vertex]);
                from + self.velocities[self.points.first[solid] + vertex] * self.time
            }
            Owner::Rigid { solid, at } => {
                let frame = &self.frames[solid];
                frame.center + frame.rotation * (at - self.model.solids[solid].body.center)
            }
        }
    }

    /// Where all points are, m.
    pub fn all(&self) -> Vec<Vector<D>> {
        self.points.owners.iter().map(|owner| self.at(owner)).collect()
    }

    /// Where the point of a rigid solid that is at `x` was at the start, m.
    pub fn at_start(&self, solid: usize, x: &Vector<D>) -> Vector<D> {
        let frame = &self.frames[solid];
        self.model.solids[solid].body.center + frame.rotation.tr_mul(&(x - frame.center))
    }

    /// Distance of a point from a rigid solid, m, and the direction away from that.
    pub fn distance_to_rigid(&self, solid: usize, x: &Vector<D>) -> (f64, Vector<D>) {
        let shape = &self.model.solids[solid].shape;
        let at = self.at_start(solid, x);
        let step = 1e-4 * self.model.grid.dx;
        let slope = Vector::<D>::from_fn(|a, _| {
            let by = Vector::<D>::from_fn(|b, _| if a == b { step } else { 0.0 });
            shape.signed_distance(&(at + by)) - shape.signed_distance(&(at - by))
        });
        let normal = slope.try_normalize(0.0).unwrap_or(Vector::zeros());
        (shape.signed_distance(&at), self.frames[solid].rotation * normal)
    }

    /// How a point follows the nodes.
    pub fn levers(&self, owner: &Owner<D>) -> Vec<Lever<D>> {
        match *owner {
            Owner::Vertex { solid, vertex } => vec![(self.points.first[solid] + vertex, Matrix::identity())],
            Owner::Rigid { solid, .. } => {
                let frame = &self.frames[solid];
                let arm = self.at(owner) - frame.center;
                let arm = Vector::<3>::from_fn(|a, _| if a < D { arm[a] } else { 0.0 });
                let turned = -arm.cross_matrix() * frame.rate;
                // In 2D the node's first component turns about the third axis.
                let turn = Matrix::<D>::from_fn(|r, c| match D {
                    2 if c == 0 => turned[(r, 2)],
                    2 => 0.0,
                    _ => turned[(r, c)],
                });
                let node = self.points.first[solid];
                vec![(node, Matrix::identity()), (node + 1, turn)]
            }
        }
    }
}

/// The left Jacobian of the exponential of a rotation: `(exp((θ + δ)×) ≈ exp((J δ)×) exp(θ×))`.
fn left(turn: &Vector<3>) -> Matrix<3> {
    let (angle, cross) = (turn.norm(), turn.cross_matrix());
    // Series where differences would be of nearly equal numbers.
    let (first, second) = if angle < 1e-3 {
        (0.5 - angle * angle / 24.0, 1.0 / 6.0 - angle * angle / 120.0)
    } else {
        ((1.0 - angle.cos()) / (angle * angle), (angle - angle.sin()) / angle.powi(3))
    };
    Matrix::<3>::identity() + cross * first + cross * cross * second
}
