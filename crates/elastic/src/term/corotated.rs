//! Corotated linear solids: Hooke's law in the frame that turns with the material.

use super::density::{Density, Lame, Principal};
use crate::linalg::svd;
use meniscus_numerics::{Matrix, Vector};

/// `Ψ = μ |F − R|² + λ/2 tr(RᵀF − 1)²` with the rotation `R` nearest to `F` (Müller & Gross 2004; Sifakis & Barbič 2012,
/// §3.4). In 2D it is that of plane strain. Where an element is inverted to a point, its force has a kink.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Corotated;

impl<const D: usize> Density<D> for Corotated {
    fn energy(&self, lame: Lame, f: &Matrix<D>) -> f64 {
        let strains = svd(f).values.add_scalar(-1.0);
        lame.mu * strains.norm_squared() + 0.5 * lame.lambda * strains.sum().powi(2)
    }

    fn stress(&self, lame: Lame, f: &Matrix<D>) -> Matrix<D> {
        let frame = svd(f);
        let turned = frame.u * frame.v.transpose();
        (f - turned) * (2.0 * lame.mu) + turned * (lame.lambda * (frame.values.sum() - D as f64))
    }

    fn principal(&self, lame: Lame, stretches: &Vector<D>) -> Principal<D> {
        let stretch = Matrix::identity() * (2.0 * lame.mu) + Matrix::repeat(lame.lambda);
        let mut twist = [0.0; 3];
        let spread = 2.0 * lame.lambda * (stretches.sum() - D as f64) - 4.0 * lame.mu;
        for (k, (i, j)) in crate::linalg::pairs::<D>().enumerate() {
            let sum = stretches[i] + stretches[j];
            // The rotation jumps where the sum vanishes; the curvature there is negative and left out.
            twist[k] = if sum > 1e-12 { 2.0 * lame.mu + spread / sum } else { 0.0 };
        }
        Principal { stretch, shear: [2.0 * lame.mu; 3], twist }
    }
}
