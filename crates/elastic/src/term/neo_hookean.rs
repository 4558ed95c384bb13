//! Neo-Hookean solids: rubber, which no force presses to nothing.
//!
//! ```text
//! Ψ = μ/2 (|F|² − D) − μ ln J + λ/2 (ln J)²,        J = det F
//! ```
//!
//! (J. Simo & K. Pister 1984; Bonet & Wood, "Nonlinear Continuum Mechanics for Finite Element Analysis", §6.4.3), without stress at
//! rest and Hooke's law for small strains; in 2D it is that of plane strain. The last part is that of the projected change of volume. The energy has no bound as the volume goes to zero and is
//! infinite beyond: a search for the least of it never turns an element inside out. Limit: stretched beyond `J = e` to all sides it
//! yields more the more it is stretched.

use super::conserving::{Conserving, determinant_slope, log_slope, volumes};
use super::density::{Density, Lame, Principal, beyond_trace, cofactor, determinant, dilation};
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

impl<const D: usize> Density<D> for NeoHookean {
    const PROJECTED: bool = true;

    fn energy(&self, lame: Lame, f: &Matrix<D>) -> f64 {
        // In `G = F − 1` and `j = J − 1`: `(|F|² − D)/2 − ln J = |G|²/2 + (j − ln (1 + j)) − (j − tr G)`.
        let g = f - Matrix::identity();
        let beyond = beyond_trace(&g);
        let j = g.trace() + beyond;
        if j <= -1.0 {
            return f64::INFINITY;
        }
        lame.mu * (0.5 * g.norm_squared() + above_log(j) - beyond)
    }

    fn stress(&self, lame: Lame, f: &Matrix<D>) -> Matrix<D> {
        // Not a number where there is no volume.
        f * lame.mu - cofactor(f) * (lame.mu / determinant(f))
    }

    fn principal(&self, lame: Lame, stretches: &Vector<D>, pressure: f64) -> Principal<D> {
        // Of the product of stretches without two of them, `p J / (σ_i σ_j)`, and of the logarithm, `−μ / (σ_i σ_j)` but in the stretches.
        let volume = stretches.product();
        let (mut stretch, mut shear, mut twist) = (Matrix::zeros(), [0.0; 3], [0.0; 3]);
        for i in 0..D {
            stretch[(i, i)] = lame.mu * (1.0 + 1.0 / (stretches[i] * stretches[i]));
        }
        for (k, (i, j)) in pairs::<D>().enumerate() {
            let both = stretches[i] * stretches[j];
            let rest = pressure * volume / both;
            stretch[(i, j)] = rest;
            stretch[(j, i)] = rest;
            shear[k] = lame.mu * (1.0 + 1.0 / both) - rest;
            twist[k] = lame.mu * (1.0 - 1.0 / both) + rest;
        }
        Principal { stretch, shear, twist }
    }

    fn volume(&self, f: &Matrix<D>) -> f64 {
        dilation(f)
    }

    fn volume_slope(&self, f: &Matrix<D>) -> Matrix<D> {
        cofactor(f)
    }

    fn volumetric(&self, lame: Lame, theta: f64) -> [f64; 3] {
        if theta <= -1.0 {
            return [f64::INFINITY; 3];
        }
        let (log, j) = (theta.ln_1p(), 1.0 + theta);
        [0.5 * lame.lambda * log * log, lame.lambda * log / j, lame.lambda * (1.0 - log) / (j * j)]
    }
}

impl<const D: usize> Conserving<D> for NeoHookean {
    fn stress_between(&self, lame: Lame, ends: [&Matrix<D>; 2]) -> Matrix<D> {
        (Matrix::identity() - determinant_slope(ends) * log_slope(volumes(ends))) * lame.mu
    }

    fn volume_slope_between(&self, ends: [&Matrix<D>; 2]) -> Matrix<D> {
        determinant_slope(ends)
    }

    fn pressure_between(&self, lame: Lame, thetas: [f64; 2]) -> f64 {
        let logs: f64 = thetas.iter().map(|theta| theta.ln_1p()).sum();
        0.5 * lame.lambda * logs * log_slope(thetas.map(|theta| 1.0 + theta))
    }
}
