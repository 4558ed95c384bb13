//! Coulomb friction as a potential with lagged normal forces and directions (IPC, §5.5), and an elastic slip that is kept from step to
//! step (P. A. Cundall, O. D. L. Strack, "A discrete numerical model for granular assemblies", Géotechnique 29, 1979).
//!
//! Two features with the normal force `N` and the elastic slip `s` have the energy `μ N f(|s|)`, with `f' = 2 y − y²`, `y = |s|/ε`,
//! below the slip limit `ε`, and `f' = 1` beyond. In a step their tangential displacement is added to `s`; after it `s` is limited to
//! `ε` (return mapping). Sticking features are thus held by a spring and do not creep; sliding ones feel the force `μ N`.

use crate::barrier::Contact;
use crate::distance::{ClosestPair, Stencil};
use crate::local_derivatives::LocalDerivatives;
use meniscus_numerics::{Matrix, Vector};

/// Friction with an elastic slip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Friction {
    /// Elastic slip `ε`, m, at which sliding begins.
    pub max_elastic_slip: f64,
}

/// Two features with friction.
#[derive(Clone, Copy, Debug)]
pub struct FrictionPair<const D: usize> {
    /// The two features.
    pub stencil: Stencil,
    /// Weights of their closest points.
    pub weights: [f64; 4],
    /// Unit normal from the second feature to the first.
    pub normal: Vector<D>,
    /// Friction limit `μ N`, N (2D: N/m).
    pub friction_limit: f64,
    /// Elastic slip of the first feature on the second at the start of the motion, m; its normal part is ignored.
    pub slip: Vector<D>,
}

impl<const D: usize> FrictionPair<D> {
    /// A pair in contact with a friction coefficient, without slip; `None` where there is no contact force.
    pub fn new(contact: &Contact, coefficient: f64, x: &[Vector<D>]) -> Option<Self> {
        let friction_limit = coefficient * contact.force(x);
        let closest = ClosestPair::new(contact.stencil.kind, &contact.stencil.positions(x));
        let normal = closest.separation.try_normalize(0.0)?;
        let (stencil, weights, slip) = (contact.stencil, closest.weights, Vector::zeros());
        (friction_limit > 0.0).then_some(Self { stencil, weights, normal, friction_limit, slip })
    }

    /// Tangential displacement of the first feature relative to the second between two configurations, m.
    pub fn tangential_displacement(&self, from: &[Vector<D>], to: &[Vector<D>]) -> Vector<D> {
        let (from, to) = (self.stencil.positions(from), self.stencil.positions(to));
        self.tangential((0..4).map(|k| (to[k] - from[k]) * self.weights[k]).sum())
    }

    /// Slip after a motion, before return mapping.
    fn trial_slip(&self, from: &[Vector<D>], to: &[Vector<D>]) -> Vector<D> {
        self.tangential(self.slip) + self.tangential_displacement(from, to)
    }

    fn tangential(&self, way: Vector<D>) -> Vector<D> {
        way - self.normal * way.dot(&self.normal)
    }
}

impl Friction {
    /// `f`, m, `f'/|s|`, 1/m, and `f''`, 1/m, at a slip.
    fn potential_derivatives(&self, slip: f64) -> [f64; 3] {
        let (e, y) = (self.max_elastic_slip, slip / self.max_elastic_slip);
        if y < 1.0 {
            return [e * y * y * (1.0 - y / 3.0), (2.0 - y) / e, 2.0 * (1.0 - y) / e];
        }
        [slip - e / 3.0, 1.0 / slip, 0.0]
    }

    /// Return mapping of a slip.
    pub fn return_mapped<const D: usize>(&self, slip: Vector<D>) -> Vector<D> {
        slip.cap_magnitude(self.max_elastic_slip)
    }

    /// Slip after the friction limit has changed between two values, N. Where it grows the force is kept, where it decreases the slip.
    /// Neither creates energy (D. Elata, J. G. Berryman, "Contact force-displacement laws and the mechanical behavior of random packs
    /// of identical spheres", Mech. Mater. 24, 1996).
    pub fn rescaled_slip<const D: usize>(&self, slip: &Vector<D>, from: f64, to: f64) -> Vector<D> {
        let slip = self.return_mapped(*slip);
        let Some(along) = slip.try_normalize(0.0).filter(|_| to > from) else { return slip };
        let pull = from / to * slip.norm() * self.potential_derivatives(slip.norm())[1];
        along * (self.max_elastic_slip * (1.0 - (1.0 - pull).max(0.0).sqrt()))
    }

    /// Energy, J (2D: J/m), of a slip under the friction limit `hold`, N (2D: N/m).
    pub fn slip_energy<const D: usize>(&self, hold: f64, slip: &Vector<D>) -> f64 {
        hold * self.potential_derivatives(slip.norm())[0]
    }

    /// Energy, J (2D: J/m), after the motion between two configurations.
    pub fn energy<const D: usize>(
        &self,
        rubbing: &FrictionPair<D>,
        from: &[Vector<D>],
        to: &[Vector<D>],
    ) -> f64 {
        self.slip_energy(rubbing.friction_limit, &rubbing.trial_slip(from, to))
    }

    /// Derivatives of the energy with respect to `to`. The Hessian is positive semidefinite.
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
