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
//! the law `Ψ`, whose forces `f(q, q')` do the work by which it changes ([`crate::ConservingTerm`]), damping `τ K̂`, the impulses `j` of all
//! other forces, and what keeps elements upright, `U` ([`crate::Crushed`]). The difference of the forces, which have no potential, is
//! lagged ([`Incremental::recentre`]), and so is `K̂`: at `x` the first Newton iteration from `w = 0` is the step that is linear about
//! `x`. Where `l = h/2` the step keeps the energy `½ vᵀ M v + Ψ(q)` of the law and both momenta (energy–momentum method, J. Simo & N. Tarnow
//! 1992); a longer `l` loses `(l/h − ½) wᵀ M w`.

use crate::term::ForceTerm;
use crate::term::extra::add_extra;
use crate::{BlockMatrix, Elastic, ElasticState, StiffnessBlock, Weights};
use meniscus_numerics::{Vector, par};

/// The potential of a solid in a step.
#[derive(Clone, Debug)]
pub struct Incremental<'a, const D: usize> {
    /// The solid.
    pub elastic: &'a Elastic<D>,
    /// Positions that have advanced, and velocities that have not.
    pub state: &'a ElasticState<D>,
    /// Where vertices are for the viscosities `K̂`, m.
    pub viscous_at: Vec<Vector<D>>,
    /// The forces with which the law keeps energy, less those at `y`, N (2D: N/m).
    pub beyond: Vec<Vector<D>>,
    /// Stiffness of other forces.
    pub extra: &'a [StiffnessBlock<D>],
    /// Impulses `j` of all other forces, N s (2D: N s/m).
    pub impulses: &'a [Vector<D>],
    /// Length `h` of the step, s.
    pub step: f64,
    /// How far the new velocities are ahead of the positions, `l`, s: half of the step where steps are of one length.
    pub lead: f64,
    /// The longest that the coming step can be, `a`, s.
    pub ahead: f64,
}

impl<const D: usize> Incremental<'_, D> {
    fn change(&self, velocities: &[Vector<D>]) -> Vec<Vector<D>> {
        velocities.iter().zip(&self.state.velocities).map(|(new, old)| new - old).collect()
    }

    /// Takes viscosities where these velocities lead half-way, and the forces that keep energy between the ends of that way.
    pub fn recentre(&mut self, velocities: &[Vector<D>]) {
        self.viscous_at = self.half_way(velocities);
        let (new, old) = (self.lead, self.step - self.lead);
        let at = |velocities: &[Vector<D>], time: f64| -> Vec<Vector<D>> {
            self.state.positions.iter().zip(velocities).map(|(x, v)| x + v * time).collect()
        };
        let ends = [at(&self.state.velocities, -old), at(velocities, new)];
        self.beyond = self.elastic.forces_between([&ends[0], &ends[1]]);
        let middle = self.elastic.forces(&self.viscous_at);
        self.beyond.iter_mut().zip(&middle).for_each(|(b, m)| *b -= m);
    }

    fn half_way(&self, velocities: &[Vector<D>]) -> Vec<Vector<D>> {
        let (new, old) = (0.5 * self.lead, 0.5 * (self.step - self.lead));
        let way = |k: usize| velocities[k] * new - self.state.velocities[k] * old;
        self.state.positions.iter().enumerate().map(|(k, x)| x + way(k)).collect()
    }

    /// Where the vertices are at the end of the coming step, m.
    pub fn ends(&self, velocities: &[Vector<D>]) -> Vec<Vector<D>> {
        self.state.positions.iter().zip(velocities).map(|(x, v)| x + v * self.ahead).collect()
    }

    /// Impulses of what resists rates of strain, N s.
    fn damping(&self, velocities: &[Vector<D>]) -> Vec<Vector<D>> {
        self.elastic.viscous_forces(&self.viscous_at, velocities, self.step * self.elastic.damping_time)
    }

    /// Its value, J (2D: J/m); infinite where an element has no volume.
    pub fn value(&self, velocities: &[Vector<D>]) -> f64 {
        let (h, w) = (self.step, self.change(velocities));
        let damping = self.damping(velocities);
        let mut extra = vec![Vector::zeros(); w.len()];
        add_extra(self.extra, h, &w, &mut extra);
        let own = par::sum(w.len(), |k| {
            w[k].dot(
                &(w[k] * (0.5 * self.elastic.masses[k])
                    - self.impulses[k]
                    - self.beyond[k] * h
                    - extra[k] * 0.5),
            ) - 0.5 * velocities[k].dot(&damping[k])
        });
        let ends = self.ends(velocities);
        let upright: f64 = self.elastic.upright.iter().map(|u| u.energy(&ends)).sum();
        own + 2.0 * h / self.lead * self.elastic.elastic_energy(&self.half_way(velocities))
            + h / self.ahead * upright
    }

    /// The size of the energies of which it is the sum, J (2D: J/m).
    pub fn size(&self, velocities: &[Vector<D>]) -> f64 {
        let kinetic = |velocities: &[Vector<D>]| self.elastic.kinetic_energy(velocities);
        let stored = self.elastic.elastic_energy(&self.half_way(velocities));
        kinetic(velocities) + kinetic(&self.state.velocities) + 2.0 * self.step / self.lead * stored
    }

    /// Its gradient by the velocities, N s (2D: N s/m).
    pub fn gradient(&self, velocities: &[Vector<D>]) -> Vec<Vector<D>> {
        let (h, w) = (self.step, self.change(velocities));
        let damping = self.damping(velocities);
        let mut forces = self.elastic.forces(&self.half_way(velocities));
        let ends = self.ends(velocities);
        self.elastic.upright.iter().for_each(|u| u.add_forces(&ends, &mut forces));
        let mut extra = vec![Vector::zeros(); w.len()];
        add_extra(self.extra, h, &w, &mut extra);
        let of = |k: usize| {
            w[k] * self.elastic.masses[k]
                - (forces[k] + self.beyond[k]) * h
                - damping[k]
                - self.impulses[k]
                - extra[k]
        };
        (0..w.len()).map(of).collect()
    }

    /// Its second derivatives, kg (2D: kg/m), or their `positive` part.
    pub fn matrix(&self, velocities: &[Vector<D>], positive: bool) -> Option<BlockMatrix<D>> {
        let elastic = self.elastic;
        let viscosity = self.step * elastic.damping_time;
        let mut matrix = elastic.tangent(&self.viscous_at, Weights { stiffness: 0.0, positive, viscosity });
        elastic.masses.iter().enumerate().for_each(|(v, m)| matrix.add_diagonal(v, *m));
        let half_way = self.half_way(velocities);
        let stiffness = 0.5 * self.step * self.lead;
        let weights = Weights { stiffness, positive, viscosity: 0.0 };
        elastic.terms.iter().for_each(|term| term.add_tangent(&half_way, weights, &mut matrix));
        let weights = Weights { stiffness: self.step * self.ahead, ..weights };
        let ends = self.ends(velocities);
        elastic.upright.iter().for_each(|u| u.add_tangent(&ends, weights, &mut matrix));
        let mut put = |e: &StiffnessBlock<D>| {
            matrix.add(e.first, e.second, &(e.block * (0.25 * self.step * self.step)))
        };
        self.extra.iter().all(&mut put).then_some(matrix)
    }

    /// The largest part of a change of the velocities, up to all of it, on which elements keep `keep` of the volume that they have
    /// at the end of the coming step, everywhere where it is looked at.
    pub fn upright_step(&self, velocities: &[Vector<D>], change: &[Vector<D>], keep: f64) -> f64 {
        let (ends, ways) = (self.ends(velocities), change.iter().map(|c| c * self.ahead).collect::<Vec<_>>());
        self.elastic.upright.iter().map(|u| u.upright_step(&ends, &ways, keep)).fold(1.0, f64::min)
    }
}
