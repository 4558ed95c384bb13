//! The values around a point, and their sums with products of weights along the axes.

use crate::Vector;

/// The values around a point, four along each axis, the first axis varying fastest.
pub(super) type Stencil = [[f64; 4]; 16];

/// Four rows of four values, one lane each.
pub(super) fn transposed(rows: &[[f64; 4]]) -> [[f64; 4]; 4] {
    std::array::from_fn(|point| std::array::from_fn(|lane| rows[lane][point]))
}

/// Sum of the products of four weights with four values, lane by lane.
pub(super) fn dot<const L: usize>(weights: &[[f64; L]; 4], values: &[[f64; L]; 4]) -> [f64; L] {
    std::array::from_fn(|i| {
        let [a, b, c, d] = std::array::from_fn(|k| weights[k][i] * values[k][i]);
        (a + b) + (c + d)
    })
}

/// Sum of a stencil with product weights, and its gradient: the weights of each axis in turn are replaced by `slopes`. `N` points along each
/// axis, in rows of `L` lanes.
pub(super) fn contract_with_gradient<const N: usize, const L: usize, const D: usize>(
    rows: &[[f64; L]],
    weights: &[[f64; N]; D],
    slopes: &[[f64; N]; D],
) -> (f64, Vector<D>) {
    let mut value = [0.0; L];
    let mut across = [[0.0; L]; D];
    // The rows at one position along the last axis are summed first.
    let plane = N.pow(D as u32 - 2);
    for (k, rows) in rows.chunks_exact(plane).take(N).enumerate() {
        let (mut sum, mut turned) = ([0.0; L], [0.0; L]);
        for (j, row) in rows.iter().enumerate() {
            let (weight, slope) = if D == 3 { (weights[1][j], slopes[1][j]) } else { (1.0, 0.0) };
            for i in 0..L {
                sum[i] += weight * row[i];
                turned[i] += slope * row[i];
            }
        }
        let (weight, slope) = (weights[D - 1][k], slopes[D - 1][k]);
        for i in 0..L {
            value[i] += weight * sum[i];
            across[1][i] += weight * turned[i];
        }
        for i in 0..L {
            across[D - 1][i] += slope * sum[i];
        }
    }
    let along = |w: &[f64; N], v: &[f64; L]| (0..N).map(|i| w[i] * v[i]).sum::<f64>();
    let slope = |a: usize| if a == 0 { along(&slopes[0], &value) } else { along(&weights[0], &across[a]) };
    (along(&weights[0], &value), Vector::from_fn(|a, _| slope(a)))
}

/// Sum of the stencil with product weights.
pub(super) fn contract<const D: usize>(rows: &[[f64; 4]], weights: &[[f64; 4]; D]) -> f64 {
    let mut sums = [0.0; 4];
    for (row, values) in rows.iter().enumerate() {
        let mut weight = 1.0;
        for a in 1..D {
            weight *= weights[a][row >> (2 * (a - 1)) & 3];
        }
        for i in 0..4 {
            sums[i] += weight * values[i];
        }
    }
    let w = &weights[0];
    (sums[0] * w[0] + sums[1] * w[1]) + (sums[2] * w[2] + sums[3] * w[3])
}
