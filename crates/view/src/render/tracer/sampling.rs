//! Deterministic sample patterns, the same on every machine and for any number of threads.

use std::f64::consts::TAU;

use crate::folder::V3;

/// Hash of a 32-bit value.
pub(crate) fn hash(x: u32) -> u32 {
    let mut h = x.wrapping_mul(0x9e37_79b9) ^ 0x85eb_ca6b;
    h = (h ^ (h >> 16)).wrapping_mul(0x7feb_352d);
    h = (h ^ (h >> 15)).wrapping_mul(0x846c_a68b);
    h ^ (h >> 16)
}

/// Point `i` of the R2 low-discrepancy sequence in the unit square, shifted by `shift`.
pub(crate) fn r2(i: u32, shift: [f64; 2]) -> [f64; 2] {
    let n = f64::from(i) + 0.5;
    [(n * 0.754_877_666_246_693 + shift[0]).fract(), (n * 0.569_840_290_998_053 + shift[1]).fract()]
}

/// Position of sample `i` of `n` in a pixel. Samples beyond `n` fill the gaps.
pub(crate) fn pixel_sample(i: u32, n: u32) -> [f64; 2] {
    const ROTATED: [[f64; 2]; 4] = [[0.375, 0.125], [0.875, 0.375], [0.625, 0.875], [0.125, 0.625]];
    match n {
        0 | 1 => [0.5, 0.5],
        4 if i < 4 => ROTATED[i as usize],
        _ => r2(i, [0.0, 0.0]),
    }
}

/// Shift of the sample pattern of a pixel, chosen so that neighbours differ strongly.
pub(crate) fn pixel_shift(x: u32, y: u32) -> [f64; 2] {
    let (x, y) = (f64::from(x), f64::from(y));
    let a = (52.982_918_9 * (0.067_110_56 * x + 0.005_837_15 * y).fract()).fract();
    let b = (52.982_918_9 * (0.005_837_15 * (x + 37.0) + 0.067_110_56 * (y + 17.0)).fract()).fract();
    [a, b]
}

/// Two vectors that complete the unit vector `n` to a right-handed basis.
pub(crate) fn orthonormal_basis(n: &V3) -> (V3, V3) {
    let sign = 1f64.copysign(n.z);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    (V3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x), V3::new(b, sign + n.y * n.y * a, -n.y))
}

/// A direction around `n` with cosine-weighted density.
pub(crate) fn sample_cosine_hemisphere(n: &V3, u: [f64; 2]) -> V3 {
    let (a, b) = orthonormal_basis(n);
    let (r, angle) = (u[0].sqrt(), TAU * u[1]);
    (a * (r * angle.cos()) + b * (r * angle.sin()) + n * (1.0 - u[0]).max(0.0).sqrt()).normalize()
}

/// A direction in a cone around `n` whose half angle has the tangent `spread`.
pub(crate) fn sample_cone(n: &V3, spread: f64, u: [f64; 2]) -> V3 {
    let (a, b) = orthonormal_basis(n);
    let (r, angle) = (spread * u[0].sqrt(), TAU * u[1]);
    (n + a * (r * angle.cos()) + b * (r * angle.sin())).normalize()
}

/// Smooth step: 0 below `a`, 1 above `b`, cubic between.
pub(crate) fn smoothstep(a: f64, b: f64, x: f64) -> f64 {
    let t = ((x - a) / (b - a)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
