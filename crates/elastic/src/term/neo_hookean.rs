//! Neo-Hookean solids: rubber, which no force presses to nothing.
//!
//! ```text
//! Ψ = μ/2 (|F|² − D) − μ ln J + λ/2 (ln J)²,        J = det F
//! ```
//!
//! (J. Simo & K. Pister 1984; Bonet & Wood, "Nonlinear Continuum Mechanics for Finite Element Analysis", §6.4.3), without stress at
//! rest and Hooke's law for small strains; in 2D it is that of plane strain. The energy has no bound as the volume goes to zero and is
//! infinite beyond: a search for the least of it never turns an element inside out. Limit: stretched beyond `J = e` to all sides it
//! yields more the more it is stretched.

use super::density::{Density, Lame, Principal, cofactor, determinant};
use crate::linalg::pairs;
use meniscus_numerics::{Matrix, Vector};

/// The density.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NeoHookean;

/// `|j|` below which `j − ln (1 + j)` is summed, so that small strains are not lost in rounding: 14 terms make 1e-16 of the first.
const SMALL: f64 = 0.06;
const TERMS: i32 = 14;

/// `j − ln (1 + j)`.
fn above_log(j: f64) -> f64 {
    if j.abs() > SMALL {
        return j - j.ln_1p();
    }
    // j²/2 − j³/3 + j⁴/4 …
    j * j * (2..TERMS + 2).rev().fold(0.0, |sum, k| 1.0 / f64::from(k) - j * sum)
}

/// `∂Ψ/∂J`; not a number where there is no volume.
fn slope(lame: Lame, j: f64) -> f64 {
    (lame.lambda * j.ln() - lame.mu) / j
}

impl<const D: usize> Density<D> for NeoHookean {
    fn energy(&self, lame: Lame, f: &Matrix<D>) -> f64 {
        // In `G = F − 1` and `j = J − 1 = tr G + …`: `(|F|² − D)/2 − ln J = |G|²/2 + (j − ln (1 + j)) − (j − tr G)`.
        let g = f - Matrix::identity();
        let trace = g.trace();
        let second = 0.5 * (trace * trace - (g * g).trace());
        let beyond = if D == 2 { second } else { second + determinant(&g) };
        let j = trace + beyond;
        if j <= -1.0 {
            return f64::INFINITY;
        }
        lame.mu * (0.5 * g.norm_squared() + above_log(j) - beyond) + 0.5 * lame.lambda * j.ln_1p().powi(2)
    }

    fn stress(&self, lame: Lame, f: &Matrix<D>) -> Matrix<D> {
        f * lame.mu + cofactor(f) * slope(lame, determinant(f))
    }

    fn principal(&self, lame: Lame, stretches: &Vector<D>) -> Principal<D> {
        let volume = stretches.product();
        let slope = slope(lame, volume);
        // `J ∂Ψ/∂J`, and `J ∂/∂J` of that: `Ψ = μ/2 Σ σ² + φ(Σ ln σ)`.
        let (first, second) = (slope * volume, lame.lambda);
        let mut stretch = Matrix::from_fn(|i, j| second / (stretches[i] * stretches[j]));
        let (mut shear, mut twist) = ([0.0; 3], [0.0; 3]);
        for i in 0..D {
            stretch[(i, i)] += lame.mu - first / (stretches[i] * stretches[i]);
        }
        for (k, (i, j)) in pairs::<D>().enumerate() {
            let bend = first / (stretches[i] * stretches[j]);
            shear[k] = lame.mu - bend;
            twist[k] = lame.mu + bend;
        }
        Principal { stretch, shear, twist }
    }
}
