//! The values around a point, and their sums with products of weights along the axes.

use crate::Vector;
use crate::lanes::{Compiled, LANES, Lanes};

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
    pub(super) fn middle<const D: usize>(&self) -> Self {
        let first = 1 + self.strides[..D - 1].iter().sum::<usize>();
        Self { values: &self.values[first..], strides: self.strides }
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

/// Weights of `N` points, or their derivatives: a lane for each axis.
pub(super) type AxisWeights<const N: usize> = [[f64; LANES]; N];

/// Sum of a stencil with product weights, and its gradient: the weights of each axis in turn are replaced by `slopes`. `N` points along each
/// axis, in rows of `L` values.
#[inline(always)]
pub(super) fn contract_with_gradient<const N: usize, const L: usize, const D: usize>(
    window: &Window<'_>,
    weights: &AxisWeights<N>,
    slopes: &AxisWeights<N>,
) -> (f64, Vector<D>) {
    let (mut value, mut across) = (Lanes::splat(Compiled, 0.0), [Lanes::splat(Compiled, 0.0); D]);
    // The rows at one position along the last axis are summed first.
    for k in 0..N {
        let (mut sum, mut turned) = (Lanes::splat(Compiled, 0.0), Lanes::splat(Compiled, 0.0));
        for j in 0..N.pow(D as u32 - 2) {
            let row = window.row::<L>(if D == 3 { j } else { k }, if D == 3 { k } else { 0 });
            let row = Lanes::load(Compiled, row, 0);
            let (weight, slope) = if D == 3 { (weights[j][1], slopes[j][1]) } else { (1.0, 0.0) };
            sum = sum + row * weight;
            turned = turned + row * slope;
        }
        let (weight, slope) = (weights[k][D - 1], slopes[k][D - 1]);
        value = value + sum * weight;
        across[1] = across[1] + turned * weight;
        across[D - 1] = across[D - 1] + sum * slope;
    }
    let (value, across) = (value.to_array(), across.map(Lanes::to_array));
    let along = |w: &AxisWeights<N>, v: &[f64; LANES]| (0..N).map(|i| w[i][0] * v[i]).sum::<f64>();
    let slope = |a: usize| if a == 0 { along(slopes, &value) } else { along(weights, &across[a]) };
    (along(weights, &value), Vector::from_fn(|a, _| slope(a)))
}

/// The value of [`contract_with_gradient`] alone.
#[inline(always)]
pub(super) fn contract_rows<const N: usize, const L: usize, const D: usize>(
    window: &Window<'_>,
    weights: &AxisWeights<N>,
) -> f64 {
    let mut value = Lanes::splat(Compiled, 0.0);
    for k in 0..N {
        let mut sum = Lanes::splat(Compiled, 0.0);
        for j in 0..N.pow(D as u32 - 2) {
            let row = window.row::<L>(if D == 3 { j } else { k }, if D == 3 { k } else { 0 });
            sum = sum + Lanes::load(Compiled, row, 0) * if D == 3 { weights[j][1] } else { 1.0 };
        }
        value = value + sum * weights[k][D - 1];
    }
    let value = value.to_array();
    (0..N).map(|i| weights[i][0] * value[i]).sum()
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
