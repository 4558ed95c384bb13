//! Friction: Coulomb's law as a potential, with normal forces and directions of the last look (IPC, §5.5), of a slip that is carried
//! from step to step (P. A. Cundall, O. D. L. Strack, "A discrete numerical model for granular assemblies", Géotechnique 29, 1979).
//!
//! Two features that press each other with `N`, with the elastic slip `s`, have the energy `μ N f(|s|)`, with `f' = 2 y − y²`,
//! `y = |s|/ε`, below the slip `ε`, and 1 beyond. In a step `s` grows by their way along each other; after it `s` is limited to `ε`
//! (return mapping). So what sticks is held by a spring, and does not creep; what slides is held by `μ N`.

use crate::barrier::Contact;
use crate::distance::{ClosestPair, Stencil};
use crate::local_derivatives::LocalDerivatives;
use meniscus_numerics::{Matrix, Vector};

/// Friction with an elastic slip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Friction {
    /// The elastic slip, m, from which on things slide.
    pub max_elastic_slip: f64,
}

/// Two features that rub each other.
#[derive(Clone, Copy, Debug)]
pub struct FrictionPair<const D: usize> {
    /// Their points.
    pub stencil: Stencil,
    /// Weights of the points closest to each other.
    pub weights: [f64; 4],
    /// Direction from the second feature to the first.
    pub normal: Vector<D>,
    /// Friction's coefficient times the normal force, N (2D: N/m).
    pub friction_limit: f64,
    /// Elastic slip of the first along the second at the places from which they go, m; what of it is along the normal does not count.
    pub slip: Vector<D>,
}

impl<const D: usize> FrictionPair<D> {
    /// Of two features in contact with a coefficient of friction, without slip; nothing out of reach.
    pub fn new(contact: &Contact, coefficient: f64, x: &[Vector<D>]) -> Option<Self> {
        let friction_limit = coefficient * contact.force(x);
        let closest = ClosestPair::new(contact.stencil.kind, &contact.stencil.positions(x));
        let normal = closest.separation.try_normalize(0.0)?;
        let (stencil, weights, slip) = (contact.stencil, closest.weights, Vector::zeros());
        (friction_limit > 0.0).then_some(Self { stencil, weights, normal, friction_limit, slip })
    }

    /// How far the features go along each other between two places, m.
    pub fn tangential_displacement(&self, from: &[Vector<D>], to: &[Vector<D>]) -> Vector<D> {
        let (from, to) = (self.stencil.positions(from), self.stencil.positions(to));
        self.tangential((0..4).map(|k| (to[k] - from[k]) * self.weights[k]).sum())
    }

    /// The slip that they come to.
    fn trial_slip(&self, from: &[Vector<D>], to: &[Vector<D>]) -> Vector<D> {
        self.tangential(self.slip) + self.tangential_displacement(from, to)
    }

    fn tangential(&self, way: Vector<D>) -> Vector<D> {
        way - self.normal * way.dot(&self.normal)
    }
}

impl Friction {
    /// `f`, m, `f'/|s|`, 1/m, and `f''`, 1/m, of a slip.
    fn potential_derivatives(&self, slip: f64) -> [f64; 3] {
        let (e, y) = (self.max_elastic_slip, slip / self.max_elastic_slip);
        if y < 1.0 {
            return [e * y * y * (1.0 - y / 3.0), (2.0 - y) / e, 2.0 * (1.0 - y) / e];
        }
        [slip - e / 3.0, 1.0 / slip, 0.0]
    }

    /// A slip after return mapping.
    pub fn return_mapped<const D: usize>(&self, slip: Vector<D>) -> Vector<D> {
        slip.cap_magnitude(self.max_elastic_slip)
    }

    /// A slip after its hold has changed between two values, N: where the hold grows the force stays, where it falls the slip does. Either
    /// way no energy is won (D. Elata, J. G. Berryman, "Contact force-displacement laws and the mechanical behavior of random packs of
    /// identical spheres", Mech. Mater. 24, 1996).
    pub fn rescaled_slip<const D: usize>(&self, slip: &Vector<D>, from: f64, to: f64) -> Vector<D> {
        let slip = self.return_mapped(*slip);
        let Some(along) = slip.try_normalize(0.0).filter(|_| to > from) else { return slip };
        let pull = from / to * slip.norm() * self.potential_derivatives(slip.norm())[1];
        along * (self.max_elastic_slip * (1.0 - (1.0 - pull).max(0.0).sqrt()))
    }

    /// Energy, J (2D: J/m), of a slip under a hold, N (2D: N/m).
    pub fn slip_energy<const D: usize>(&self, hold: f64, slip: &Vector<D>) -> f64 {
        hold * self.potential_derivatives(slip.norm())[0]
    }

    /// Energy, J (2D: J/m), of the way from one place to another.
    pub fn energy<const D: usize>(
        &self,
        rubbing: &FrictionPair<D>,
        from: &[Vector<D>],
        to: &[Vector<D>],
    ) -> f64 {
        self.slip_energy(rubbing.friction_limit, &rubbing.trial_slip(from, to))
    }

    /// Derivatives by the place come to. The Hessian is positive semidefinite.
    pub fn derivatives<const D: usize>(
        &self,
        rubbing: &FrictionPair<D>,
        from: &[Vector<D>],
        to: &[Vector<D>],
    ) -> LocalDerivatives<D> {
        let slid = rubbing.trial_slip(from, to);
        let [_, pull, bend] = self.potential_derivatives(slid.norm());
        let across = Matrix::identity() - rubbing.normal * rubbing.normal.transpose();
        let along = slid.try_normalize(0.0).unwrap_or(Vector::zeros());
        let outer = along * along.transpose();
        let whole = ((across - outer) * pull + outer * bend.max(0.0)) * rubbing.friction_limit;
        let mut local = LocalDerivatives::zeros(rubbing.stencil.kind.point_count());
        let w = &rubbing.weights;
        for k in 0..local.point_count {
            local.gradient[k] = slid * (pull * rubbing.friction_limit * w[k]);
            for l in 0..local.point_count {
                local.hessian[k][l] = whole * (w[k] * w[l]);
            }
        }
        local
    }
}
