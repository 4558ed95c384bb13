//! What the velocities of all solids make least in a step: an incremental potential (M. Li et al. 2020).
//!
//! Of each solid that deforms that of [`Incremental`], of each rigid one `½ (V − V*)ᵀ M (V − V*)` about the velocities `V*` that all
//! other forces give it; of all together `h/a` times the barriers between them at the end of the coming step, of length `a`, and what
//! friction holds them with on the way there.

use super::meet::{Candidates, Meeting, Way};
use super::points::{Lever, Owner, Places, Points};
use super::response::Tie;
use crate::model::Model;
use crate::solid::SolidState;
use meniscus_contact::{Barrier, Clearance, Contact, Friction, Kind, Local, Rubbing};
use meniscus_elastic::{BlockMatrix, Cliques, Incremental};
use meniscus_numerics::{Matrix, Vector};
use rayon::prelude::*;

/// A rigid solid in the potential.
#[derive(Clone, Copy, Debug)]
pub struct Rigid<const D: usize> {
    /// Mass, kg.
    pub mass: f64,
    /// Moments of inertia, kg m², for a node's angular velocity.
    pub inertia: Matrix<D>,
    /// Velocities of its nodes that all other forces give it.
    pub target: [Vector<D>; 2],
}

/// The part of a solid.
#[derive(Clone, Debug)]
pub enum Part<'a, const D: usize> {
    /// It deforms.
    Soft(Incremental<'a, D>),
    /// It is rigid, and free.
    Free(Rigid<D>),
    /// Nothing moves it but what it is told.
    Told,
}

/// A point and the nearest place of what it meets.
struct Met<const D: usize> {
    /// Number of the point.
    point: u32,
    /// Distance, m.
    distance: f64,
    /// Direction away from the other.
    normal: Vector<D>,
    /// The other place, where it moves.
    other: Option<Owner<D>>,
}

/// A term: the points that it is of, with their levers, and its derivatives by their positions.
struct Term<const D: usize> {
    levers: Vec<Vec<Lever<D>>>,
    local: Local<D>,
}

/// Two places that rub each other, with the owners of the points.
pub struct Rub<const D: usize> {
    owners: [Owner<D>; 4],
    from: [Vector<D>; 4],
    rubbing: Rubbing<D>,
}

/// The potential of a step.
pub struct Potential<'a, const D: usize> {
    /// The model.
    pub model: &'a Model<D>,
    /// The solids where the step ends.
    pub solids: &'a [SolidState<D>],
    /// Their points.
    pub points: &'a Points<D>,
    /// The solids' own parts.
    pub parts: Vec<Part<'a, D>>,
    /// The barrier between all of them.
    pub barrier: Barrier,
    /// For how long the forces act, s.
    pub kick: f64,
    /// The longest that the coming step can be, s.
    pub ahead: f64,
    /// What rubs.
    pub rubs: Vec<Rub<D>>,
    /// Impulses of the pressure on the nodes, N s.
    pub pressed: Vec<Vector<D>>,
}

/// Part of the softer solid's Young's modulus in the stiffness of the barrier: under a stress that strains it by a tenth the gap is half
/// the reach.
const ELASTIC: f64 = 0.1;

/// Slip in a step, in reaches of the barrier, below which friction is static and grows with the slip. At 1e-2 a block came 5 % too far
/// down a slope; at 1e-4 two of 22 scenes took more than twice as many iterations.
const STICK: f64 = 1e-3;
/// The same without liquid, over the way that gravity adds in a step: a resting body creeps at most at a tenth of the speed that it
/// would gain in a step of free fall. With a liquid, whose splashes make steps short, this would become as small as their square, and
/// Newton's method slow (six of 22 scenes took over half a minute): there a resting body may creep by [`STICK`] in each step.
const CREEP: f64 = 0.1;

impl<'a, const D: usize> Potential<'a, D> {
    /// The solids after a time with these velocities.
    pub fn places<'b>(&'b self, velocities: &'b [Vector<D>]) -> Places<'b, D> {
        Places::new(self.model, self.solids, self.points, velocities, self.ahead)
    }

    /// Stiffness of the barrier, Pa, between a solid and another, or a side: the pressures that there can be, tension's in a drop of a
    /// cell, that of a column of liquid through the domain, of the solids' weight and start, and what presses the softer one by a tenth.
    /// What presses so much rests in the middle of the reach.
    fn stiffness(&self, solid: usize, other: Option<usize>) -> f64 {
        let model = self.model;
        let speed = model.grid.dx / model.capillary_step();
        let column: f64 = model.gravity.iter().zip(&model.grid.upper()).map(|(g, l)| (g * l).abs()).sum();
        let young = |solid: usize| model.solids[solid].elastic().map_or(f64::INFINITY, |e| e.young());
        let pressure = |solid: usize| self.points.pressures[solid];
        let softer = young(solid).min(other.map_or(f64::INFINITY, young));
        let elastic = if softer.is_finite() { ELASTIC * softer } else { 0.0 };
        let heavier = pressure(solid).max(other.map_or(0.0, pressure));
        model.density * (speed * speed + column) + heavier + elastic
    }

    /// Friction of this step.
    fn friction(&self) -> Friction {
        let (stick, gravity) = (STICK * self.barrier.reach, self.model.gravity.norm());
        let dry = self.model.surface_tension == 0.0 && gravity > 0.0;
        let fall = CREEP * gravity * self.kick * self.ahead;
        Friction { stick: if dry { stick.min(fall) } else { stick } }
    }

    /// The barrier between a point and what has no facets.
    fn barrier(&self, point: u32) -> Barrier {
        Barrier { reach: self.barrier.reach.min(self.points.surface.reach(point)) }
    }

    /// The contacts within reach at the end.
    fn contacts(&self, candidates: &Candidates, at: &[Vector<D>]) -> Vec<Contact> {
        let solid = |p: u32| self.points.owners[p as usize].solid();
        candidates.near.contacts(self.barrier.reach, at, |p, q| self.stiffness(solid(p), Some(solid(q))))
    }

    /// A point that feels something without facets; nothing where it is out of reach.
    fn met(&self, meeting: &Meeting, places: &Places<'_, D>, at: &[Vector<D>]) -> Option<Met<D>> {
        let point = meeting.point();
        let x = &at[point as usize];
        let distance = meeting.distance(places, x) - self.points.thickness(meeting);
        if distance >= self.barrier(point).reach {
            return None;
        }
        let (normal, other) = match *meeting {
            Meeting::Rigid(_, solid, part) => {
                let normal = places.away_from_rigid((solid, part), x);
                (normal, Some(Owner::Rigid { solid, at: places.at_start(solid, x) }))
            }
            Meeting::Side(_, side) => (self.points.sides[side].normal, None),
        };
        Some(Met { point, distance, normal, other })
    }

    /// Its value, J (2D: J/m).
    pub fn value(&self, velocities: &[Vector<D>], candidates: &Candidates) -> f64 {
        let own: f64 =
            self.parts.iter().enumerate().map(|(k, part)| self.own_value(k, part, velocities)).sum();
        let places = self.places(velocities);
        let friction = self.friction();
        let rub = |r: &Rub<D>| {
            let to = r.owners.map(|o| places.at(&o));
            friction.energy(&r.rubbing, &r.from, &to)
        };
        let rubbed: f64 = self.rubs.iter().map(rub).sum();
        let pressed: f64 = self.pressed.iter().zip(velocities).map(|(j, v)| j.dot(v)).sum();
        own - pressed + self.kick / self.ahead * (self.stored(&places, candidates) + rubbed)
    }

    /// Energy of the barriers where solids are, J (2D: J/m).
    pub fn stored(&self, places: &Places<'_, D>, candidates: &Candidates) -> f64 {
        let at = places.all();
        let contacts = self.contacts(candidates, &at);
        let between: f64 = contacts.iter().map(|c| c.energy(&at)).sum();
        let met = |m: &Meeting| {
            let point = m.point();
            let distance = m.distance(places, &at[point as usize]) - self.points.thickness(m);
            let energy = self.barrier(point).of_distance(distance)[0];
            let solid = self.points.owners[point as usize].solid();
            let scale = || self.points.surface.area(point) * self.stiffness(solid, m.solid());
            if energy > 0.0 { scale() * energy } else { 0.0 }
        };
        between + candidates.meetings.iter().map(met).sum::<f64>()
    }

    fn own_value(&self, k: usize, part: &Part<'a, D>, velocities: &[Vector<D>]) -> f64 {
        let own = &velocities[self.points.first[k]..];
        match part {
            Part::Soft(soft) => soft.value(&own[..soft.impulses.len()]),
            Part::Free(rigid) => {
                let off = [own[0] - rigid.target[0], own[1] - rigid.target[1]];
                0.5 * (rigid.mass * off[0].norm_squared() + off[1].dot(&(rigid.inertia * off[1])))
            }
            Part::Told => 0.0,
        }
    }

    /// All terms between solids.
    fn terms(&self, places: &Places<'_, D>, candidates: &Candidates, positive: bool) -> Vec<Term<D>> {
        let at = places.all();
        let contacts = self.contacts(candidates, &at);
        let owners = &self.points.owners;
        let lever = |p: u32| places.levers(&owners[p as usize]);
        let of_contact = |c: &Contact| {
            let local = c.derivatives(&at)?;
            let local = if positive { local.positive() } else { local };
            Some(Term { levers: c.stencil.points().iter().map(|p| lever(*p)).collect(), local })
        };
        let mut terms: Vec<Term<D>> = contacts.par_iter().with_min_len(32).filter_map(of_contact).collect();
        for m in &candidates.meetings {
            let Some(Met { point, distance, normal, other }) = self.met(m, places, &at) else { continue };
            let [_, slope, bend] = self.barrier(point).of_distance(distance);
            let solid = owners[point as usize].solid();
            let scale = self.points.surface.area(point) * self.stiffness(solid, m.solid());
            let mut levers = vec![lever(point)];
            levers.extend(other.map(|o| places.levers(&o)));
            let mut local = Local::zeros(levers.len());
            let outer = normal * normal.transpose() * (scale * bend);
            for k in 0..local.count {
                let sign = 1.0 - 2.0 * k as f64;
                local.gradient[k] = normal * (sign * scale * slope);
                for l in 0..local.count {
                    local.hessian[k][l] = outer * (sign * (1.0 - 2.0 * l as f64));
                }
            }
            terms.push(Term { levers, local });
        }
        let friction = self.friction();
        for r in &self.rubs {
            let to = r.owners.map(|o| places.at(&o));
            let local = friction.derivatives(&r.rubbing, &r.from, &to);
            terms.push(Term {
                levers: r.owners[..local.count].iter().map(|o| places.levers(o)).collect(),
                local,
            });
        }
        terms
    }

    /// Its gradient, N s (2D: N s/m).
    pub fn gradient(&self, velocities: &[Vector<D>], candidates: &Candidates) -> Vec<Vector<D>> {
        let mut gradient: Vec<Vector<D>> = self.pressed.iter().map(|j| -j).collect();
        for (k, part) in self.parts.iter().enumerate() {
            let first = self.points.first[k];
            match part {
                Part::Soft(soft) => {
                    let own = first..first + soft.impulses.len();
                    let of = soft.gradient(&velocities[own.clone()]);
                    gradient[own].iter_mut().zip(of).for_each(|(g, of)| *g += of);
                }
                Part::Free(rigid) => {
                    gradient[first] += (velocities[first] - rigid.target[0]) * rigid.mass;
                    gradient[first + 1] += rigid.inertia * (velocities[first + 1] - rigid.target[1]);
                }
                Part::Told => {}
            }
        }
        gradient.iter_mut().zip(self.between(velocities, candidates)).for_each(|(g, push)| *g -= push);
        gradient
    }

    /// Impulses, N s (2D: N s/m), that contacts and friction give to the nodes.
    pub fn between(&self, velocities: &[Vector<D>], candidates: &Candidates) -> Vec<Vector<D>> {
        let mut impulses = vec![Vector::zeros(); velocities.len()];
        for Term { levers, local } in &self.terms(&self.places(velocities), candidates, false) {
            for k in 0..local.count {
                for (i, by) in &levers[k] {
                    impulses[*i] -= by.tr_mul(&local.gradient[k]) * self.kick;
                }
            }
        }
        impulses
    }

    /// Its second derivatives, kg (2D: kg/m), or their `positive` part; nothing where a solid's matrix cannot be. `ties` add their
    /// masses.
    pub fn matrix(
        &self,
        velocities: &[Vector<D>],
        candidates: &Candidates,
        ties: &[Tie<D>],
        positive: bool,
    ) -> Option<BlockMatrix<D>> {
        let mut parts = Vec::new();
        for (part, first) in self.parts.iter().zip(&self.points.first) {
            if let Part::Soft(soft) = part {
                parts.push(soft.matrix(&velocities[*first..first + soft.impulses.len()], positive)?);
            }
        }
        let terms = self.terms(&self.places(velocities), candidates, positive);
        let mut groups = Cliques::default();
        for term in &terms {
            groups.push(term.levers.iter().flatten().map(|l| l.0 as u32));
        }
        let arms = |tie: &Tie<D>| {
            tie.ends.iter().flat_map(|end| &end.arm).map(|arm| arm.0 as u32).collect::<Vec<_>>()
        };
        ties.iter().for_each(|tie| groups.push(arms(tie)));
        let mut matrix = self.points.assembly.as_ref()?.matrix(&parts, &groups);
        for (k, part) in self.parts.iter().enumerate() {
            let node = self.points.first[k] as u32;
            if let Part::Free(rigid) = part {
                let _ = matrix.add(node, node, &(Matrix::identity() * rigid.mass));
                let _ = matrix.add(node + 1, node + 1, &rigid.inertia);
            }
        }
        for Term { levers, local } in &terms {
            for k in 0..local.count {
                for (i, by_i) in &levers[k] {
                    for l in 0..local.count {
                        for (j, by_j) in &levers[l] {
                            if i >= j {
                                let block = by_i.tr_mul(&(local.hessian[k][l] * by_j));
                                let _ = matrix.add(*i as u32, *j as u32, &(block * (self.kick * self.ahead)));
                            }
                        }
                    }
                }
            }
        }
        for tie in ties {
            tie.masses(|one, other, mass| {
                for (i, a) in &one.arm {
                    for (j, b) in other.arm.iter().filter(|(j, _)| i >= j) {
                        let _ = matrix.add(*i as u32, *j as u32, &(a * b.transpose() * mass));
                    }
                }
            });
        }
        Some(matrix)
    }

    /// What may meet on the way to the end of the coming step between two choices of velocities.
    pub fn candidates(&self, from: &[Vector<D>], to: &[Vector<D>]) -> Candidates {
        Candidates::on(Way { from: &self.places(from), to: &self.places(to) }, self.barrier.reach)
    }

    /// The largest part of the way from some velocities along a change of them, up to all of it, on which nothing gives up more than
    /// `1 − keep` of what keeps it from meeting and from turning inside out.
    pub fn free_step(
        &self,
        from: &[Vector<D>],
        change: &[Vector<D>],
        to: &[Vector<D>],
        candidates: &Candidates,
        keep: f64,
    ) -> f64 {
        let (one, other) = (self.places(from), self.places(to));
        let (start, end) = (one.all(), other.all());
        let ways: Vec<Vector<D>> = end.iter().zip(&start).map(|(e, s)| e - s).collect();
        let mut part = candidates.near.free_step(&start, &ways, keep);
        for m in &candidates.meetings {
            let thickness = self.points.thickness(m);
            match *m {
                Meeting::Side(p, side) => {
                    let (side, clearance) = (&self.points.sides[side], Clearance { thickness, keep });
                    part = part.min(side.free_step(&start[p as usize], &ways[p as usize], clearance));
                }
                Meeting::Rigid(p, solid, part_of) => {
                    let (start, end) = (&start[p as usize], &end[p as usize]);
                    let far = one.distance_to_rigid((solid, part_of), start) - thickness;
                    let length = Way { from: &one, to: &other }.seen_from(solid, start, end);
                    if length > (1.0 - keep) * far {
                        part = part.min((1.0 - keep) * far / length);
                    }
                }
            }
        }
        for (k, solid) in self.parts.iter().enumerate() {
            if let Part::Soft(soft) = solid {
                let own = self.points.first[k]..self.points.first[k] + soft.impulses.len();
                part = part.min(soft.upright_step(&from[own.clone()], &change[own], keep));
            }
        }
        part
    }

    /// Where friction acts between a point at `x` and something without facets: midway between the two surfaces, so that both get it at
    /// one place; on a vertex of a solid that deforms at the vertex.
    fn rubbing_place(&self, meeting: &Meeting, x: Vector<D>, distance: f64, normal: Vector<D>) -> Vector<D> {
        let point = meeting.point();
        match self.points.owners[point as usize] {
            Owner::Vertex { .. } => x,
            Owner::Rigid { .. } => {
                let (radius, thickness) = (self.points.surface.radius(point), self.points.thickness(meeting));
                x - normal * (0.5 * (distance + thickness + radius))
            }
        }
    }

    /// What rubs with these velocities.
    pub fn rubbing(&self, velocities: &[Vector<D>], candidates: &Candidates) -> Vec<Rub<D>> {
        let places = self.places(velocities);
        let at = places.all();
        let zero = vec![Vector::zeros(); velocities.len()];
        let from = Places::new(self.model, self.solids, self.points, &zero, 0.0);
        let owners = &self.points.owners;
        let friction = |first: usize, second: Option<usize>| {
            let of = |k: usize| self.model.solids[k].friction;
            second.map_or(of(first), |second| (of(first) * of(second)).sqrt())
        };
        let mut rubs = Vec::new();
        for c in self.contacts(candidates, &at) {
            let points = c.stencil.points();
            let (first, second) = (points[0], points[c.stencil.kind.first()]);
            let coefficient = friction(owners[first as usize].solid(), Some(owners[second as usize].solid()));
            let Some(rubbing) = Rubbing::new(&c, coefficient, &at) else { continue };
            let mut own = [owners[first as usize]; 4];
            own.iter_mut().zip(points).for_each(|(o, p)| *o = owners[*p as usize]);
            let mut stencil = c.stencil;
            stencil.points = [0, 1, 2, 3];
            rubs.push(Rub {
                owners: own,
                from: own.map(|o| from.at(&o)),
                rubbing: Rubbing { stencil, ..rubbing },
            });
        }
        for m in &candidates.meetings {
            let Some(Met { point, distance, normal, other }) = self.met(m, &places, &at) else { continue };
            let solid = owners[point as usize].solid();
            let coefficient = friction(solid, other.map(|o| o.solid()));
            let slope = self.barrier(point).of_distance(distance)[1];
            let hold =
                -coefficient * self.points.surface.area(point) * self.stiffness(solid, m.solid()) * slope;
            if hold <= 0.0 {
                continue;
            }
            let place = self.rubbing_place(m, at[point as usize], distance, normal);
            let owner = match owners[point as usize] {
                Owner::Rigid { solid, .. } => Owner::Rigid { solid, at: places.at_start(solid, &place) },
                vertex => vertex,
            };
            let mut own = [owner; 4];
            // The other end of what rubs against a side does not move.
            let weights = if other.is_some() { [1.0, -1.0, 0.0, 0.0] } else { [1.0, 0.0, 0.0, 0.0] };
            other.iter().for_each(|o| {
                own[1] = Owner::Rigid { solid: o.solid(), at: places.at_start(o.solid(), &place) }
            });
            let stencil = meniscus_contact::Stencil { kind: Kind::PointSegment, points: [0, 1, 2, 3] };
            let rubbing = Rubbing { stencil, weights, normal, hold };
            rubs.push(Rub { owners: own, from: own.map(|o| from.at(&o)), rubbing });
        }
        rubs
    }
}
