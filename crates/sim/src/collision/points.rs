//! Points of all solids' surfaces, and what moves them.
//!
//! A solid that deforms moves with the nodes of its mesh, a rigid one with two: its velocity, and its angular velocity (2D: the
//! first component). Points are functions of the nodes' velocities `v`: `x + a v` of a vertex, `c + a v + exp(a ω) r` of a point
//! of a rigid solid.

use super::broad_phase::{Candidates, Meeting, Way};
use crate::model::{Model, Wall};
use crate::solid::{Motion, Solid, SolidState};
use meniscus_contact::{Near, Plane, Surface};
use meniscus_elastic::{Assembly, Elastic};
use meniscus_numerics::mesh::surface::area_vector;
use meniscus_numerics::shape::Shape;
use meniscus_numerics::{Matrix, Vector};
use std::collections::BTreeMap;

/// Reach of the barrier, in cells: two surfaces in contact are within half a cell of each other, so that the grid does not see the gap
/// between them.
pub const REACH: f64 = 0.25;
/// The least reach of a point, over [`REACH`]: one that touches something at the start needs some distance over which the barrier
/// rises, and the barrier's energy of a contact is proportional to it.
const LEAST: f64 = 0.1;
/// Distance of probes of rigid solids, in cells: a surface of a radius of five cells bulges out between them by less than 0.01 cells.
const EDGE: f64 = 0.5;
/// Step of the differences of a distance, in cells.
const STEP: f64 = 1e-4;

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
    /// Pressure of each solid's weight on one of the `2 D` sides of its surface, and that which takes the kinetic energy of the fastest
    /// start within the barrier's reach, Pa; 0 of those that are told.
    pub pressures: Vec<f64>,
    /// Mean area of one of the `2 D` sides of each solid's surface, m² (2D: m).
    pub faces: Vec<f64>,
    /// Closed sides of the domain.
    pub sides: Vec<Plane<D>>,
    /// Distance, m, that is added to that of a point and something without facets, where they touch or overlap at the start (a solid
    /// on the floor; one that is held within a rigid solid).
    lifts: BTreeMap<Meeting, f64>,
    /// Which points of each rigid solid may meet each other one.
    probing: BTreeMap<(usize, usize), Probing>,
    /// Points of rigid solids at edges and corners, or with a ball around them.
    exposed: Vec<bool>,
    /// How the solids' matrices stand in one; none where memory does not suffice.
    pub assembly: Option<Assembly>,
}

/// Which points of a rigid solid may meet another one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Probing {
    /// All of them: of two solids it is the smaller one.
    All,
    /// Those at edges and corners only: what glides along a wide face meets that by its own points.
    Exposed,
    /// None: the other one is round, this one is convex, and the distances of the other's centres are enough.
    None,
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
        let (edge, mut probes, mut exposed) = (EDGE * model.grid.dx, Vec::new(), vec![true; owners.len()]);
        for (solid, is) in model.solids.iter().enumerate() {
            if is.elastic().is_some() || model.wetting_walls() == Some(solid) {
                continue;
            }
            for probe in is.shape.probes(edge) {
                probes.push((owners.len() as u32, edge.powi(D as i32 - 1), probe.radius));
                owners.push(Owner::Rigid { solid, at: probe.at });
                rest.push(probe.at);
                bodies.push(solid as u32);
                exposed.push(probe.sharp || probe.radius > 0.0);
            }
        }
        let surface = Surface::new(facets, &rest, bodies).with_points(probes);
        let mut areas = vec![0.0; model.solids.len()];
        surface.points().iter().for_each(|p| areas[owners[*p as usize].solid()] += surface.area(*p));
        let fastest = model.solids.iter().map(start_speed).fold(0.0, f64::max);
        let stop = 0.5 * fastest * fastest / (REACH * model.grid.dx);
        let pressure = |(solid, area): (&Solid<D>, &f64)| {
            let told = solid.motion.is_told() || *area == 0.0;
            let weight = model.gravity.norm() * (2 * D) as f64;
            if told { 0.0 } else { solid.body.mass * (weight + stop) / area }
        };
        let pressures = model.solids.iter().zip(&areas).map(pressure).collect();
        let faces = areas.iter().map(|area| area / (2 * D) as f64).collect();
        let held = held(model);
        let deforming = model.solids.iter().zip(&first).filter_map(|(s, first)| Some((*first, s.elastic()?)));
        let deforming: Vec<(usize, &Elastic<D>)> = deforming.collect();
        let assembly = Assembly::new(&deforming, held.clone());
        let (sides, lifts, probing) = (sides(model), BTreeMap::new(), probing(model));
        let mut all =
            Self { surface, owners, first, held, pressures, faces, sides, lifts, probing, exposed, assembly };
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
        let near = Candidates::on(Way { from: &places, to: &places }, reach).near;
        self.draw_back(&near, &at, LEAST * reach);
        let places = Places::new(model, &start, self, &still, 0.0);
        let at = places.all();
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

    /// Draws points of rigid solids that touch facets at the start back into their solids, to a distance of `least` (m).
    fn draw_back(&mut self, near: &Near, at: &[Vector<D>], least: f64) {
        let mut moves: BTreeMap<u32, (f64, Vector<D>)> = BTreeMap::new();
        for (stencil, gap) in near.gaps(at).filter(|(_, gap)| *gap < least) {
            let (point, rest) = (stencil.points()[0], stencil.points().get(stencil.kind.first()..));
            let Some(facet) = rest.and_then(|rest| <[u32; D]>::try_from(rest).ok()) else { continue };
            let outward = area_vector(&facet.map(|p| at[p as usize])).try_normalize(0.0);
            let known = moves.get(&point).is_some_and(|(known, _)| *known <= gap);
            if let Some(outward) = outward.filter(|_| !known && stencil.kind.first() == 1) {
                moves.insert(point, (gap, outward));
            }
        }
        for (point, (gap, outward)) in moves {
            if let Owner::Rigid { at, .. } = &mut self.owners[point as usize] {
                *at += outward * (least - gap);
            }
        }
    }

    /// Distance, m, that counts as none between a point and something without facets.
    pub fn thickness(&self, meeting: &Meeting) -> f64 {
        self.surface.radius(meeting.point()) - self.lifts.get(meeting).copied().unwrap_or(0.0)
    }

    /// Whether a point may meet a rigid solid: not one of its own, and not where both stay or go as told.
    pub fn may_meet(&self, model: &Model<D>, point: u32, solid: usize) -> bool {
        let owner = &self.owners[point as usize];
        if owner.solid() == solid || model.solids[solid].motion.is_told() && self.is_told(point) {
            return false;
        }
        match self.probing.get(&(owner.solid(), solid)) {
            Some(Probing::None) => false,
            Some(Probing::Exposed) => self.exposed[point as usize],
            Some(Probing::All) | None => true,
        }
    }

    /// Whether a point stays or goes as told.
    pub fn is_told(&self, point: u32) -> bool {
        self.held[match self.owners[point as usize] {
            Owner::Vertex { solid, vertex } => self.first[solid] + vertex,
            Owner::Rigid { solid, .. } => self.first[solid],
        }]
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
    let (stencil, gap) = near.gaps(&at).min_by(|a, b| a.1.total_cmp(&b.1))?;
    let solid = |k: usize| points.owners[stencil.points()[k] as usize].solid();
    Some((solid(0), solid(stencil.kind.first()), gap))
}

/// The narrowest gap, m, between a solid and another one, itself, or a closed side of the domain, as they are now, with their numbers (none
/// for a side); nothing where all gaps are wider than the barrier's reach.
pub fn narrowest_gap_now<const D: usize>(
    model: &Model<D>,
    solids: &[SolidState<D>],
) -> Option<(usize, Option<usize>, f64)> {
    let points = Points::of(model);
    let still = vec![Vector::zeros(); points.nodes()];
    let places = Places::new(model, solids, &points, &still, 0.0);
    let Candidates { near, meetings } =
        Candidates::on(Way { from: &places, to: &places }, REACH * model.grid.dx);
    let at = places.all();
    let solid = |point: u32| points.owners[point as usize].solid();
    let facets = near.gaps(&at).map(|(stencil, gap)| {
        let points = stencil.points();
        (solid(points[0]), Some(solid(points[stencil.kind.first()])), gap)
    });
    let others = meetings.iter().map(|m| {
        let gap = m.distance(&places, &at[m.point() as usize]) - points.thickness(m);
        (solid(m.point()), m.solid(), gap)
    });
    facets.chain(others).min_by(|a, b| a.2.total_cmp(&b.2))
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

/// The speed with which a solid starts, or the largest with which it goes as told, m/s.
fn start_speed<const D: usize>(solid: &Solid<D>) -> f64 {
    match &solid.motion {
        Motion::Given(path) => {
            let between = |k: &[(f64, Vector<D>); 2]| (k[1].1 - k[0].1).norm() / (k[1].0 - k[0].0);
            let frames = path.keyframes.array_windows().map(between);
            let start = solid.start();
            frames.fold(solid.largest_speed(&SolidState { velocity: path.velocity, ..start }), f64::max)
        }
        _ => solid.velocity.norm(),
    }
}

/// How each rigid solid is probed against each other one.
fn probing<const D: usize>(model: &Model<D>) -> BTreeMap<(usize, usize), Probing> {
    let size = |k: usize| {
        let (low, high) = model.solids[k].shape.bounds();
        (high - low).norm()
    };
    let rigid: Vec<usize> =
        (0..model.solids.len()).filter(|k| model.solids[*k].elastic().is_none()).collect();
    let round = |k: usize| matches!(model.solids[k].shape, Shape::Ball { .. } | Shape::Capsule { .. });
    let mut all = BTreeMap::new();
    for i in &rigid {
        for j in rigid.iter().filter(|j| *j < i) {
            let (small, large) = if size(*i) <= size(*j) { (*i, *j) } else { (*j, *i) };
            all.insert((small, large), Probing::All);
            let centred = round(small) && model.solids[large].shape.is_convex();
            all.insert((large, small), if centred { Probing::None } else { Probing::Exposed });
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

    /// The time, s.
    pub fn time(&self) -> f64 {
        self.time
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

    /// A box around a rigid solid, m.
    pub fn bounds(&self, solid: usize) -> [Vector<D>; 2] {
        let frame = &self.frames[solid];
        let now = SolidState { center: frame.center, rotation: frame.rotation, ..self.solids[solid].clone() };
        self.model.solids[solid].bounds(&now)
    }

    /// Where the point of a rigid solid that is at `x` was at the start, m.
    pub fn at_start(&self, solid: usize, x: &Vector<D>) -> Vector<D> {
        let frame = &self.frames[solid];
        self.model.solids[solid].body.center + frame.rotation.tr_mul(&(x - frame.center))
    }

    /// Distance of a point from a part of a rigid solid, m.
    pub fn distance_to_rigid(&self, (solid, part): (usize, usize), x: &Vector<D>) -> f64 {
        self.part(solid, part).signed_distance(&self.at_start(solid, x))
    }

    /// The direction away from that; any where there is none.
    pub fn away_from_rigid(&self, (solid, part): (usize, usize), x: &Vector<D>) -> Vector<D> {
        let up = Vector::from_fn(|a, _| if a + 1 == D { 1.0 } else { 0.0 });
        let normal = self.part(solid, part).normal(&self.at_start(solid, x), STEP * self.model.grid.dx);
        self.frames[solid].rotation * if normal.norm_squared() > 0.0 { normal } else { up }
    }

    fn part(&self, solid: usize, part: usize) -> &'a Shape<D> {
        match &self.model.solids[solid].shape {
            whole @ Shape::Union(_) => whole.parts()[part],
            whole => whole,
        }
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
