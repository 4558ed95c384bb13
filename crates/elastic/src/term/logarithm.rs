//! Logarithm of the volume ratio, continued to ratios below zero.
//!
//! ```text
//! L(j) = ln j                                            j ≥ J₀
//!        ln J₀ + (j − J₀)/J₀ − (j − J₀)²/(2 J₀²)         below,
//! ```
//!
//! its second-order expansion about `J₀` = [`CRUSHED_VOLUME_RATIO`]. Ratios at the midpoint of a step and projected ratios can be below
//! zero where no element is inverted. [`super::InversionBarrier`], which acts below `J₀`, prevents inversion.

use super::inversion_barrier::CRUSHED_VOLUME_RATIO;

/// `x` below which `ln (1 + x)/x` is evaluated as a series, with a relative error of 1e-16.
const SERIES_THRESHOLD: f64 = 1e-4;

/// `L` and its first and second derivatives.
pub fn extended_log(j: f64) -> [f64; 3] {
    if j >= CRUSHED_VOLUME_RATIO {
        return [j.ln(), 1.0 / j, -1.0 / (j * j)];
    }
    let below = j / CRUSHED_VOLUME_RATIO - 1.0;
    [
        CRUSHED_VOLUME_RATIO.ln() + below - 0.5 * below * below,
        (1.0 - below) / CRUSHED_VOLUME_RATIO,
        -1.0 / (CRUSHED_VOLUME_RATIO * CRUSHED_VOLUME_RATIO),
    ]
}

/// `(L(b) − L(a))/(b − a)`.
pub fn log_divided_difference([a, b]: [f64; 2]) -> f64 {
    let (low, high) = (a.min(b), a.max(b));
    // The divided difference of a parabola is its slope at the midpoint.
    let below = |a: f64, b: f64| extended_log((0.5 * (a + b)).min(CRUSHED_VOLUME_RATIO))[1];
    if low >= CRUSHED_VOLUME_RATIO {
        plain_log_divided_difference(a, b)
    } else if high <= CRUSHED_VOLUME_RATIO {
        below(low, high)
    } else {
        (plain_log_divided_difference(CRUSHED_VOLUME_RATIO, high) * (high - CRUSHED_VOLUME_RATIO)
            + below(low, CRUSHED_VOLUME_RATIO) * (CRUSHED_VOLUME_RATIO - low))
            / (high - low)
    }
}

/// `(ln b − ln a)/(b − a)` of positive numbers.
fn plain_log_divided_difference(a: f64, b: f64) -> f64 {
    let x = (b - a) / a;
    let per =
        if x.abs() < SERIES_THRESHOLD { 1.0 - x * (0.5 - x * (1.0 / 3.0 - x * 0.25)) } else { x.ln_1p() / x };
    per / a
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn derivatives_are_those_of_the_values() {
        for j in [-2.0, -0.3, 0.0, 0.1, 0.299, 0.31, 0.8, 1.0, 3.0] {
            let e = 1e-5;
            let [low, _, high] = [j - e, j, j + e].map(extended_log);
            let [_, slope, bend] = extended_log(j);
            assert!(((high[0] - low[0]) / (2.0 * e) - slope).abs() < 1e-7 * slope.abs().max(1.0));
            assert!(((high[1] - low[1]) / (2.0 * e) - bend).abs() < 1e-6 * bend.abs().max(1.0));
        }
    }

    #[test]
    fn the_mean_slope_times_the_change_is_the_change() {
        for (a, b) in
            [(0.5, 2.0), (1.0, 1.0 + 1e-9), (0.1, 0.2), (-0.4, 1.3), (1.3, -0.4), (0.29, 0.31), (-3.0, -1.0)]
        {
            let change = extended_log(b)[0] - extended_log(a)[0];
            assert!(
                (log_divided_difference([a, b]) * (b - a) - change).abs() < 1e-13 * (1.0 + change.abs()),
                "{a} {b}"
            );
        }
    }
}
