//! Stable neo-Hookean solids: smooth for any deformation, inverted ones included.

use super::density::{Density, Lame, Principal, cofactor, determinant};
use crate::linalg::pairs;
use meniscus_numerics::{Matrix, Vector};

/// `Ψ = μ/2 (|F|² − D) − μ (J − 1) + (λ + μ)/2 (J − 1)²`, without stress at rest and Hooke's law for small strains
/// (Smith, de Goes & Kim 2018, "Stable neo-Hookean flesh simulation", Eq. 13, `λ + μ` in place of their `λ`). In 2D it is
/// that of plane strain.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NeoHookean;

/// `∂Ψ/∂J`.
fn pressure(lame: Lame, j: f64) -> f64 {
    (lame.lambda + lame.mu) * (j - 1.0) - lame.mu
}

impl<const D: usize> Density<D> for NeoHookean {
    fn energy(&self, lame: Lame, f: &Matrix<D>) -> f64 {
        // In `G = F − 1`, so that small strains are not lost in rounding.
        let g = f - Matrix::identity();
        let trace = g.trace();
        let second = 0.5 * (trace * trace - (g * g).trace());
        let beyond = if D == 2 { second } else { second + determinant(&g) };
        0.5 * lame.mu * g.norm_squared() - lame.mu * beyond
            + 0.5 * (lame.lambda + lame.mu) * (trace + beyond).powi(2)
    }

    fn stress(&self, lame: Lame, f: &Matrix<D>) -> Matrix<D> {
        f * lame.mu + cofactor(f) * pressure(lame, determinant(f))
    }

    fn principal(&self, lame: Lame, stretches: &Vector<D>) -> Principal<D> {
        let but =
            |i: usize, j: usize| (0..D).filter(|k| *k != i && *k != j).map(|k| stretches[k]).product::<f64>();
        let slope = pressure(lame, stretches.product());
        let mut stretch = Matrix::from_fn(|i, j| (lame.lambda + lame.mu) * but(i, i) * but(j, j));
        let (mut shear, mut twist) = ([0.0; 3], [0.0; 3]);
        for i in 0..D {
            stretch[(i, i)] += lame.mu;
        }
        for (k, (i, j)) in pairs::<D>().enumerate() {
            let bend = slope * but(i, j);
            stretch[(i, j)] += bend;
            stretch[(j, i)] += bend;
            shear[k] = lame.mu - bend;
            twist[k] = lame.mu + bend;
        }
        Principal { stretch, shear, twist }
    }
}
