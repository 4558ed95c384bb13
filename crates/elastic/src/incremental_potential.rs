//! Incremental potential of a step, minimised by the velocities at its end.
//!
//! Forces act for the impulse time `h` and leave the new velocities `v'` ahead of the positions `x` by the velocity lead `l`. With
//! the change `w = v' − v` of the velocities, the positions `q = x − (h − l) v` and `q' = x + l v'` at the times of the old and the
//! new velocities, their midpoint `y`, and the positions `z = x + a v'` at the latest end of the coming step, the potential is
//!
//! ```text
//! ½ wᵀ M w + 2 h/l Ψ(y) − h (f(q, q') − f(y))ᵀ w + ½ h τ v'ᵀ K̂ v' − jᵀ w + ⅛ h² wᵀ K_e w + h/a U(z).
//! ```
//!
//! `Ψ` is the elastic energy, whose discrete gradient `f(q, q')` does the work by which it changes
//! ([`crate::DiscreteGradientTerm`]), `τ K̂` the damping, `j` the impulses of all other forces, `K_e` their stiffness, and `U` the
//! inversion barrier ([`crate::InversionBarrier`]). The correction `f(q, q') − f(y)` has no potential; it is lagged
//! ([`IncrementalPotential::update_lagged`]), and so is `K̂`. At `x` the first Newton iteration from `w = 0` is the step linearised
//! about `x`. For `l = h/2` the step conserves the energy `½ vᵀ M v + Ψ(q)` and both momenta (energy–momentum method, J. Simo & N.
//! Tarnow 1992); a longer `l` dissipates `(l/h − ½) wᵀ M w`.

use crate::term::ForceTerm;
use crate::term::extra_stiffness::add_stiffness_impulses;
use crate::{BlockMatrix, Elastic, ElasticState, StiffnessBlock, TangentWeights};
use meniscus_numerics::{Vector, par};

/// Incremental potential of a solid in a step.
#[derive(Clone, Debug)]
pub struct IncrementalPotential<'a, const D: usize> {
    /// The solid.
    pub elastic: &'a Elastic<D>,
    /// Advanced positions and old velocities.
    pub state: &'a ElasticState<D>,
    /// Positions at which the viscosity `K̂` is evaluated, m.
    pub viscosity_positions: Vec<Vector<D>>,
    /// Lagged correction `f(q, q') − f(y)`, N (2D: N/m).
    pub discrete_gradient_correction: Vec<Vector<D>>,
    /// Stiffness of other forces.
    pub extra_stiffness: &'a [StiffnessBlock<D>],
    /// Impulses `j` of all other forces, N s (2D: N s/m).
    pub impulses: &'a [Vector<D>],
    /// Impulse time `h`, s.
    pub impulse_time: f64,
    /// Velocity lead `l`, s: half of the step where all steps have the same length.
    pub velocity_lead: f64,
    /// Longest possible length `a` of the coming step, s.
    pub lookahead: f64,
}

impl<const D: usize> IncrementalPotential<'_, D> {
    fn velocity_change(&self, velocities: &[Vector<D>]) -> Vec<Vector<D>> {
        velocities.iter().zip(&self.state.velocities).map(|(new, old)| new - old).collect()
    }

    /// Evaluates the lagged viscosity positions and the discrete-gradient correction for these velocities.
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

    /// Positions `z` at the end of the coming step, m.
    pub fn end_positions(&self, velocities: &[Vector<D>]) -> Vec<Vector<D>> {
        self.state.positions.iter().zip(velocities).map(|(x, v)| x + v * self.lookahead).collect()
    }

    /// Impulses of the damping, N s (2D: N s/m).
    fn damping_impulses(&self, velocities: &[Vector<D>]) -> Vec<Vector<D>> {
        self.elastic.viscous_forces(
            &self.viscosity_positions,
            velocities,
            self.impulse_time * self.elastic.damping_time,
        )
    }

    /// Value of the potential, J (2D: J/m); infinite where an element has no volume.
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

    /// Magnitude of its energies, J (2D: J/m), the scale of the Newton decrement.
    pub fn energy_scale(&self, velocities: &[Vector<D>]) -> f64 {
        let kinetic = |velocities: &[Vector<D>]| self.elastic.kinetic_energy(velocities);
        let middle = self.midpoint_positions(velocities);
        // The energy of a load is negative where it has done work.
        let stored: f64 = self.elastic.terms.iter().map(|term| term.energy(&middle).abs()).sum();
        kinetic(velocities)
            + kinetic(&self.state.velocities)
            + 2.0 * self.impulse_time / self.velocity_lead * stored
    }

    /// Gradient with respect to the velocities, N s (2D: N s/m).
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

    /// Hessian with respect to the velocities, kg (2D: kg/m), positive semidefinite if `project_psd`. `None` where
    /// `extra_stiffness` couples vertices that share no element.
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

    /// Largest fraction, at most 1, of a change of the velocities for which all elements keep `kept_fraction` of the volume that they
    /// have at the end of the coming step, at every point of the inversion barriers.
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
