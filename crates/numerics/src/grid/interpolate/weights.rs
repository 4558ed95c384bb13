//! Weights of interpolation along one axis: cubic, quintic, and one-sided at kinks.
//!
//! Lagrange's polynomials through four and six points; essentially non-oscillatory (ENO) weights with subcell resolution (Min and Gibou
//! 2007, "A second order accurate level set method on non-graded adaptive Cartesian grids"; Harten 1989). Limit: of the kinks in a
//! stencil only one is resolved, that between the middle points.

use super::stencil::{AxisWeights, Stencil, Window};
use crate::lanes::{Compiled, Lanes};

/// Weights of the cubic through the points −1, 0, 1, 2 at `t`.
pub(super) fn cubic_weights(t: f64) -> [f64; 4] {
    let (a, b, c) = (t + 1.0, t - 1.0, t - 2.0);
    [-t * b * c / 6.0, a * b * c / 2.0, -a * t * c / 2.0, a * t * b / 6.0]
}

/// Derivatives of [`cubic_weights`].
pub(super) fn cubic_weight_derivatives(t: f64) -> [f64; 4] {
    let s = t * t;
    [
        (-3.0 * s + 6.0 * t - 2.0) / 6.0,
        (3.0 * s - 4.0 * t - 1.0) / 2.0,
        (-3.0 * s + 2.0 * t + 2.0) / 2.0,
        (3.0 * s - 1.0) / 6.0,
    ]
}

/// Third difference, in cells, up to which a distance counts as smooth: a ball with a radius of seven cells has no larger one.
pub(super) const MAX_SMOOTH_THIRD_DIFFERENCE_CELLS: f64 = 0.02;
/// Excess third difference, in cells, at which the cubic and the one-sided form have equal weights.
pub(super) const KINK_TRANSITION_CELLS: f64 = 0.1;
/// Relative loss of slope across the middle cube at which a kink is certain.
pub(super) const KINK_SLOPE_LOSS: f64 = 0.05;

/// Weights of four values (in cells) at `t`, and their derivatives: linear interpolation plus the contribution of each second difference.
///
/// Where the second differences agree, the sum is the cubic. Elsewhere only the smaller one is used, because the larger
/// one crosses the kink (Min and Gibou 2007). `kink_indicator` is the certainty that the kink lies between the middle
/// points. There both sides are extended linearly until they meet (Harten's subcell resolution): the one that deviates
/// less from the chord is used.
/// Each value has a lane for each of `L` rows.
#[inline(always)]
pub(super) fn eno_cubic_weights<const L: usize>(
    v: &[[f64; L]; 4],
    t: f64,
    kink_indicator: f64,
) -> ([[f64; L]; 4], [[f64; L]; 4]) {
    let (mut weights, mut rises) = ([[0.0; L]; 4], [[0.0; L]; 4]);
    let chords = [[1.0 - t, t], [-1.0, 1.0]];
    let (q, dq) = (0.5 * t * (t - 1.0), t - 0.5);
    for i in 0..L {
        let (a, b) = (v[0][i] - 2.0 * v[1][i] + v[2][i], v[1][i] - 2.0 * v[2][i] + v[3][i]);
        let excess = ((a - b).abs() - MAX_SMOOTH_THIRD_DIFFERENCE_CELLS).max(0.0) / KINK_TRANSITION_CELLS;
        let square = excess * excess;
        let smooth = 1.0 / (1.0 + square * square) / 3.0;
        let (left, right) = (smooth * (2.0 - t), smooth * (1.0 + t));
        let (l, r) = ([q * left, dq * left - q * smooth], [q * right, dq * right + q * smooth]);
        let rest = 1.0 - 3.0 * smooth;
        let kink_indicator = kink_indicator * rest;
        let (left, right) = if a.abs() < b.abs() { (rest, 0.0) } else { (0.0, rest) };
        let near = t * a.abs() < (1.0 - t) * b.abs();
        let (low, high) = if near { ([-t, -1.0], [0.0; 2]) } else { ([0.0; 2], [t - 1.0, 1.0]) };
        let bent = |side: f64, share: f64, part: f64, line: f64| {
            let side = side + part * share;
            side + kink_indicator * (line - side)
        };
        let same = a * b > 0.0;
        let pick = |flat: f64, bent: f64| if same { bent } else { flat };
        let l = [pick(l[0], bent(l[0], left, q, low[0])), pick(l[1], bent(l[1], left, dq, low[1]))];
        let r = [pick(r[0], bent(r[0], right, q, high[0])), pick(r[1], bent(r[1], right, dq, high[1]))];
        for (k, to) in [&mut weights, &mut rises].into_iter().enumerate() {
            to[0][i] = l[k];
            to[1][i] = chords[k][0] - 2.0 * l[k] + r[k];
            to[2][i] = chords[k][1] + l[k] - 2.0 * r[k];
            to[3][i] = r[k];
        }
    }
    (weights, rises)
}

/// Certainty, 0 to 1, that a kink passes through the middle cube of a stencil: the differences there see a smaller slope
/// than those in the cubes on both sides.
pub(super) fn kink_indicator<const D: usize>(rows: &Stencil) -> f64 {
    // Squared slope in a cube: the middle one for `shift` 1, else its neighbour along `axis`.
    let square = |axis: usize, shift: usize| {
        let mut rise = [0.0; D];
        for corner in 0..1 << D {
            let place = |b: usize| (corner >> b & 1) + if b == axis { shift } else { 1 };
            let row = (1..D).map(|b| place(b) << (2 * (b - 1))).sum::<usize>();
            let value = rows[row][place(0)];
            (0..D).for_each(|a| rise[a] += if corner >> a & 1 == 1 { value } else { -value });
        }
        rise.iter().map(|r| r * r).sum::<f64>()
    };
    let around = (0..D).map(|a| square(a, 0).min(square(a, 2))).fold(0.0, f64::max);
    let part = (square(0, 1) / around.max(1e-300)).sqrt();
    ((1.0 - part) / KINK_SLOPE_LOSS).clamp(0.0, 1.0)
}

/// Factors of Lagrange's polynomials through the points −2 ... 3.
pub(super) const QUINTIC_SCALE: [f64; 6] =
    [-1.0 / 120.0, 1.0 / 24.0, -1.0 / 12.0, 1.0 / 12.0, -1.0 / 24.0, 1.0 / 120.0];

/// Weights of the quintic through the points −2 ... 3 at `t`, and their derivatives, along each axis.
#[inline(always)]
pub(super) fn quintic_weights<const D: usize>(t: &[f64; D]) -> [AxisWeights<6>; 2] {
    let t = Lanes::load(Compiled, t, 0);
    let away: [Lanes<Compiled>; 6] =
        std::array::from_fn(|i| t + Lanes::splat(Compiled, 2.0) - Lanes::splat(Compiled, i as f64));
    // Products of the distances to the points before and after each one, with derivatives.
    let (mut before, mut after) = (
        [[Lanes::splat(Compiled, 1.0), Lanes::splat(Compiled, 0.0)]; 6],
        [[Lanes::splat(Compiled, 1.0), Lanes::splat(Compiled, 0.0)]; 6],
    );
    for i in 1..6 {
        let [p, dp] = before[i - 1];
        before[i] = [p * away[i - 1], dp * away[i - 1] + p];
        let [q, dq] = after[6 - i];
        after[5 - i] = [q * away[6 - i], dq * away[6 - i] + q];
    }
    let weight = |i: usize| before[i][0] * QUINTIC_SCALE[i] * after[i][0];
    let slope = |i: usize| (before[i][1] * after[i][0] + before[i][0] * after[i][1]) * QUINTIC_SCALE[i];
    [std::array::from_fn(|i| weight(i).to_array()), std::array::from_fn(|i| slope(i).to_array())]
}

/// The largest third difference of the first four points of a window along each axis.
#[inline(always)]
pub(super) fn max_third_difference<const D: usize>(window: &Window<'_>) -> f64 {
    let third = |a: Lanes<Compiled>, b: Lanes<Compiled>, c: Lanes<Compiled>, d: Lanes<Compiled>| {
        ((b - c) * 3.0 + d - a).abs()
    };
    let row = |j: usize, k: usize| window.row::<4>(j, k);
    let of = |j: usize, k: usize| Lanes::load(Compiled, row(j, k), 0);
    let (mut worst, mut along) = (Lanes::splat(Compiled, 0.0), [0.0f64; 4]);
    for k in 0..if D == 3 { 4 } else { 1 } {
        worst = third(of(0, k), of(1, k), of(2, k), of(3, k)).max(worst);
        for j in 0..4 {
            let [a, b, c, d] = *row(j, k);
            let third = (3.0 * (b - c) + d - a).abs();
            along[j] = if third > along[j] { third } else { along[j] };
        }
    }
    for j in 0..if D == 3 { 4 } else { 0 } {
        worst = third(of(j, 0), of(j, 1), of(j, 2), of(j, 3)).max(worst);
    }
    let larger = |a: f64, b: f64| if b > a { b } else { a };
    worst.to_array()[..4].iter().chain(&along).fold(0.0, |a, b| larger(a, *b))
}
