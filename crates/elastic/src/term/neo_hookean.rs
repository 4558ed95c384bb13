//! Neo-Hookean elasticity for rubber-like solids.
//!
//! ```text
//! Ψ = μ/2 (|F|² − D) − μ ln J + λ/2 (ln J)²,        J = det F
//! ```
//!
//! (J. Simo & K. Pister 1984; Bonet & Wood, "Nonlinear Continuum Mechanics for Finite Element Analysis", §6.4.3). It has no stress
//! at rest and Hooke's law for small strains; in 2D it is plane strain. The last part is evaluated for the projected change of
//! volume. Below a volume ratio of 0.3 the logarithm is continued ([`super::logarithm`]), and [`super::InversionBarrier`] prevents
//! inversion. Limit: in expansion beyond `J = e` the volumetric part softens (`U'' < 0`).

use super::discrete_gradient::{DiscreteGradientDensity, determinant_discrete_gradient, volume_ratios};
use super::energy_density::{
    EnergyDensity, Lame, PrincipalHessian, cofactor, determinant, dilation, nonlinear_dilation,
};
use super::inversion_barrier::CRUSHED_VOLUME_RATIO;
use super::logarithm::{extended_log, log_divided_difference};
use crate::linalg::axis_pairs;
use meniscus_numerics::{Matrix, Vector};

/// Neo-Hookean energy density.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NeoHookean;

/// `|j|` below which `j − ln (1 + j)` is evaluated as a series, so that rounding does not lose small strains: 14 terms give a
/// relative error of 1e-16.
const SERIES_THRESHOLD: f64 = 0.06;
const SERIES_TERMS: i32 = 14;

/// `j − L(1 + j)`.
fn minus_log_one_plus(j: f64) -> f64 {
    if 1.0 + j < CRUSHED_VOLUME_RATIO {
        return j - extended_log(1.0 + j)[0];
    }
    if j.abs() > SERIES_THRESHOLD {
        return j - j.ln_1p();
    }
    // j²/2 − j³/3 + j⁴/4 …
    j * j * (2..SERIES_TERMS + 2).rev().fold(0.0, |sum, k| 1.0 / f64::from(k) - j * sum)
}

/// `L(1 + θ)`, with small changes in full precision.
fn log_one_plus(theta: f64) -> f64 {
    if 1.0 + theta < CRUSHED_VOLUME_RATIO { extended_log(1.0 + theta)[0] } else { theta.ln_1p() }
}

impl<const D: usize> EnergyDensity<D> for NeoHookean {
    const HAS_VOLUMETRIC: bool = true;

    fn energy(&self, lame: Lame, f: &Matrix<D>) -> f64 {
        // In `G = F − 1` and `j = J − 1`: `(|F|² − D)/2 − ln J = |G|²/2 + (j − ln (1 + j)) − (j − tr G)`.
        let g = f - Matrix::identity();
        let beyond = nonlinear_dilation(&g);
        lame.mu * (0.5 * g.norm_squared() + minus_log_one_plus(g.trace() + beyond) - beyond)
    }

    fn stress(&self, lame: Lame, f: &Matrix<D>) -> Matrix<D> {
        f * lame.mu - cofactor(f) * (lame.mu * extended_log(determinant(f))[1])
    }

    fn principal_hessian(&self, lame: Lame, stretches: &Vector<D>, pressure: f64) -> PrincipalHessian<D> {
        // Products of the stretches without one and without two factors: first and second derivatives of `J`.
        let without = |i: usize, j: usize| -> f64 {
            (0..D).filter(|k| *k != i && *k != j).map(|k| stretches[k]).product()
        };
        let [_, slope, bend] = extended_log(stretches.product());
        let push = pressure - lame.mu * slope;
        let mut stretch = Matrix::from_fn(|i, j| -lame.mu * bend * without(i, i) * without(j, j));
        (0..D).for_each(|i| stretch[(i, i)] += lame.mu);
        let (mut shear, mut twist) = ([0.0; 3], [0.0; 3]);
        for (k, (i, j)) in axis_pairs::<D>().enumerate() {
            let rest = push * without(i, j);
            stretch[(i, j)] += rest;
            stretch[(j, i)] += rest;
            shear[k] = lame.mu - rest;
            twist[k] = lame.mu + rest;
        }
        PrincipalHessian { stretch, shear, twist }
    }

    fn volume_change(&self, f: &Matrix<D>) -> f64 {
        dilation(f)
    }

    fn volume_change_gradient(&self, f: &Matrix<D>) -> Matrix<D> {
        cofactor(f)
    }

    fn volumetric_energy(&self, lame: Lame, theta: f64) -> [f64; 3] {
        let [_, slope, bend] = extended_log(1.0 + theta);
        let log = log_one_plus(theta);
        [0.5 * lame.lambda * log * log, lame.lambda * log * slope, lame.lambda * (slope * slope + log * bend)]
    }
}

impl<const D: usize> DiscreteGradientDensity<D> for NeoHookean {
    fn stress_between(&self, lame: Lame, ends: [&Matrix<D>; 2]) -> Matrix<D> {
        (Matrix::identity()
            - determinant_discrete_gradient(ends) * log_divided_difference(volume_ratios(ends)))
            * lame.mu
    }

    fn volume_discrete_gradient(&self, ends: [&Matrix<D>; 2]) -> Matrix<D> {
        determinant_discrete_gradient(ends)
    }

    fn pressure_between(&self, lame: Lame, thetas: [f64; 2]) -> f64 {
        let logs: f64 = thetas.iter().map(|theta| log_one_plus(*theta)).sum();
        0.5 * lame.lambda * logs * log_divided_difference(thetas.map(|theta| 1.0 + theta))
    }
}
