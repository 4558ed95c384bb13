//! Weights of interpolation along one axis: cubic, quintic, and one-sided at kinks.
//!
//! Lagrange's polynomials through four and six points; essentially non-oscillatory (ENO) weights with subcell resolution (Min and Gibou
//! 2007, "A second order accurate level set method on non-graded adaptive Cartesian grids"; Harten 1989). Limit: of the kinks in a
//! stencil only one is resolved, that between the middle points.

use super::stencil::Stencil;

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
const KINK_TRANSITION_CELLS: f64 = 0.1;
/// Relative loss of slope across the middle cube at which a kink is certain.
const KINK_SLOPE_LOSS: f64 = 0.05;

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
pub(super) fn quintic_weights<const D: usize>(t: &[f64; D]) -> ([[f64; 6]; D], [[f64; 6]; D]) {
    // A lane for each axis. Products of the distances to the points before and after each one, with derivatives.
    let (mut before, mut after) = ([[[1.0; D], [0.0; D]]; 6], [[[1.0; D], [0.0; D]]; 6]);
    for i in 1..6 {
        for a in 0..D {
            let away = |i: usize| t[a] + 2.0 - i as f64;
            let [p, dp] = before[i - 1].map(|v| v[a]);
            before[i][0][a] = p * away(i - 1);
            before[i][1][a] = dp * away(i - 1) + p;
            let [q, dq] = after[6 - i].map(|v| v[a]);
            after[5 - i][0][a] = q * away(6 - i);
            after[5 - i][1][a] = dq * away(6 - i) + q;
        }
    }
    let (mut weights, mut slopes) = ([[0.0; D]; 6], [[0.0; D]; 6]);
    for i in 0..6 {
        for a in 0..D {
            let [[p, dp], [q, dq]] = [before[i], after[i]].map(|both| both.map(|v| v[a]));
            weights[i][a] = QUINTIC_SCALE[i] * p * q;
            slopes[i][a] = QUINTIC_SCALE[i] * (dp * q + p * dq);
        }
    }
    let of = |all: [[f64; D]; 6]| std::array::from_fn(|a| all.map(|lanes| lanes[a]));
    (of(weights), of(slopes))
}

/// The largest third difference of a stencil.
#[inline(always)]
pub(super) fn max_third_difference<const D: usize>(rows: &Stencil) -> f64 {
    let mut worst = [0.0f64; 4];
    let larger = |a: f64, b: f64| if b > a { b } else { a };
    let count = 1 << (2 * (D - 1));
    for row in &rows[..count] {
        worst[0] = larger(worst[0], (3.0 * (row[1] - row[2]) + row[3] - row[0]).abs());
    }
    for a in 1..D {
        let step = 1 << (2 * (a - 1));
        for first in (0..count).filter(|r| r / step % 4 == 0) {
            let line: [&[f64; 4]; 4] = std::array::from_fn(|k| &rows[first + k * step]);
            for i in 0..4 {
                let third = 3.0 * (line[1][i] - line[2][i]) + line[3][i] - line[0][i];
                worst[i] = larger(worst[i], third.abs());
            }
        }
    }
    larger(larger(worst[0], worst[1]), larger(worst[2], worst[3]))
}
