//! What keeps elements upright: an energy without bound as the volume goes to zero.
//!
//! `Ψ = κ β(J/J₀)` below the volume `J₀` over that at rest, with `β(t) = −(1 − t)² ln t` as for contacts (`meniscus_contact`). It is
//! taken where a step ends, not half-way as the law of the material ([`crate::Incremental`]): so no step that is taken turns an element
//! inside out. It is that of the parts of quadratic simplices, which nothing else keeps upright, and of the points of their law.

use super::density::{Density, Lame, Principal, cofactor, determinant};
use crate::linalg::pairs;
use meniscus_numerics::{Matrix, Vector};

/// Volume over that at rest, `J₀`, below which elements resist besides their law: milder strains are the law's alone.
pub const CRUSHED: f64 = 0.3;

/// The energy; `κ` is the first Lamé parameter.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Crushed;

/// `Ψ/κ` and its first and second derivative by `J`.
fn barrier(j: f64) -> [f64; 3] {
    let (t, rest) = (j / CRUSHED, 1.0 - j / CRUSHED);
    if rest <= 0.0 {
        return [0.0; 3];
    }
    if t <= 0.0 {
        return [f64::INFINITY; 3];
    }
    let log = t.ln();
    let slope = 2.0 * rest * log - rest * rest / t;
    let bend = rest * (4.0 + rest / t) / t - 2.0 * log;
    [-rest * rest * log, slope / CRUSHED, bend / (CRUSHED * CRUSHED)]
}

impl<const D: usize> Density<D> for Crushed {
    fn is_slack(&self, f: &Matrix<D>) -> bool {
        determinant(f) >= CRUSHED
    }

    fn energy(&self, lame: Lame, f: &Matrix<D>) -> f64 {
        lame.lambda * barrier(determinant(f))[0]
    }

    fn stress(&self, lame: Lame, f: &Matrix<D>) -> Matrix<D> {
        let [_, slope, _] = barrier(determinant(f));
        if slope == 0.0 { Matrix::zeros() } else { cofactor(f) * (lame.lambda * slope) }
    }

    fn principal(&self, lame: Lame, stretches: &Vector<D>, _: f64) -> Principal<D> {
        let [_, slope, bend] = barrier(stretches.product()).map(|b| b * lame.lambda);
        let but =
            |i: usize, j: usize| (0..D).filter(|k| *k != i && *k != j).map(|k| stretches[k]).product::<f64>();
        let mut stretch = Matrix::from_fn(|i, j| bend * but(i, i) * but(j, j));
        let (mut shear, mut twist) = ([0.0; 3], [0.0; 3]);
        for (k, (i, j)) in pairs::<D>().enumerate() {
            let rest = slope * but(i, j);
            stretch[(i, j)] += rest;
            stretch[(j, i)] += rest;
            (shear[k], twist[k]) = (-rest, rest);
        }
        Principal { stretch, shear, twist }
    }
}
