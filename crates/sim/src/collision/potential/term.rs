//! Terms of the potential between points of solids, with their derivatives.

use crate::collision::configuration::NodeJacobian;
use meniscus_contact::LocalDerivatives;
use meniscus_numerics::Vector;

/// A term: the points that it is of, with their levers, and its derivatives by their positions.
pub struct PotentialTerm<const D: usize> {
    /// How velocities of nodes move the points.
    pub node_jacobians: Vec<Vec<NodeJacobian<D>>>,
    /// Derivatives.
    pub derivatives: LocalDerivatives<D>,
    /// For how long the points go with the velocities until they are where the derivatives are taken, s.
    pub time: f64,
}

/// Derivatives, by one or two points, of a function of their distance with this slope and bend; the `normal` is the direction away from
/// the second.
pub fn distance_derivatives<const D: usize>(
    normal: &Vector<D>,
    count: usize,
    slope: f64,
    bend: f64,
) -> LocalDerivatives<D> {
    let (mut local, outer) = (LocalDerivatives::zeros(count), normal * normal.transpose() * bend);
    for k in 0..count {
        let sign = 1.0 - 2.0 * k as f64;
        local.gradient[k] = normal * (sign * slope);
        for l in 0..count {
            local.hessian[k][l] = outer * (sign * (1.0 - 2.0 * l as f64));
        }
    }
    local
}
