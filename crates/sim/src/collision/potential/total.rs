//! What the velocities of all solids make least in a step: an incremental potential (M. Li et al. 2020).
//!
//! Of each solid that deforms that of [`Incremental`], of each rigid one `½ (V − V*)ᵀ M (V − V*)` about the velocities `V*` that all
//! other forces give it; of all together `h/a` times the barriers between them at the end of the coming step, of length `a`, and what
//! friction holds them with on the way there.

use super::moments::{Early, Past};
use super::slips::{Rub, Slips, friction};
use super::term::Term;
use crate::collision::broad_phase::{Candidates, Way};
use crate::collision::points::{Meeting, Points};
use crate::collision::tie::Tie;
use crate::model::Model;
use crate::solid::SolidState;
use meniscus_contact::{Barrier, Clearance};
use meniscus_elastic::{BlockMatrix, Cliques, Incremental, Structure};
use meniscus_numerics::{Matrix, Vector};

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

/// In what order the unknowns of the solids' matrix are eliminated.
pub struct Elimination<const D: usize> {
    /// Of the last matrix.
    pub structure: Option<Structure>,
    /// Where nodes are when the forces act, m: the order is by these.
    pub positions: Vec<Vector<D>>,
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
    /// How far the velocities are then ahead of the positions, s.
    pub lead: f64,
    /// The longest that the coming step can be, s.
    pub ahead: f64,
    /// The time in which rigid solids settle on each other, s.
    pub settling: f64,
    /// Where solids are now, and where they were at the time of the old velocities.
    pub past: Past<'a, D>,
    /// The elastic slips where the step ends.
    pub slips: &'a Slips<D>,
    /// The pairs that feel their barrier early.
    pub early: Early,
    /// What rubs.
    pub rubs: Vec<Rub<D>>,
    /// Impulses of the pressure on the nodes, N s.
    pub pressed: Vec<Vector<D>>,
}

impl<'a, const D: usize> Potential<'a, D> {
    /// Its value, J (2D: J/m).
    pub fn value(&self, velocities: &[Vector<D>], candidates: &Candidates) -> f64 {
        let own: f64 =
            self.parts.iter().enumerate().map(|(k, part)| self.own_value(k, part, velocities)).sum();
        let places = self.places(velocities);
        let friction = friction(self.model);
        let rub = |r: &Rub<D>| {
            let to = r.owners.map(|o| places.at(&o));
            friction.energy(&r.rubbing, &r.from, &to)
        };
        let rubbed: f64 = self.rubs.iter().map(rub).sum();
        let pressed: f64 = self.pressed.iter().zip(velocities).map(|(j, v)| j.dot(v)).sum();
        let damped = self.damping(velocities, &candidates.meetings);
        own - pressed + self.kick * (self.barriers(velocities, candidates) + damped + rubbed / self.ahead)
    }

    /// All terms between solids.
    fn terms(&self, velocities: &[Vector<D>], candidates: &Candidates, positive: bool) -> Vec<Term<D>> {
        let mut terms = self.barrier_terms(velocities, candidates, positive);
        let (places, friction) = (self.places(velocities), friction(self.model));
        for r in &self.rubs {
            let to = r.owners.map(|o| places.at(&o));
            let local = friction.derivatives(&r.rubbing, &r.from, &to);
            terms.push(Term {
                levers: r.owners[..local.count].iter().map(|o| places.levers(o)).collect(),
                local,
                time: self.ahead,
            });
        }
        terms
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
        for Term { levers, local, .. } in &self.terms(velocities, candidates, false) {
            for k in 0..local.count {
                for (i, by) in &levers[k] {
                    impulses[*i] -= by.tr_mul(&local.gradient[k]) * self.kick;
                }
            }
        }
        impulses
    }

    /// Its second derivatives, kg (2D: kg/m), or their `positive` part; nothing where a solid's matrix cannot be. `ties` add their
    /// masses. The order of elimination becomes that of this matrix.
    pub fn matrix(
        &self,
        velocities: &[Vector<D>],
        candidates: &Candidates,
        ties: &[Tie<D>],
        elimination: &mut Elimination<D>,
        positive: bool,
    ) -> Option<BlockMatrix<D>> {
        let mut parts = Vec::new();
        for (part, first) in self.parts.iter().zip(&self.points.first) {
            if let Part::Soft(soft) = part {
                parts.push(soft.matrix(&velocities[*first..first + soft.impulses.len()], positive)?);
            }
        }
        let terms = self.terms(velocities, candidates, positive);
        let mut groups = Cliques::default();
        for term in &terms {
            groups.push(term.levers.iter().flatten().map(|l| l.0 as u32));
        }
        let arms = |tie: &Tie<D>| {
            tie.ends.iter().flat_map(|end| &end.arm).map(|arm| arm.0 as u32).collect::<Vec<_>>()
        };
        ties.iter().for_each(|tie| groups.push(arms(tie)));
        let assembly = self.points.assembly.as_ref()?;
        let Elimination { structure, positions } = elimination;
        *structure = assembly.structure(&groups, positions, structure.take());
        let mut matrix = assembly.matrix(&parts, structure.as_ref()?);
        for (k, part) in self.parts.iter().enumerate() {
            let node = self.points.first[k] as u32;
            if let Part::Free(rigid) = part {
                let _ = matrix.add(node, node, &(Matrix::identity() * rigid.mass));
                let _ = matrix.add(node + 1, node + 1, &rigid.inertia);
            }
        }
        for Term { levers, local, time } in &terms {
            for k in 0..local.count {
                for (i, by_i) in &levers[k] {
                    for l in 0..local.count {
                        for (j, by_j) in &levers[l] {
                            if i >= j {
                                let block = by_i.tr_mul(&(local.hessian[k][l] * by_j));
                                let _ = matrix.add(*i as u32, *j as u32, &(block * (self.kick * time)));
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

    /// What may meet on the way to the end of the coming step between two choices of velocities, and on the way from the start to that of
    /// the second one, or feels a barrier before; with a `margin`, m, to what is near.
    pub fn candidates(&self, from: &[Vector<D>], to: &[Vector<D>], margin: f64) -> Candidates {
        let (start, end) = (self.moments(from), self.moments(to));
        let still = vec![Vector::zeros(); to.len()];
        let now = self.places_after(&still, 0.0);
        let late = Way { from: &start.late.places, to: &end.late.places };
        let early = Way { from: &start.early.places, to: &end.early.places };
        let all = Way { from: &now, to: &end.late.places };
        Candidates::on(&[late, early, all], self.barrier.reach, margin)
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
}
