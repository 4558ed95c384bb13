//! What the velocities at the end of a step make least: an incremental potential.
//!
//! Forces act for `h` and leave the velocities `l` ahead of the positions `x`. With the change `w = v' − v` of the velocities, the places
//! `q = x − (h − l) v` and `q' = x + l v'` of a body at the times of the old and the new velocities, `y` half-way between them, and
//! `z = x + a v'` where the coming step ends at the latest, that is
//!
//! ```text
//! ½ wᵀ M w + 2 h/l Ψ(y) − h (f(q, q') − f(y))ᵀ w + ½ h τ v'ᵀ K̂ v' − jᵀ w + h/a U(z):
//! ```
//!
//! the law `Ψ`, whose forces `f(q, q')` do the work by which it changes ([`crate::DiscreteGradientTerm`]), damping `τ K̂`, the impulses `j` of all
//! other forces, and what keeps elements upright, `U` ([`crate::InversionBarrier`]). The difference of the forces, which have no potential, is
//! lagged ([`IncrementalPotential::update_lagged`]), and so is `K̂`: at `x` the first Newton iteration from `w = 0` is the step that is linear about
//! `x`. Where `l = h/2` the step keeps the energy `½ vᵀ M v + Ψ(q)` of the law and both momenta (energy–momentum method, J. Simo & N. Tarnow
//! 1992); a longer `l` loses `(l/h − ½) wᵀ M w`.

use crate::term::ForceTerm;
use crate::term::extra_stiffness::add_stiffness_impulses;
use crate::{BlockMatrix, Elastic, ElasticState, StiffnessBlock, TangentWeights};
use meniscus_numerics::{Vector, par};

/// The potential of a solid in a step.
#[derive(Clone, Debug)]
pub struct IncrementalPotential<'a, const D: usize> {
    /// The solid.
    pub elastic: &'a Elastic<D>,
    /// Positions that have advanced, and velocities that have not.
    pub state: &'a ElasticState<D>,
    /// Where vertices are for the viscosities `K̂`, m.
    pub viscosity_positions: Vec<Vector<D>>,
    /// The forces with which the law keeps energy, less those at `y`, N (2D: N/m).
    pub discrete_gradient_correction: Vec<Vector<D>>,
    /// Stiffness of other forces.
    pub extra_stiffness: &'a [StiffnessBlock<D>],
    /// Impulses `j` of all other forces, N s (2D: N s/m).
    pub impulses: &'a [Vector<D>],
    /// Length `h` of the step, s.
    pub impulse_time: f64,
    /// How far the new velocities are ahead of the positions, `l`, s: half of the step where steps are of one length.
    pub velocity_lead: f64,
    /// The longest that the coming step can be, `a`, s.
    pub lookahead: f64,
}

impl<const D: usize> IncrementalPotential<'_, D> {
    fn velocity_change(&self, velocities: &[Vector<D>]) -> Vec<Vector<D>> {
        velocities.iter().zip(&self.state.velocities).map(|(new, old)| new - old).collect()
    }

    /// Takes viscosities where these velocities lead half-way, and the forces that keep energy between the ends of that way.
    pub fn update_lagged(&mut self, velocities: &[Vector<D>]) {
        self.viscosity_positions = self.midpoint_positions(velocities);
        let (new, old) = (self.velocity_lead, self.impulse_time - self.velocity_lead);
        let at = |velocities: &[Vector<D>], time: f64| -> Vec<Vector<D>> {
            self.state.positions.iter().zip(velocities).map(|(x, v)| x + v * time).collect()
        };
        let ends = [at(&self.state.velocities, -old), at(velocities, new)];
        self.discrete_gradient_correction = self.elastic.forces_between([&ends[0], &ends[1]]);
        let middle = self.elastic.forces(&self.viscosity_positions);
        self.discrete_gradient_correction.iter_mut().zip(&middle).for_each(|(b, m)| *b -= m);
    }

    fn midpoint_positions(&self, velocities: &[Vector<D>]) -> Vec<Vector<D>> {
        let (new, old) = (0.5 * self.velocity_lead, 0.5 * (self.impulse_time - self.velocity_lead));
        let displacement = |k: usize| velocities[k] * new - self.state.velocities[k] * old;
        self.state.positions.iter().enumerate().map(|(k, x)| x + displacement(k)).collect()
    }

    /// Where the vertices are at the end of the coming step, m.
    pub fn end_positions(&self, velocities: &[Vector<D>]) -> Vec<Vector<D>> {
        self.state.positions.iter().zip(velocities).map(|(x, v)| x + v * self.lookahead).collect()
    }

    /// Impulses of what resists rates of strain, N s.
    fn damping_impulses(&self, velocities: &[Vector<D>]) -> Vec<Vector<D>> {
        self.elastic.viscous_forces(
            &self.viscosity_positions,
            velocities,
            self.impulse_time * self.elastic.damping_time,
        )
    }

    /// Its value, J (2D: J/m); infinite where an element has no volume.
    pub fn value(&self, velocities: &[Vector<D>]) -> f64 {
        let (h, w) = (self.impulse_time, self.velocity_change(velocities));
        let damping = self.damping_impulses(velocities);
        let mut extra = vec![Vector::zeros(); w.len()];
        add_stiffness_impulses(self.extra_stiffness, h, &w, &mut extra);
        let own = par::sum(w.len(), |k| {
            w[k].dot(
                &(w[k] * (0.5 * self.elastic.masses[k])
                    - self.impulses[k]
                    - self.discrete_gradient_correction[k] * h
                    - extra[k] * 0.5),
            ) - 0.5 * velocities[k].dot(&damping[k])
        });
        let ends = self.end_positions(velocities);
        let upright: f64 = self.elastic.inversion_barriers.iter().map(|u| u.energy(&ends)).sum();
        own + 2.0 * h / self.velocity_lead * self.elastic.elastic_energy(&self.midpoint_positions(velocities))
            + h / self.lookahead * upright
    }

    /// The size of the energies of which it is the sum, J (2D: J/m).
    pub fn energy_scale(&self, velocities: &[Vector<D>]) -> f64 {
        let kinetic = |velocities: &[Vector<D>]| self.elastic.kinetic_energy(velocities);
        let stored = self.elastic.elastic_energy(&self.midpoint_positions(velocities));
        kinetic(velocities)
            + kinetic(&self.state.velocities)
            + 2.0 * self.impulse_time / self.velocity_lead * stored
    }

    /// Its gradient by the velocities, N s (2D: N s/m).
    pub fn gradient(&self, velocities: &[Vector<D>]) -> Vec<Vector<D>> {
        let (h, w) = (self.impulse_time, self.velocity_change(velocities));
        let damping = self.damping_impulses(velocities);
        let mut forces = self.elastic.forces(&self.midpoint_positions(velocities));
        let ends = self.end_positions(velocities);
        self.elastic.inversion_barriers.iter().for_each(|u| u.add_forces(&ends, &mut forces));
        let mut extra = vec![Vector::zeros(); w.len()];
        add_stiffness_impulses(self.extra_stiffness, h, &w, &mut extra);
        let of = |k: usize| {
            w[k] * self.elastic.masses[k]
                - (forces[k] + self.discrete_gradient_correction[k]) * h
                - damping[k]
                - self.impulses[k]
                - extra[k]
        };
        (0..w.len()).map(of).collect()
    }

    /// Its second derivatives, kg (2D: kg/m), or their `project_psd` part.
    pub fn hessian(&self, velocities: &[Vector<D>], project_psd: bool) -> Option<BlockMatrix<D>> {
        let elastic = self.elastic;
        let viscosity = self.impulse_time * elastic.damping_time;
        let mut matrix = elastic
            .tangent(&self.viscosity_positions, TangentWeights { stiffness: 0.0, project_psd, viscosity });
        elastic.masses.iter().enumerate().for_each(|(v, m)| matrix.add_diagonal(v, *m));
        let half_way = self.midpoint_positions(velocities);
        let stiffness = 0.5 * self.impulse_time * self.velocity_lead;
        let weights = TangentWeights { stiffness, project_psd, viscosity: 0.0 };
        elastic.terms.iter().for_each(|term| term.add_tangent(&half_way, weights, &mut matrix));
        let weights = TangentWeights { stiffness: self.impulse_time * self.lookahead, ..weights };
        let ends = self.end_positions(velocities);
        elastic.inversion_barriers.iter().for_each(|u| u.add_tangent(&ends, weights, &mut matrix));
        let mut put = |e: &StiffnessBlock<D>| {
            matrix.add(e.first, e.second, &(e.block * (0.25 * self.impulse_time * self.impulse_time)))
        };
        self.extra_stiffness.iter().all(&mut put).then_some(matrix)
    }

    /// The largest part of a change of the velocities, up to all of it, on which elements keep `kept_fraction` of the volume that they have
    /// at the end of the coming step, everywhere where it is looked at.
    pub fn inversion_free_fraction(
        &self,
        velocities: &[Vector<D>],
        change: &[Vector<D>],
        kept_fraction: f64,
    ) -> f64 {
        let (ends, ways) =
            (self.end_positions(velocities), change.iter().map(|c| c * self.lookahead).collect::<Vec<_>>());
        self.elastic
            .inversion_barriers
            .iter()
            .map(|u| u.inversion_free_fraction(&ends, &ways, kept_fraction))
            .fold(1.0, f64::min)
    }
}
