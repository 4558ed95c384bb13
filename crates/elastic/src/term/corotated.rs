//! Corotated linear elasticity: Hooke's law in the frame that rotates with the material.

use super::discrete_gradient::{DiscreteGradientDensity, stretch_discrete_gradient};
use super::energy_density::{EnergyDensity, Lame, PrincipalHessian};
use crate::linalg::svd;
use meniscus_numerics::{Matrix, Vector};

/// `Ψ = μ |F − R|² + λ/2 tr(RᵀF − 1)²` with the rotation `R` nearest to `F` (Müller & Gross 2004; Sifakis & Barbič 2012, §3.4). In
/// 2D it is plane strain. Limit: the force of an element has a kink where `R` is not unique.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Corotated;

impl<const D: usize> EnergyDensity<D> for Corotated {
    const HAS_VOLUMETRIC: bool = true;

    fn energy(&self, lame: Lame, f: &Matrix<D>) -> f64 {
        lame.mu * svd(f).values.add_scalar(-1.0).norm_squared()
    }

    fn stress(&self, lame: Lame, f: &Matrix<D>) -> Matrix<D> {
        (f - turned(f)) * (2.0 * lame.mu)
    }

    fn principal_hessian(&self, lame: Lame, stretches: &Vector<D>, pressure: f64) -> PrincipalHessian<D> {
        let mut twist = [0.0; 3];
        for (k, (i, j)) in crate::linalg::axis_pairs::<D>().enumerate() {
            let sum = stretches[i] + stretches[j];
            // `R` jumps where the sum vanishes; the curvature there is negative and is omitted.
            twist[k] = if sum > 1e-12 { 2.0 * lame.mu + (2.0 * pressure - 4.0 * lame.mu) / sum } else { 0.0 };
        }
        PrincipalHessian { stretch: Matrix::identity() * (2.0 * lame.mu), shear: [2.0 * lame.mu; 3], twist }
    }

    fn volume_change(&self, f: &Matrix<D>) -> f64 {
        svd(f).values.sum() - D as f64
    }

    fn volume_change_gradient(&self, f: &Matrix<D>) -> Matrix<D> {
        turned(f)
    }

    fn volumetric_energy(&self, lame: Lame, theta: f64) -> [f64; 3] {
        [0.5 * lame.lambda * theta * theta, lame.lambda * theta, lame.lambda]
    }
}

impl<const D: usize> DiscreteGradientDensity<D> for Corotated {
    fn stress_between(&self, lame: Lame, ends: [&Matrix<D>; 2]) -> Matrix<D> {
        (Matrix::identity() - stretch_discrete_gradient(ends)) * (2.0 * lame.mu)
    }

    fn volume_discrete_gradient(&self, ends: [&Matrix<D>; 2]) -> Matrix<D> {
        stretch_discrete_gradient(ends)
    }

    fn pressure_between(&self, lame: Lame, [first, last]: [f64; 2]) -> f64 {
        0.5 * lame.lambda * (first + last)
    }
}

/// Rotation nearest to `F`.
fn turned<const D: usize>(f: &Matrix<D>) -> Matrix<D> {
    let frame = svd(f);
    frame.u * frame.v.transpose()
}
