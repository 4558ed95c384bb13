//! The values around a point, and their sums with products of weights along the axes.

use crate::Vector;

/// The values around a point, four along each axis, the first axis varying fastest.
pub(super) type Stencil = [[f64; 4]; 16];

/// The values around a point, in rows along the first axis.
#[derive(Clone, Copy)]
pub(super) struct Window<'w> {
    /// From the first value to the last.
    pub(super) values: &'w [f64],
    /// Distances between the rows along the second and the third axis.
    pub(super) strides: [usize; 2],
}

impl<'w> Window<'w> {
    /// The window of `N` rows of `L` values along each axis, packed.
    pub(super) fn of_rows<const N: usize, const L: usize>(rows: &'w [[f64; L]]) -> Self {
        Self { values: rows.as_flattened(), strides: [L, N * L] }
    }

    /// The first `L` values of a row.
    #[inline(always)]
    pub(super) fn row<const L: usize>(&self, line: usize, plane: usize) -> &'w [f64; L] {
        let start = line * self.strides[0] + plane * self.strides[1];
        self.values[start..].first_chunk().unwrap_or(const { &[0.0; L] })
    }

    /// The 4 middle points along each axis of a window of 6.
    #[inline(always)]
    pub(super) fn middle<const D: usize>(&self) -> Stencil {
        let first = 1 + self.strides[..D - 1].iter().sum::<usize>();
        Window { values: &self.values[first..], strides: self.strides }.stencil::<D>()
    }

    /// A copy of the first 4 points along each axis.
    #[inline(always)]
    pub(super) fn stencil<const D: usize>(&self) -> Stencil {
        std::array::from_fn(|row| if D == 3 || row < 4 { *self.row(row & 3, row >> 2) } else { [0.0; 4] })
    }
}

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
    window: &Window<'_>,
    weights: &[[f64; N]; D],
    slopes: &[[f64; N]; D],
) -> (f64, Vector<D>) {
    let mut value = [0.0; L];
    let mut across = [[0.0; L]; D];
    // The rows at one position along the last axis are summed first.
    for k in 0..N {
        let (mut sum, mut turned) = ([0.0; L], [0.0; L]);
        for j in 0..N.pow(D as u32 - 2) {
            let row = if D == 3 { window.row::<L>(j, k) } else { window.row::<L>(k, 0) };
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

/// The value of [`contract_with_gradient`] alone.
pub(super) fn contract_rows<const N: usize, const L: usize, const D: usize>(
    window: &Window<'_>,
    weights: &[[f64; N]; D],
) -> f64 {
    let mut value = [0.0; L];
    for k in 0..N {
        let mut sum = [0.0; L];
        for j in 0..N.pow(D as u32 - 2) {
            let row = if D == 3 { window.row::<L>(j, k) } else { window.row::<L>(k, 0) };
            let weight = if D == 3 { weights[1][j] } else { 1.0 };
            for i in 0..L {
                sum[i] += weight * row[i];
            }
        }
        for i in 0..L {
            value[i] += weights[D - 1][k] * sum[i];
        }
    }
    (0..N).map(|i| weights[0][i] * value[i]).sum()
}

/// Product of the weights along the axes across a row of four points.
#[inline(always)]
fn row_weight<const D: usize>(row: usize, weights: &[[f64; 4]; D]) -> f64 {
    (1..D).fold(1.0, |weight, a| weight * weights[a][row >> (2 * (a - 1)) & 3])
}

/// Sum of four weights with four values.
#[inline(always)]
fn weighted_sum(w: &[f64; 4], sums: &[f64; 4]) -> f64 {
    (sums[0] * w[0] + sums[1] * w[1]) + (sums[2] * w[2] + sums[3] * w[3])
}

/// Sum of 4 points along each axis with product weights.
pub(super) fn contract<const D: usize>(window: &Window<'_>, weights: &[[f64; 4]; D]) -> f64 {
    let mut sums = [0.0; 4];
    for row in 0..1usize << (2 * (D - 1)) {
        let (weight, values) = (row_weight(row, weights), window.row::<4>(row & 3, row >> 2));
        for i in 0..4 {
            sums[i] += weight * values[i];
        }
    }
    weighted_sum(&weights[0], &sums)
}

/// Sum of 4 points along each axis with product weights, clamped to the range of the values.
#[inline(always)]
pub(super) fn contract_within_range<const D: usize>(window: &Window<'_>, weights: &[[f64; 4]; D]) -> f64 {
    let (mut low, mut high, mut sums) = ([f64::INFINITY; 4], [f64::NEG_INFINITY; 4], [0.0; 4]);
    for row in 0..1usize << (2 * (D - 1)) {
        let (weight, values) = (row_weight(row, weights), window.row::<4>(row & 3, row >> 2));
        for i in 0..4 {
            let value = values[i];
            low[i] = if value < low[i] { value } else { low[i] };
            high[i] = if value > high[i] { value } else { high[i] };
            sums[i] += weight * value;
        }
    }
    let low = low[0].min(low[1]).min(low[2].min(low[3]));
    let high = high[0].max(high[1]).max(high[2].max(high[3]));
    weighted_sum(&weights[0], &sums).clamp(low, high)
}
