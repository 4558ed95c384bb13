//! The logarithm of a change of volume that a law of material takes, continued where there is no volume.
//!
//! ```text
//! L(j) = ln j                                            j ≥ J₀
//!        ln J₀ + (j − J₀)/J₀ − (j − J₀)²/(2 J₀²)         below,
//! ```
//!
//! its second-order expansion about `J₀` = [`CRUSHED`]. A law is taken half-way between two times, and of changes of volume that are
//! projected within an element: both can be below zero where no element is turned inside out. What keeps elements upright is
//! [`super::Crushed`], which begins at `J₀`.

use super::crushed::CRUSHED;

/// `x` below which `ln (1 + x)/x` is summed: 1e-16 of it are left out.
const SMALL: f64 = 1e-4;

/// `L` and its first and second derivative.
pub fn logarithm(j: f64) -> [f64; 3] {
    if j >= CRUSHED {
        return [j.ln(), 1.0 / j, -1.0 / (j * j)];
    }
    let below = j / CRUSHED - 1.0;
    [CRUSHED.ln() + below - 0.5 * below * below, (1.0 - below) / CRUSHED, -1.0 / (CRUSHED * CRUSHED)]
}

/// `(L(b) − L(a))/(b − a)`.
pub fn log_slope([a, b]: [f64; 2]) -> f64 {
    let (low, high) = (a.min(b), a.max(b));
    // Of a parabola it is the slope half-way.
    let below = |a: f64, b: f64| logarithm((0.5 * (a + b)).min(CRUSHED))[1];
    if low >= CRUSHED {
        above(a, b)
    } else if high <= CRUSHED {
        below(low, high)
    } else {
        (above(CRUSHED, high) * (high - CRUSHED) + below(low, CRUSHED) * (CRUSHED - low)) / (high - low)
    }
}

/// `(ln b − ln a)/(b − a)` of positive numbers.
fn above(a: f64, b: f64) -> f64 {
    let x = (b - a) / a;
    let per = if x.abs() < SMALL { 1.0 - x * (0.5 - x * (1.0 / 3.0 - x * 0.25)) } else { x.ln_1p() / x };
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
            let [low, _, high] = [j - e, j, j + e].map(logarithm);
            let [_, slope, bend] = logarithm(j);
            assert!(((high[0] - low[0]) / (2.0 * e) - slope).abs() < 1e-7 * slope.abs().max(1.0));
            assert!(((high[1] - low[1]) / (2.0 * e) - bend).abs() < 1e-6 * bend.abs().max(1.0));
        }
    }

    #[test]
    fn the_mean_slope_times_the_change_is_the_change() {
        for (a, b) in
            [(0.5, 2.0), (1.0, 1.0 + 1e-9), (0.1, 0.2), (-0.4, 1.3), (1.3, -0.4), (0.29, 0.31), (-3.0, -1.0)]
        {
            let change = logarithm(b)[0] - logarithm(a)[0];
            assert!((log_slope([a, b]) * (b - a) - change).abs() < 1e-13 * (1.0 + change.abs()), "{a} {b}");
        }
    }
}
