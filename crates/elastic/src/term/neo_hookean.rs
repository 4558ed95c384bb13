//! Neo-Hookean solids: rubber, which no force presses to nothing.
//!
//! ```text
//! Ψ = μ/2 (|F|² − D) − μ ln J + λ/2 (ln J)²,        J = det F
//! ```
//!
//! (J. Simo & K. Pister 1984; Bonet & Wood, "Nonlinear Continuum Mechanics for Finite Element Analysis", §6.4.3), without stress at
//! rest and Hooke's law for small strains; in 2D it is that of plane strain. The last part is that of the projected change of volume.
//! Below a volume of 0.3 the logarithm is continued ([`super::logarithm`]): what turns no element inside out there is
//! [`super::Crushed`]. Limit: stretched beyond `J = e` to all sides it yields more the more it is stretched.

use super::conserving::{Conserving, determinant_slope, volumes};
use super::crushed::CRUSHED;
use super::density::{Density, Lame, Principal, beyond_trace, cofactor, determinant, dilation};
use super::logarithm::{log_slope, logarithm};
use crate::linalg::pairs;
use meniscus_numerics::{Matrix, Vector};

/// The density.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NeoHookean;

/// `|j|` below which `j − ln (1 + j)` is summed, so that small strains are not lost in rounding: 14 terms make 1e-16 of the first.
const SMALL: f64 = 0.06;
const TERMS: i32 = 14;

/// `j − L(1 + j)`.
fn above_log(j: f64) -> f64 {
    if 1.0 + j < CRUSHED {
        return j - logarithm(1.0 + j)[0];
    }
    if j.abs() > SMALL {
        return j - j.ln_1p();
    }
    // j²/2 − j³/3 + j⁴/4 …
    j * j * (2..TERMS + 2).rev().fold(0.0, |sum, k| 1.0 / f64::from(k) - j * sum)
}

/// `L(1 + θ)`, small changes in full.
fn projected_log(theta: f64) -> f64 {
    if 1.0 + theta < CRUSHED { logarithm(1.0 + theta)[0] } else { theta.ln_1p() }
}

impl<const D: usize> Density<D> for NeoHookean {
    const PROJECTED: bool = true;

    fn energy(&self, lame: Lame, f: &Matrix<D>) -> f64 {
        // In `G = F − 1` and `j = J − 1`: `(|F|² − D)/2 − ln J = |G|²/2 + (j − ln (1 + j)) − (j − tr G)`.
        let g = f - Matrix::identity();
        let beyond = beyond_trace(&g);
        lame.mu * (0.5 * g.norm_squared() + above_log(g.trace() + beyond) - beyond)
    }

    fn stress(&self, lame: Lame, f: &Matrix<D>) -> Matrix<D> {
        f * lame.mu - cofactor(f) * (lame.mu * logarithm(determinant(f))[1])
    }

    fn principal(&self, lame: Lame, stretches: &Vector<D>, pressure: f64) -> Principal<D> {
        // Of the product `J` of stretches: that without two of them is the second derivative of `J`, that without one the first.
        let without = |i: usize, j: usize| -> f64 {
            (0..D).filter(|k| *k != i && *k != j).map(|k| stretches[k]).product()
        };
        let [_, slope, bend] = logarithm(stretches.product());
        let push = pressure - lame.mu * slope;
        let mut stretch = Matrix::from_fn(|i, j| -lame.mu * bend * without(i, i) * without(j, j));
        (0..D).for_each(|i| stretch[(i, i)] += lame.mu);
        let (mut shear, mut twist) = ([0.0; 3], [0.0; 3]);
        for (k, (i, j)) in pairs::<D>().enumerate() {
            let rest = push * without(i, j);
            stretch[(i, j)] += rest;
            stretch[(j, i)] += rest;
            shear[k] = lame.mu - rest;
            twist[k] = lame.mu + rest;
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
        let [_, slope, bend] = logarithm(1.0 + theta);
        let log = projected_log(theta);
        [0.5 * lame.lambda * log * log, lame.lambda * log * slope, lame.lambda * (slope * slope + log * bend)]
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
        let logs: f64 = thetas.iter().map(|theta| projected_log(*theta)).sum();
        0.5 * lame.lambda * logs * log_slope(thetas.map(|theta| 1.0 + theta))
    }
}
