//! What the velocities at the end of a step make least: an incremental potential.
//!
//! With the change `w = v' − v` of the velocities, `y = x + h w/4` half-way, and `z = x + a v'` where the coming step ends at the
//! latest, that is
//!
//! ```text
//! ½ wᵀ M w + 4 Ψ(y) + ½ h τ v'ᵀ K̂ v' + θ h² (u + (¼ + θ/8) w)ᵀ K̂ w − jᵀ w + h/a U(z):
//! ```
//!
//! the law `Ψ`, damping and dissipation of [`crate::step`], the impulses `j` of all other forces, and what keeps elements upright,
//! `U` ([`crate::Crushed`]). `K̂` is that at [`Incremental::viscous_at`]: at `x` the first Newton iteration from `w = 0` is the step
//! that is linear about `x`; at `y` all forces keep the angular momentum there.

use crate::step::add_extra;
use crate::term::ForceTerm;
use crate::{BlockMatrix, Elastic, ElasticState, Integrator, StiffnessBlock, Weights};
use meniscus_numerics::{Vector, par};

/// Modes that a step does not resolve end at once, `θ = 1`: with half of it elements that stiffen as they are crushed won energy in two
/// of 22 wet scenes, a hundred times what there was.
const DISSIPATION: f64 = 1.0;
const INTEGRATOR: Integrator = Integrator { dissipation: DISSIPATION, iterations: 0 };

/// The potential of a solid in a step.
#[derive(Clone, Debug)]
pub struct Incremental<'a, const D: usize> {
    /// The solid.
    pub elastic: &'a Elastic<D>,
    /// Positions that have advanced, and velocities that have not.
    pub state: &'a ElasticState<D>,
    /// The part `u` of these that the step does not resolve, m/s.
    pub fast: Vec<Vector<D>>,
    /// Where vertices are for the viscosities `K̂`, m.
    pub viscous_at: Vec<Vector<D>>,
    /// Stiffness of other forces.
    pub extra: &'a [StiffnessBlock<D>],
    /// Impulses `j` of all other forces, N s (2D: N s/m).
    pub impulses: &'a [Vector<D>],
    /// Length `h` of the step, s.
    pub step: f64,
    /// The longest that the coming step can be, `a`, s.
    pub ahead: f64,
}

impl<const D: usize> Incremental<'_, D> {
    fn change(&self, velocities: &[Vector<D>]) -> Vec<Vector<D>> {
        velocities.iter().zip(&self.state.velocities).map(|(new, old)| new - old).collect()
    }

    /// Takes viscosities where these velocities lead half-way.
    pub fn recentre(&mut self, velocities: &[Vector<D>]) {
        self.viscous_at = self.half_way(&self.change(velocities));
    }

    fn half_way(&self, change: &[Vector<D>]) -> Vec<Vector<D>> {
        let part = 0.25 * self.step;
        self.state.positions.iter().zip(change).map(|(x, w)| x + w * part).collect()
    }

    /// Where the vertices are at the end of the coming step, m.
    pub fn ends(&self, velocities: &[Vector<D>]) -> Vec<Vector<D>> {
        self.state.positions.iter().zip(velocities).map(|(x, v)| x + v * self.ahead).collect()
    }

    /// What resists rates of strain: impulses, N s.
    fn viscous(&self, velocities: &[Vector<D>], change: &[Vector<D>], share: f64) -> [Vec<Vector<D>>; 2] {
        let (x, h) = (&self.viscous_at, self.step);
        let between: Vec<Vector<D>> = self.fast.iter().zip(change).map(|(u, w)| u + w * share).collect();
        let theta = DISSIPATION;
        let damping = self.elastic.viscous_forces(x, velocities, h * self.elastic.damping_time);
        [damping, self.elastic.viscous_forces(x, &between, theta * h * h)]
    }

    /// Its value, J (2D: J/m); infinite where an element has no volume.
    pub fn value(&self, velocities: &[Vector<D>]) -> f64 {
        let (h, theta) = (self.step, DISSIPATION);
        let w = self.change(velocities);
        let [damping, fast] = self.viscous(velocities, &w, 0.25 + 0.125 * theta);
        let mut extra = vec![Vector::zeros(); w.len()];
        add_extra(self.extra, h, &w, &mut extra);
        let own = par::sum(w.len(), |k| {
            w[k].dot(&(w[k] * (0.5 * self.elastic.masses[k]) - fast[k] - self.impulses[k] - extra[k] * 0.5))
                - 0.5 * velocities[k].dot(&damping[k])
        });
        let ends = self.ends(velocities);
        let upright: f64 = self.elastic.upright.iter().map(|u| u.energy(&ends)).sum();
        own + 4.0 * self.elastic.elastic_energy(&self.half_way(&w)) + h / self.ahead * upright
    }

    /// Its gradient by the velocities, N s (2D: N s/m).
    pub fn gradient(&self, velocities: &[Vector<D>]) -> Vec<Vector<D>> {
        let (h, theta) = (self.step, DISSIPATION);
        let w = self.change(velocities);
        let [damping, fast] = self.viscous(velocities, &w, 0.5 + 0.25 * theta);
        let mut forces = self.elastic.forces(&self.half_way(&w));
        let ends = self.ends(velocities);
        self.elastic.upright.iter().for_each(|u| u.add_forces(&ends, &mut forces));
        let mut extra = vec![Vector::zeros(); w.len()];
        add_extra(self.extra, h, &w, &mut extra);
        let of = |k: usize| {
            w[k] * self.elastic.masses[k] - forces[k] * h - damping[k] - fast[k] - self.impulses[k] - extra[k]
        };
        (0..w.len()).map(of).collect()
    }

    /// Its second derivatives, kg (2D: kg/m), or their `positive` part.
    pub fn matrix(&self, velocities: &[Vector<D>], positive: bool) -> Option<BlockMatrix<D>> {
        let elastic = self.elastic;
        let own = INTEGRATOR.weights(self.step, elastic.damping_time);
        let mut matrix = elastic.tangent(&self.viscous_at, Weights { stiffness: 0.0, ..own });
        elastic.masses.iter().enumerate().for_each(|(v, m)| matrix.add_diagonal(v, *m));
        let half_way = self.half_way(&self.change(velocities));
        let weights = Weights { positive, viscosity: 0.0, ..own };
        elastic.terms.iter().for_each(|term| term.add_tangent(&half_way, weights, &mut matrix));
        let weights = Weights { stiffness: self.step * self.ahead, ..weights };
        let ends = self.ends(velocities);
        elastic.upright.iter().for_each(|u| u.add_tangent(&ends, weights, &mut matrix));
        let mut put = |e: &StiffnessBlock<D>| matrix.add(e.first, e.second, &(e.block * own.stiffness));
        self.extra.iter().all(&mut put).then_some(matrix)
    }

    /// The largest part of a change of the velocities, up to all of it, on which elements keep `keep` of the volume that they have
    /// at the end of the coming step, everywhere where it is looked at.
    pub fn upright_step(&self, velocities: &[Vector<D>], change: &[Vector<D>], keep: f64) -> f64 {
        let (ends, ways) = (self.ends(velocities), change.iter().map(|c| c * self.ahead).collect::<Vec<_>>());
        self.elastic.upright.iter().map(|u| u.upright_step(&ends, &ways, keep)).fold(1.0, f64::min)
    }
}
