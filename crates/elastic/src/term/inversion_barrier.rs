//! Barrier against the inversion of elements: `Ψ = κ β(J/J₀)` for volume ratios `J < J₀`, with `β(t) = −(1 − t)² ln t` as for contacts
//! (`meniscus_contact`).
//!
//! The barrier is evaluated at the end of the coming step, not at the midpoint as the law ([`crate::IncrementalPotential`]), so no
//! accepted step inverts an element. It acts on the linear parts of quadratic simplices, which the law does not protect, and at the
//! quadrature points of the law.

use super::energy_density::{EnergyDensity, Lame, PrincipalHessian, cofactor, determinant};
use crate::linalg::axis_pairs;
use meniscus_numerics::{Matrix, Vector};

/// Volume ratio `J₀` below which the barrier acts: milder strains obey the law alone.
pub const CRUSHED_VOLUME_RATIO: f64 = 0.3;

/// Energy density of the barrier. `κ` is passed as the first Lamé parameter: `λ + 2 μ` of the law, or for
/// springs of the stiffness `k` `k l²/V` with the volume `V` and the mean square edge `l²` of the element.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct InversionBarrier;

/// `Ψ/κ` and its first and second derivatives with respect to `J`.
fn barrier_derivatives(j: f64) -> [f64; 3] {
    let (t, rest) = (j / CRUSHED_VOLUME_RATIO, 1.0 - j / CRUSHED_VOLUME_RATIO);
    if rest <= 0.0 {
        return [0.0; 3];
    }
    if t <= 0.0 {
        return [f64::INFINITY; 3];
    }
    let log = t.ln();
    let slope = 2.0 * rest * log - rest * rest / t;
    let bend = rest * (4.0 + rest / t) / t - 2.0 * log;
    [-rest * rest * log, slope / CRUSHED_VOLUME_RATIO, bend / (CRUSHED_VOLUME_RATIO * CRUSHED_VOLUME_RATIO)]
}

impl<const D: usize> EnergyDensity<D> for InversionBarrier {
    fn is_inactive(&self, f: &Matrix<D>) -> bool {
        determinant(f) >= CRUSHED_VOLUME_RATIO
    }

    fn energy(&self, lame: Lame, f: &Matrix<D>) -> f64 {
        lame.lambda * barrier_derivatives(determinant(f))[0]
    }

    fn stress(&self, lame: Lame, f: &Matrix<D>) -> Matrix<D> {
        let [_, slope, _] = barrier_derivatives(determinant(f));
        if slope == 0.0 { Matrix::zeros() } else { cofactor(f) * (lame.lambda * slope) }
    }

    fn principal_hessian(&self, lame: Lame, stretches: &Vector<D>, _: f64) -> PrincipalHessian<D> {
        let [_, slope, bend] = barrier_derivatives(stretches.product()).map(|b| b * lame.lambda);
        let product_without =
            |i: usize, j: usize| (0..D).filter(|k| *k != i && *k != j).map(|k| stretches[k]).product::<f64>();
        let mut stretch = Matrix::from_fn(|i, j| bend * product_without(i, i) * product_without(j, j));
        let (mut shear, mut twist) = ([0.0; 3], [0.0; 3]);
        for (k, (i, j)) in axis_pairs::<D>().enumerate() {
            let rest = slope * product_without(i, j);
            stretch[(i, j)] += rest;
            stretch[(j, i)] += rest;
            (shear[k], twist[k]) = (-rest, rest);
        }
        PrincipalHessian { stretch, shear, twist }
    }
}
