//! Barrier energy of two features.

use crate::distance::{ClosestPair, Stencil, StencilKind};
use crate::local_derivatives::LocalDerivatives;
use crate::mollifier::Mollifier;
use meniscus_numerics::{Matrix, Vector};

/// Barrier with an activation distance; a contact may have a smaller one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Barrier {
    /// Activation distance `d̂`, m: features at this distance or farther do not interact.
    pub activation_distance: f64,
}

/// Two features closer than the activation distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// The two features.
    pub stencil: Stencil,
    /// Area weight of the pair, m² (2D: length, m).
    pub area: f64,
    /// Stiffness `κ`, Pa: the contact pressure at 0.53 of the activation distance, where `β' = −1`.
    pub stiffness: f64,
    /// For two edges: product of their squared rest lengths, m⁴.
    pub squared_length_product: f64,
    /// Distance, m, that counts as zero: radius of a ball around the first point.
    pub thickness: f64,
    /// Activation distance, m, measured from the thickness.
    pub activation_distance: f64,
}

/// `β(t) = −(1 − t)² ln t` for `0 < t < 1`, and its first and second derivatives.
fn normalised_barrier(t: f64) -> [f64; 3] {
    let (rest, log) = (1.0 - t, t.ln());
    [-rest * rest * log, 2.0 * rest * log - rest * rest / t, rest * (4.0 + rest / t) / t - 2.0 * log]
}

impl Barrier {
    /// Energy over `a κ`, m, and its derivatives with respect to the distance; infinite where the distance is not positive.
    pub fn derivatives_by_distance(&self, distance: f64) -> [f64; 3] {
        if distance >= self.activation_distance {
            return [0.0; 3];
        }
        if distance <= 0.0 {
            return [f64::INFINITY; 3];
        }
        let [value, slope, bend] = normalised_barrier(distance / self.activation_distance);
        [value * self.activation_distance, slope, bend / self.activation_distance]
    }
}

impl Contact {
    /// [`Barrier::derivatives_by_distance`] of the distance less the thickness.
    fn derivatives_by_distance(&self, distance: f64) -> [f64; 3] {
        Barrier { activation_distance: self.activation_distance }
            .derivatives_by_distance(distance - self.thickness)
    }

    /// The same with derivatives with respect to the squared distance.
    fn derivatives_by_squared_distance(&self, square: f64) -> [f64; 3] {
        let distance = square.sqrt();
        let [value, slope, bend] = self.derivatives_by_distance(distance);
        [value, slope / (2.0 * distance), (bend - slope / distance) / (4.0 * square)]
    }

    /// Energy at positions, J (2D: J/m); infinite where the features touch.
    pub fn energy<const D: usize>(&self, x: &[Vector<D>]) -> f64 {
        let at = self.stencil.positions(x);
        let [value, ..] = self.derivatives_by_distance(ClosestPair::new(self.stencil.kind, &at).distance());
        let share = self.mollifier(&at).map_or(1.0, |m| m.value);
        if value > 0.0 { self.area * self.stiffness * value * share } else { 0.0 }
    }

    /// Distance of the features at positions, m.
    pub fn distance<const D: usize>(&self, x: &[Vector<D>]) -> f64 {
        ClosestPair::new(self.stencil.kind, &self.stencil.positions(x)).distance()
    }

    /// Magnitude of the contact force, N (2D: N/m).
    pub fn force<const D: usize>(&self, x: &[Vector<D>]) -> f64 {
        let at = self.stencil.positions(x);
        let closest = ClosestPair::new(self.stencil.kind, &at);
        let share = self.mollifier(&at).map_or(1.0, |m| m.value);
        -self.area * self.stiffness * share * self.derivatives_by_distance(closest.distance())[1]
    }

    /// Derivatives at positions; `None` beyond the activation distance. The Hessian is not projected.
    pub fn derivatives<const D: usize>(&self, x: &[Vector<D>]) -> Option<LocalDerivatives<D>> {
        let at = self.stencil.positions(x);
        let closest = ClosestPair::new(self.stencil.kind, &at);
        let [value, slope, bend] = self.derivatives_by_squared_distance(closest.squared_distance());
        if value == 0.0 {
            return None;
        }
        let scale = self.area * self.stiffness;
        let mut local = LocalDerivatives::zeros(self.stencil.kind.point_count());
        let curvature = closest.squared_distance_hessian(&at);
        let along = closest.weights.map(|w| closest.separation * (2.0 * w));
        let mollifier = self.mollifier(&at);
        let share = mollifier.as_ref().map_or(1.0, |m| m.value);
        for k in 0..local.point_count {
            local.gradient[k] = along[k] * (scale * share * slope);
            for l in 0..local.point_count {
                local.hessian[k][l] =
                    (along[k] * along[l].transpose() * bend + curvature(k, l) * slope) * (scale * share);
            }
        }
        if let Some(m) = mollifier {
            for k in 0..local.point_count {
                local.gradient[k] += m.gradient[k] * (scale * value);
                for l in 0..local.point_count {
                    let mixed: Matrix<D> =
                        m.gradient[k] * along[l].transpose() + along[k] * m.gradient[l].transpose();
                    local.hessian[k][l] += m.hessian[k][l] * (scale * value) + mixed * (scale * slope);
                }
            }
        }
        Some(local)
    }

    fn mollifier<const D: usize>(&self, at: &[Vector<D>; 4]) -> Option<Mollifier<D>> {
        if self.stencil.kind == StencilKind::EdgeEdge {
            Mollifier::new(at, self.squared_length_product)
        } else {
            None
        }
    }
}
