//! Weights of interpolation and weighted sums of stencils, in each lane.
//!
//! The operations are those of [`super::weights`] and [`super::stencil`], in the same order. All lanes read the same rows, shifted by a
//! value each.

use super::stencil::Window;
use super::weights::{
    KINK_SLOPE_LOSS, KINK_TRANSITION_CELLS, MAX_SMOOTH_THIRD_DIFFERENCE_CELLS, QUINTIC_SCALE,
};
use crate::each_lanes;
use crate::lanes::{Instructions, LANES, Lanes};

/// Length of the row that the stencils of four points along an axis read in all lanes.
pub(super) const CUBIC_ROW: usize = LANES + 3;
/// The same for six points.
pub(super) const QUINTIC_ROW: usize = LANES + 5;

/// [`super::weights::cubic_weights`] in each lane.
#[inline(always)]
pub(super) fn cubic_weight_lanes<I: Instructions>(t: Lanes<I>) -> [Lanes<I>; 4] {
    let with = t.instructions();
    let (a, b) = (t - Lanes::splat(with, -1.0), t - Lanes::splat(with, 1.0));
    let c = t - Lanes::splat(with, 2.0);
    [t * b * c / -6.0, a * b * c * 0.5, a * t * c * -0.5, a * t * b / 6.0]
}

/// [`super::weights::quintic_weights`] in each lane.
#[inline(always)]
pub(super) fn quintic_weight_lanes<I: Instructions>(t: Lanes<I>) -> [Lanes<I>; 6] {
    let with = t.instructions();
    let away: [Lanes<I>; 6] =
        each_lanes!(with, |i| t + Lanes::splat(with, 2.0) - Lanes::splat(with, i as f64));
    let (mut before, mut after) = ([Lanes::splat(with, 1.0); 6], [Lanes::splat(with, 1.0); 6]);
    for i in 1..6 {
        before[i] = before[i - 1] * away[i - 1];
        after[5 - i] = after[6 - i] * away[6 - i];
    }
    each_lanes!(with, |i| before[i] * QUINTIC_SCALE[i] * after[i])
}

/// [`super::stencil::contract_within_range`] in each lane, of rows shifted by a value each.
#[inline(always)]
pub(super) fn contract_lanes_within_range<I: Instructions, const D: usize>(
    window: &Window<'_>,
    weights: &[&[Lanes<I>; 4]; D],
) -> Lanes<I> {
    let with = weights[0][0].instructions();
    let (mut low, mut high) = (Lanes::splat(with, f64::INFINITY), Lanes::splat(with, f64::NEG_INFINITY));
    let mut sums = [Lanes::splat(with, 0.0); 4];
    for row in 0..1usize << (2 * (D - 1)) {
        let own = weights[1][row & 3];
        let weight = if D == 3 { own * weights[2][row >> 2] } else { own };
        let values = window.row::<CUBIC_ROW>(row & 3, row >> 2);
        for i in 0..4 {
            let value = Lanes::load(with, values, i);
            low = value.min(low);
            high = value.max(high);
            sums[i] = sums[i] + weight * value;
        }
    }
    let terms: [Lanes<I>; 4] = each_lanes!(with, |i| sums[i] * weights[0][i]);
    high.min(low.max((terms[0] + terms[1]) + (terms[2] + terms[3])))
}

/// [`super::stencil::contract_rows`] in each lane, of rows shifted by a value each.
#[inline(always)]
pub(super) fn contract_quintic_lanes<I: Instructions, const D: usize>(
    window: &Window<'_>,
    weights: &[[Lanes<I>; 6]; D],
) -> Lanes<I> {
    let with = weights[0][0].instructions();
    let mut values = [Lanes::splat(with, 0.0); 6];
    for k in 0..6 {
        let mut sums = [Lanes::splat(with, 0.0); 6];
        for j in 0..6usize.pow(D as u32 - 2) {
            let row = window.row::<QUINTIC_ROW>(if D == 3 { j } else { k }, if D == 3 { k } else { 0 });
            for i in 0..6 {
                let value = Lanes::load(with, row, i);
                sums[i] = sums[i] + if D == 3 { weights[1][j] * value } else { value };
            }
        }
        for i in 0..6 {
            values[i] = values[i] + weights[D - 1][k] * sums[i];
        }
    }
    let mut sum = weights[0][0] * values[0];
    for i in 1..6 {
        sum = sum + weights[0][i] * values[i];
    }
    sum
}

/// [`super::weights::max_third_difference`] of the four middle points along each axis in each lane, of rows shifted by a value each.
#[inline(always)]
pub(super) fn third_difference_lanes<I: Instructions, const D: usize>(
    with: I,
    window: &Window<'_>,
) -> Lanes<I> {
    let mut worst = Lanes::splat(with, 0.0);
    for k in if D == 3 { 1..5 } else { 0..1 } {
        let rows: [_; 4] = std::array::from_fn(|j| window.row::<QUINTIC_ROW>(j + 1, k));
        for row in rows {
            worst = larger_third(worst, each_lanes!(with, |i| Lanes::load(with, row, i + 1)));
        }
        worst = larger_third_across(worst, rows);
    }
    if D == 3 {
        for j in 1..5 {
            let rows = std::array::from_fn(|k| window.row::<QUINTIC_ROW>(j, k + 1));
            worst = larger_third_across(worst, rows);
        }
    }
    worst
}

/// The larger of `worst` and the third difference of four values.
#[inline(always)]
pub(super) fn larger_third<I: Instructions>(worst: Lanes<I>, values: [Lanes<I>; 4]) -> Lanes<I> {
    let third = (values[1] - values[2]) * 3.0 + values[3] - values[0];
    third.abs().max(worst)
}

/// The same for four rows, at their four middle places.
#[inline(always)]
pub(super) fn larger_third_across<I: Instructions>(
    worst: Lanes<I>,
    rows: [&[f64; QUINTIC_ROW]; 4],
) -> Lanes<I> {
    let with = worst.instructions();
    let mut worst = worst;
    for i in 1..5 {
        worst = larger_third(worst, each_lanes!(with, |k| Lanes::load(with, rows[k], i)));
    }
    worst
}

/// The value at `t` of four values, times `scale` in cells, with the weights of [`super::weights::eno_cubic_weights`].
#[inline(always)]
pub(super) fn eno_reduced<I: Instructions>(
    points: [Lanes<I>; 4],
    t: Lanes<I>,
    kink: Lanes<I>,
    scale: Lanes<I>,
) -> Lanes<I> {
    let with = t.instructions();
    let weights = eno_cubic_weight_lanes(each_lanes!(with, |k| points[k] * scale), t, kink);
    let terms: [Lanes<I>; 4] = each_lanes!(with, |k| weights[k] * points[k]);
    (terms[0] + terms[1]) + (terms[2] + terms[3])
}

/// The weights of [`super::weights::eno_cubic_weights`] in each lane.
#[inline(always)]
pub(super) fn eno_cubic_weight_lanes<I: Instructions>(
    v: [Lanes<I>; 4],
    t: Lanes<I>,
    kink: Lanes<I>,
) -> [Lanes<I>; 4] {
    let with = t.instructions();
    let (zero, one) = (Lanes::splat(with, 0.0), Lanes::splat(with, 1.0));
    let (a, b) = (v[0] - v[1] * 2.0 + v[2], v[1] - v[2] * 2.0 + v[3]);
    let excess = ((a - b).abs() - Lanes::splat(with, MAX_SMOOTH_THIRD_DIFFERENCE_CELLS)).max(zero)
        / KINK_TRANSITION_CELLS;
    let square = excess * excess;
    let smooth = one / (one + square * square) / 3.0;
    let (left, right) = (smooth * (Lanes::splat(with, 2.0) - t), smooth * (one + t));
    let q = t * 0.5 * (t - one);
    let rest = one - smooth * 3.0;
    let kink = kink * rest;
    let is_left = a.abs().less_than(b.abs());
    let is_near = (t * a.abs()).less_than((one - t) * b.abs());
    let same = zero.less_than(a * b);
    let bent_left = q * left + q * is_left.select(rest, zero);
    let bent_left = bent_left + kink * (is_near.select(zero - t, zero) - bent_left);
    let bent_right = q * right + q * is_left.select(zero, rest);
    let bent_right = bent_right + kink * (is_near.select(zero, t - one) - bent_right);
    let (l, r) = (same.select(bent_left, q * left), same.select(bent_right, q * right));
    [l, one - t - l * 2.0 + r, t + l - r * 2.0, r]
}

/// [`super::weights::kink_indicator`] in each lane, of rows shifted by a value each.
#[inline(always)]
pub(super) fn kink_indicator_lanes<I: Instructions, const D: usize>(
    with: I,
    window: &Window<'_>,
) -> Lanes<I> {
    let (zero, one) = (Lanes::splat(with, 0.0), Lanes::splat(with, 1.0));
    let mut around = zero;
    for a in 0..D {
        let sides: [Lanes<I>; 2] = each_lanes!(with, |side| squared_rise::<I, D>(with, window, a, 2 * side));
        around = sides[0].min(sides[1]).max(around);
    }
    let middle = squared_rise::<I, D>(with, window, 0, 1);
    let part = (middle / around.max(Lanes::splat(with, 1e-300))).sqrt();
    one.min(zero.max((one - part) / KINK_SLOPE_LOSS))
}

/// Squared slope in a cube: the middle one for `shift` 1, else its neighbour along `axis`.
#[inline(always)]
pub(super) fn squared_rise<I: Instructions, const D: usize>(
    with: I,
    window: &Window<'_>,
    axis: usize,
    shift: usize,
) -> Lanes<I> {
    let mut rise = [Lanes::splat(with, 0.0); D];
    for corner in 0..1 << D {
        let place = |b: usize| (corner >> b & 1) + if b == axis { shift } else { 1 };
        let row = window.row::<CUBIC_ROW>(place(1), if D == 3 { place(2) } else { 0 });
        let value = Lanes::load(with, row, place(0));
        for (a, rise) in rise.iter_mut().enumerate() {
            *rise = if corner >> a & 1 == 1 { *rise + value } else { *rise - value };
        }
    }
    let mut sum = Lanes::splat(with, 0.0);
    for rise in rise {
        sum = sum + rise * rise;
    }
    sum
}
