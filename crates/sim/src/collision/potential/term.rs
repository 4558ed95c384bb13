//! Terms of the potential between points of solids, with their derivatives.

use crate::collision::configuration::NodeJacobian;
use meniscus_contact::LocalDerivatives;
use meniscus_numerics::Vector;

/// A term with its points, their Jacobians, and the derivatives by their positions.
pub struct PotentialTerm<const D: usize> {
    /// Jacobians of the points by the velocities of the nodes.
    pub node_jacobians: Vec<Vec<NodeJacobian<D>>>,
    /// Gradient and Hessian by the points' positions.
    pub derivatives: LocalDerivatives<D>,
    /// Time for which the points move with the velocities to where the derivatives are evaluated, s.
    pub time: f64,
}

/// Derivatives, by one or two points, of a function of their distance with the first and second derivatives `slope` and `bend`. The
/// `normal` points away from the second point.
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
