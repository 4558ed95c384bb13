//! The incremental potential of a step, which the velocities of all solids minimise (M. Li et al. 2020).
//!
//! The sum of [`IncrementalPotential`] for each deformable solid, `½ (V − V*)ᵀ M (V − V*)` for each free rigid solid, where `V*` are the
//! velocities after all other forces, and `h` times the barriers, dashpots and friction between them.

use super::slips::{FrictionContact, Slips, friction_law};
use super::term::PotentialTerm;
use super::time_levels::{EarlyPairs, OldTimeLevels};
use crate::collision::broad_phase::{CandidatePairs, Sweep};
use crate::collision::points::{CollisionPoints, SdfPair};
use crate::collision::tied_face::TiedFace;
use crate::model::Model;
use crate::solid::SolidState;
use meniscus_contact::{Barrier, Clearance};
use meniscus_elastic::{AssemblyStructure, BlockMatrix, Cliques, IncrementalPotential};
use meniscus_numerics::{Matrix, Vector};

/// Term of a free rigid solid.
#[derive(Clone, Copy, Debug)]
pub struct RigidTerm<const D: usize> {
    /// Mass, kg.
    pub mass: f64,
    /// Inertia tensor, kg m², for the angular velocity of a node.
    pub inertia: Matrix<D>,
    /// Velocities of its nodes after all other forces.
    pub target_velocities: [Vector<D>; 2],
}

/// Term of a solid.
#[derive(Clone, Debug)]
pub enum SolidTerm<'a, const D: usize> {
    /// A deformable solid.
    Deformable(IncrementalPotential<'a, D>),
    /// A free rigid solid.
    Rigid(RigidTerm<D>),
    /// A solid with prescribed motion.
    Prescribed,
}

/// Elimination order of the unknowns in the joint matrix.
pub struct EliminationOrder<const D: usize> {
    /// Structure of the last matrix.
    pub structure: Option<AssemblyStructure>,
    /// Positions of the nodes when the forces act, m, which determine the order.
    pub positions: Vec<Vector<D>>,
}

/// The potential of a step.
pub struct Potential<'a, const D: usize> {
    /// The model.
    pub model: &'a Model<D>,
    /// The solids at the start of the coming step, with the velocities before the forces act.
    pub solids: &'a [SolidState<D>],
    /// Their collision points.
    pub points: &'a CollisionPoints<D>,
    /// Terms of the solids.
    pub parts: Vec<SolidTerm<'a, D>>,
    /// Barrier between the solids.
    pub barrier: Barrier,
    /// Impulse time: the time for which the forces act, s.
    pub impulse_time: f64,
    /// Time by which the new velocities are ahead of the positions, s.
    pub velocity_lead: f64,
    /// Maximum length of the coming step, s.
    pub lookahead: f64,
    /// Settling time of rigid solids in contact, s.
    pub settling_time: f64,
    /// Configurations at the start of the coming step and at the time of the old velocities.
    pub old_levels: OldTimeLevels<'a, D>,
    /// Elastic slips at the start of the coming step.
    pub elastic_slips: &'a Slips<D>,
    /// Pairs whose barrier uses the early time level.
    pub early_pairs: EarlyPairs,
    /// Friction contacts.
    pub friction_contacts: Vec<FrictionContact<D>>,
    /// Impulses of the pressure on the nodes, N s.
    pub pressure_impulses: Vec<Vector<D>>,
}

impl<'a, const D: usize> Potential<'a, D> {
    /// Value, J (2D: J/m).
    pub fn value(&self, velocities: &[Vector<D>], candidates: &CandidatePairs) -> f64 {
        let own: f64 =
            self.parts.iter().enumerate().map(|(k, part)| self.own_value(k, part, velocities)).sum();
        let places = self.configuration(velocities);
        let friction = friction_law(self.model);
        let rub = |r: &FrictionContact<D>| {
            let to = r.owners.map(|o| places.position(&o));
            friction.energy(&r.rubbing, &r.start_positions, &to)
        };
        let rubbed: f64 = self.friction_contacts.iter().map(rub).sum();
        let pressed: f64 = self.pressure_impulses.iter().zip(velocities).map(|(j, v)| j.dot(v)).sum();
        let damped = self.dissipation(velocities, &candidates.sdf_pairs);
        own - pressed
            + self.impulse_time
                * (self.barrier_power(velocities, candidates) + damped + rubbed / self.lookahead)
    }

    /// All terms between solids.
    fn terms(
        &self,
        velocities: &[Vector<D>],
        candidates: &CandidatePairs,
        positive: bool,
    ) -> Vec<PotentialTerm<D>> {
        let mut terms = self.barrier_terms(velocities, candidates, positive);
        let (places, friction) = (self.configuration(velocities), friction_law(self.model));
        for r in &self.friction_contacts {
            let to = r.owners.map(|o| places.position(&o));
            let derivatives = friction.derivatives(&r.rubbing, &r.start_positions, &to);
            terms.push(PotentialTerm {
                node_jacobians: r.owners[..derivatives.point_count]
                    .iter()
                    .map(|o| places.node_jacobians(o))
                    .collect(),
                derivatives,
                time: self.lookahead,
            });
        }
        terms
    }

    fn own_value(&self, k: usize, part: &SolidTerm<'a, D>, velocities: &[Vector<D>]) -> f64 {
        let own = &velocities[self.points.first_node[k]..];
        match part {
            SolidTerm::Deformable(soft) => soft.value(&own[..soft.impulses.len()]),
            SolidTerm::Rigid(rigid) => {
                let off = [own[0] - rigid.target_velocities[0], own[1] - rigid.target_velocities[1]];
                0.5 * (rigid.mass * off[0].norm_squared() + off[1].dot(&(rigid.inertia * off[1])))
            }
            SolidTerm::Prescribed => 0.0,
        }
    }

    /// Largest change of the deformation gradient of an element in the impulse time, at these velocities.
    pub fn deformation_increment(&self, velocities: &[Vector<D>]) -> f64 {
        let rate = |(part, first): (&SolidTerm<'a, D>, &usize)| match part {
            SolidTerm::Deformable(soft) => {
                soft.elastic.max_deformation_rate(&velocities[*first..first + soft.impulses.len()])
            }
            SolidTerm::Rigid(_) | SolidTerm::Prescribed => 0.0,
        };
        self.impulse_time * self.parts.iter().zip(&self.points.first_node).map(rate).fold(0.0, f64::max)
    }

    /// Gradient of each solid's own term, N s (2D: N s/m), on its nodes; empty for prescribed motion.
    pub fn own_gradients(&self, velocities: &[Vector<D>]) -> Vec<Vec<Vector<D>>> {
        let of = |(part, first): (&SolidTerm<'a, D>, &usize)| {
            let own = &velocities[*first..];
            match part {
                SolidTerm::Deformable(soft) => soft.gradient(&own[..soft.impulses.len()]),
                SolidTerm::Rigid(rigid) => vec![
                    (own[0] - rigid.target_velocities[0]) * rigid.mass,
                    rigid.inertia * (own[1] - rigid.target_velocities[1]),
                ],
                SolidTerm::Prescribed => Vec::new(),
            }
        };
        self.parts.iter().zip(&self.points.first_node).map(of).collect()
    }

    /// Gradient, N s (2D: N s/m); `own` are the [`Self::own_gradients`] at the same velocities.
    pub fn gradient(
        &self,
        own: &[Vec<Vector<D>>],
        velocities: &[Vector<D>],
        candidates: &CandidatePairs,
    ) -> Vec<Vector<D>> {
        let mut gradient: Vec<Vector<D>> = self.pressure_impulses.iter().map(|j| -j).collect();
        for (own, first) in own.iter().zip(&self.points.first_node) {
            gradient[*first..].iter_mut().zip(own).for_each(|(g, own)| *g += own);
        }
        gradient
            .iter_mut()
            .zip(self.contact_impulses(velocities, candidates))
            .for_each(|(g, push)| *g -= push);
        gradient
    }

    /// Impulses of contacts and friction on the nodes, N s (2D: N s/m).
    pub fn contact_impulses(&self, velocities: &[Vector<D>], candidates: &CandidatePairs) -> Vec<Vector<D>> {
        let mut impulses = vec![Vector::zeros(); velocities.len()];
        for PotentialTerm { node_jacobians, derivatives, .. } in &self.terms(velocities, candidates, false) {
            for k in 0..derivatives.point_count {
                for (i, by) in &node_jacobians[k] {
                    impulses[*i] -= by.tr_mul(&derivatives.gradient[k]) * self.impulse_time;
                }
            }
        }
        impulses
    }

    /// Hessian, kg (2D: kg/m), with the masses of `ties`; `project_positive` projects each term. `None` if a matrix cannot be assembled.
    /// Updates the elimination order.
    pub fn hessian(
        &self,
        velocities: &[Vector<D>],
        candidates: &CandidatePairs,
        ties: &[TiedFace<D>],
        elimination: &mut EliminationOrder<D>,
        project_positive: bool,
    ) -> Option<BlockMatrix<D>> {
        let mut parts = Vec::new();
        for (part, first) in self.parts.iter().zip(&self.points.first_node) {
            if let SolidTerm::Deformable(soft) = part {
                parts.push(soft.hessian(&velocities[*first..first + soft.impulses.len()], project_positive)?);
            }
        }
        let terms = self.terms(velocities, candidates, project_positive);
        let mut groups = Cliques::default();
        for term in &terms {
            groups.push(term.node_jacobians.iter().flatten().map(|l| l.0 as u32));
        }
        let arms = |tie: &TiedFace<D>| {
            tie.solids.iter().flat_map(|end| &end.node_weights).map(|arm| arm.0 as u32).collect::<Vec<_>>()
        };
        ties.iter().for_each(|tie| groups.push(arms(tie)));
        let assembly = self.points.assembly.as_ref()?;
        let EliminationOrder { structure, positions } = elimination;
        *structure = assembly.structure(&groups, positions, structure.take());
        let mut matrix = assembly.matrix(&parts, structure.as_ref()?);
        for (k, part) in self.parts.iter().enumerate() {
            let node = self.points.first_node[k] as u32;
            if let SolidTerm::Rigid(rigid) = part {
                let _ = matrix.add(node, node, &(Matrix::identity() * rigid.mass));
                let _ = matrix.add(node + 1, node + 1, &rigid.inertia);
            }
        }
        for PotentialTerm { node_jacobians, derivatives, time } in &terms {
            for k in 0..derivatives.point_count {
                for (i, by_i) in &node_jacobians[k] {
                    for l in 0..derivatives.point_count {
                        for (j, by_j) in &node_jacobians[l] {
                            if i >= j {
                                let block = by_i.tr_mul(&(derivatives.hessian[k][l] * by_j));
                                let _ =
                                    matrix.add(*i as u32, *j as u32, &(block * (self.impulse_time * time)));
                            }
                        }
                    }
                }
            }
        }
        for tie in ties {
            tie.masses(|one, other, mass| {
                for (i, a) in &one.node_weights {
                    for (j, b) in other.node_weights.iter().filter(|(j, _)| i >= j) {
                        let _ = matrix.add(*i as u32, *j as u32, &(a * b.transpose() * mass));
                    }
                }
            });
        }
        Some(matrix)
    }

    /// Pairs that may touch, or activate a barrier, while the velocities change from `from` to `to` or during the coming step with `to`.
    pub fn candidates(&self, from: &[Vector<D>], to: &[Vector<D>]) -> CandidatePairs {
        let (start, end) = (self.time_levels(from), self.time_levels(to));
        let still = vec![Vector::zeros(); to.len()];
        let now = self.configuration_after(&still, 0.0);
        let late = Sweep { from: &start.late.configuration, to: &end.late.configuration };
        let early = Sweep { from: &start.early.configuration, to: &end.early.configuration };
        let all = Sweep { from: &now, to: &end.late.configuration };
        CandidatePairs::on(&[late, early, all], self.barrier.activation_distance)
    }

    /// Largest fraction of `change`, at most 1, that leaves each pair at least `kept_fraction` of its distance and each element that
    /// fraction of its volume.
    pub fn max_step_fraction(
        &self,
        from: &[Vector<D>],
        change: &[Vector<D>],
        to: &[Vector<D>],
        candidates: &CandidatePairs,
        kept_fraction: f64,
    ) -> f64 {
        let (one, other) = (self.configuration(from), self.configuration(to));
        let (start, end) = (one.positions(), other.positions());
        let ways: Vec<Vector<D>> = end.iter().zip(&start).map(|(e, s)| e - s).collect();
        let mut part = candidates.feature_pairs.collision_free_fraction(&start, &ways, kept_fraction);
        for m in &candidates.sdf_pairs {
            let thickness = self.points.thickness(m);
            match *m {
                SdfPair::Side(p, side) => {
                    let (side, clearance) =
                        (&self.points.domain_sides[side], Clearance { thickness, kept_fraction });
                    part = part.min(side.collision_free_fraction(
                        &start[p as usize],
                        &ways[p as usize],
                        clearance,
                    ));
                }
                SdfPair::Rigid(p, solid, part_of) => {
                    let (start, end) = (&start[p as usize], &end[p as usize]);
                    let far = one.distance_to_rigid(solid, part_of, start) - thickness;
                    let length = Sweep { from: &one, to: &other }.path_length_bound(solid, start, end);
                    if length > (1.0 - kept_fraction) * far {
                        part = part.min((1.0 - kept_fraction) * far / length);
                    }
                }
            }
        }
        for (k, solid) in self.parts.iter().enumerate() {
            if let SolidTerm::Deformable(soft) = solid {
                let own = self.points.first_node[k]..self.points.first_node[k] + soft.impulses.len();
                part =
                    part.min(soft.inversion_free_fraction(&from[own.clone()], &change[own], kept_fraction));
            }
        }
        part
    }
}
