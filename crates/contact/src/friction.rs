//! Friction: Coulomb's law as a potential, with normal forces and directions of the last look (IPC, §5.5).
//!
//! Two features that press each other with `N` and have moved by `u` along each other in a step have the energy `μ N f(|u|)`, with
//! `f' = 2 y − y²`, `y = |u|/ε`, below a way `ε`, and 1 beyond: what sticks creeps by less than `ε` a step.

use crate::barrier::Contact;
use crate::distance::{Closest, Stencil};
use crate::local::Local;
use meniscus_numerics::{Matrix, Vector};

/// Friction below a way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Friction {
    /// The way in a step, m, below which things stick.
    pub stick: f64,
}

/// Two features that rub each other.
#[derive(Clone, Copy, Debug)]
pub struct Rubbing<const D: usize> {
    /// Their points.
    pub stencil: Stencil,
    /// Weights of the points closest to each other.
    pub weights: [f64; 4],
    /// Direction from the second feature to the first.
    pub normal: Vector<D>,
    /// Friction's coefficient times the normal force, N (2D: N/m).
    pub hold: f64,
}

impl<const D: usize> Rubbing<D> {
    /// Of two features in contact with a coefficient of friction; nothing out of reach.
    pub fn new(contact: &Contact, coefficient: f64, x: &[Vector<D>]) -> Option<Self> {
        let hold = coefficient * contact.force(x);
        let closest = Closest::new(contact.stencil.kind, &contact.stencil.of(x));
        let normal = closest.apart.try_normalize(0.0)?;
        (hold > 0.0).then_some(Self { stencil: contact.stencil, weights: closest.weights, normal, hold })
    }

    /// How far the features have slid along each other between two places, m.
    fn slid(&self, from: &[Vector<D>], to: &[Vector<D>]) -> Vector<D> {
        let (from, to) = (self.stencil.of(from), self.stencil.of(to));
        let way: Vector<D> = (0..4).map(|k| (to[k] - from[k]) * self.weights[k]).sum();
        way - self.normal * way.dot(&self.normal)
    }
}

impl Friction {
    /// `∫ f'`, m, `f'/|u|`, 1/m, and `f''`, 1/m.
    fn of(&self, way: f64) -> [f64; 3] {
        let (e, y) = (self.stick, way / self.stick);
        if y < 1.0 {
            return [e * y * y * (1.0 - y / 3.0), (2.0 - y) / e, 2.0 * (1.0 - y) / e];
        }
        [way - e / 3.0, 1.0 / way, 0.0]
    }

    /// Energy, J (2D: J/m), of the way from one place to another.
    pub fn energy<const D: usize>(&self, rubbing: &Rubbing<D>, from: &[Vector<D>], to: &[Vector<D>]) -> f64 {
        rubbing.hold * self.of(rubbing.slid(from, to).norm())[0]
    }

    /// Derivatives by the place come to. The Hessian is positive semidefinite.
    pub fn derivatives<const D: usize>(
        &self,
        rubbing: &Rubbing<D>,
        from: &[Vector<D>],
        to: &[Vector<D>],
    ) -> Local<D> {
        let slid = rubbing.slid(from, to);
        let [_, pull, bend] = self.of(slid.norm());
        let across = Matrix::identity() - rubbing.normal * rubbing.normal.transpose();
        let along = slid.try_normalize(0.0).unwrap_or(Vector::zeros());
        let outer = along * along.transpose();
        let whole = ((across - outer) * pull + outer * bend.max(0.0)) * rubbing.hold;
        let mut local = Local::zeros(rubbing.stencil.kind.count());
        let w = &rubbing.weights;
        for k in 0..local.count {
            local.gradient[k] = slid * (pull * rubbing.hold * w[k]);
            for l in 0..local.count {
                local.hessian[k][l] = whole * (w[k] * w[l]);
            }
        }
        local
    }
}
