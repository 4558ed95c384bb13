//! Interpolation of lattice data.
//!
//! Cubic interpolation is Lagrange's through four points along each axis (fourth order). "Limited" means that the result
//! is clamped to the range of the stencil's values, so that repeated sampling creates no new extrema.

use super::{Grid, Lattice};
use crate::Vector;

/// Extension of data beyond the last point of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BoundaryExtension {
    /// Mirrored: tangential velocity, distance and everything else at a frictionless wall.
    Even,
    /// Mirrored with the opposite sign: normal velocity at a wall.
    Odd,
    /// Constant: an open side.
    Clamp,
}

/// Lattice data that can be sampled at any point.
#[derive(Clone, Copy)]
pub struct Sampler<'a, const D: usize> {
    data: &'a [f64],
    lattice: Lattice<D>,
    /// Position of point 0 in cells from the grid's lower side: 0.5 for centres, 0 along the normal of faces.
    stagger_cells: [f64; D],
    /// Cells of the grid below the origin.
    margin_cells: [f64; D],
    boundary_extensions: [[BoundaryExtension; 2]; D],
    inverse_dx: f64,
}

/// The values around a point, four along each axis, the first axis varying fastest.
type Stencil = [[f64; 4]; 16];

impl<'a, const D: usize> Sampler<'a, D> {
    /// Samples values at cell centres; `edges` are the boundary extensions of a scalar.
    pub fn cells(grid: &Grid<D>, data: &'a [f64], edges: [[BoundaryExtension; 2]; D]) -> Self {
        Self::new(grid, data, grid.lattice(), [0.5; D], edges)
    }

    /// Samples values on the faces normal to `axis`; `edges` are the boundary extensions of that velocity component.
    pub fn faces(grid: &Grid<D>, axis: usize, data: &'a [f64], edges: [[BoundaryExtension; 2]; D]) -> Self {
        let mut shift = [0.5; D];
        shift[axis] = 0.0;
        Self::new(grid, data, grid.face_lattice(axis), shift, edges)
    }

    fn new(
        grid: &Grid<D>,
        data: &'a [f64],
        lattice: Lattice<D>,
        stagger_cells: [f64; D],
        boundary_extensions: [[BoundaryExtension; 2]; D],
    ) -> Self {
        let margin_cells = grid.margin_cells.map(|m| m[0] as f64);
        Self { data, lattice, stagger_cells, margin_cells, boundary_extensions, inverse_dx: 1.0 / grid.dx }
    }

    /// Multilinear interpolation at `x` (m).
    pub fn linear(&self, x: &Vector<D>) -> f64 {
        let (base, t) = self.locate(x);
        let mut sum = 0.0;
        if (0..D).all(|a| base[a] >= 0 && base[a] + 1 < self.lattice.extent[a] as isize) {
            let origin = self.lattice.index(std::array::from_fn(|a| base[a] as usize));
            for row in 0..1usize << (D - 1) {
                let mut at = origin;
                let mut weight = 1.0;
                for a in 1..D {
                    let up = row >> (a - 1) & 1;
                    at += up * self.lattice.stride[a];
                    weight *= if up == 1 { t[a] } else { 1.0 - t[a] };
                }
                sum += weight * (self.data[at] + t[0] * (self.data[at + 1] - self.data[at]));
            }
        } else {
            for corner in 0..1usize << D {
                let mut weight = 1.0;
                let mut at = base;
                for a in 0..D {
                    let up = corner >> a & 1;
                    at[a] += up as isize;
                    weight *= if up == 1 { t[a] } else { 1.0 - t[a] };
                }
                sum += weight * self.value(at);
            }
        }
        sum
    }

    /// Limited cubic interpolation at `x` (m).
    pub fn cubic(&self, x: &Vector<D>) -> f64 {
        let (base, t) = self.locate(x);
        let stencil = self.stencil(base);
        let rows = &stencil[..1 << (2 * (D - 1))];
        let (mut low, mut high) = ([f64::INFINITY; 4], [f64::NEG_INFINITY; 4]);
        for row in rows {
            for i in 0..4 {
                low[i] = low[i].min(row[i]);
                high[i] = high[i].max(row[i]);
            }
        }
        let weights: [[f64; 4]; D] = std::array::from_fn(|a| cubic_weights(t[a]));
        let low = low[0].min(low[1]).min(low[2].min(low[3]));
        let high = high[0].max(high[1]).max(high[2].max(high[3]));
        contract::<D>(rows, &weights).clamp(low, high)
    }

    /// Cubic interpolation (not limited) at `x` (m): the value and its gradient (per m).
    pub fn cubic_with_gradient(&self, x: &Vector<D>) -> (f64, Vector<D>) {
        let (base, t) = self.locate(x);
        self.cubic_in(&self.stencil(base), &t)
    }

    /// Value and gradient (per m) of a signed distance at `x` (m): quintic where it is smooth, one-sided cubic at its
    /// kinks. A cubic across a kink overshoots, which thickens filaments.
    pub fn distance_with_gradient(&self, x: &Vector<D>) -> (f64, Vector<D>) {
        let (base, t) = self.locate(x);
        let stencil = self.stencil(base);
        if max_third_difference::<D>(&stencil) * self.inverse_dx < MAX_SMOOTH_THIRD_DIFFERENCE_CELLS {
            self.quintic_in(base, &t)
        } else {
            self.eno_cubic_in(stencil, &t)
        }
    }

    /// Value of a signed distance at `x` (m), as seen from one side of thin solids. `side` takes the first point of the stencil, which has 4
    /// points along each axis, and returns the points on that side: a bit each, the first axis varying fastest.
    ///
    /// If all points on that side have one sign, there is no surface on it, whatever lies beyond the solid: all points then take this sign, and
    /// the interpolation is multilinear, which keeps it.
    pub fn distance_on_side(&self, x: &Vector<D>, side: impl FnOnce([isize; D]) -> u64) -> f64 {
        let (base, t) = self.locate(x);
        let mut stencil = self.stencil(base);
        let values = || stencil.iter().flatten().take(4usize.pow(D as u32));
        let negative = values().enumerate().map(|(k, v)| u64::from(*v < 0.0) << k).sum::<u64>();
        if negative != 0 && values().any(|v| *v >= 0.0) {
            let own = side(base.map(|b| b - 1));
            let below = negative & own;
            if own != 0 && (below == 0 || below == own) {
                let sign = if below == 0 { 1.0 } else { -1.0 };
                stencil.iter_mut().flatten().for_each(|v| *v = v.abs() * sign);
                return multilinear::<D>(&stencil, &t);
            }
        }
        self.distance_with_gradient(x).0
    }

    /// Quintic interpolation: value and gradient.
    fn quintic_in(&self, base: [isize; D], t: &[f64; D]) -> (f64, Vector<D>) {
        let rows = self.rows::<6, 36>(base);
        let both: [([f64; 6], [f64; 6]); D] = std::array::from_fn(|a| quintic_weights(t[a]));
        let (value, slopes) = contract_with_gradient::<6, D>(
            &rows[..6usize.pow(D as u32 - 1)],
            &both.map(|b| b.0),
            &both.map(|b| b.1),
        );
        (value, slopes * self.inverse_dx)
    }

    /// Cubic interpolation: value and gradient.
    fn cubic_in(&self, stencil: &Stencil, t: &[f64; D]) -> (f64, Vector<D>) {
        let rows = &stencil[..1 << (2 * (D - 1))];
        let weights: [[f64; 4]; D] = std::array::from_fn(|a| cubic_weights(t[a]));
        let (value, slopes) = contract_with_gradient::<4, D>(
            rows,
            &weights,
            &std::array::from_fn(|a| cubic_weight_derivatives(t[a])),
        );
        (value, slopes * self.inverse_dx)
    }

    /// ENO cubic interpolation of a function with kinks: value and gradient.
    fn eno_cubic_in(&self, mut values: Stencil, t: &[f64; D]) -> (f64, Vector<D>) {
        let kink_indicator = kink_indicator::<D>(&values);
        let mut slopes = [[[0.0; 4]; 16]; D];
        // Each row along an axis is reduced to one value; these values form the rows of the next axis.
        for a in 0..D {
            for row in 0..1 << (2 * (D - 1 - a)) {
                let old = values[row];
                let (weights, rises) =
                    eno_cubic_weights(&old.map(|v| v * self.inverse_dx), t[a], kink_indicator);
                values[row / 4][row % 4] = dot(&weights, &old);
                for slope in &mut slopes[..a] {
                    slope[row / 4][row % 4] = dot(&weights, &slope[row]);
                }
                slopes[a][row / 4][row % 4] = dot(&rises, &old) * self.inverse_dx;
            }
        }
        (values[0][0], Vector::from_fn(|a, _| slopes[a][0][0]))
    }

    /// Gradient (per m) at a lattice point by central differences.
    pub fn gradient(&self, at: [usize; D]) -> Vector<D> {
        Vector::from_fn(|a, _| {
            let (mut up, mut down) = (at.map(|i| i as isize), at.map(|i| i as isize));
            up[a] += 1;
            down[a] -= 1;
            0.5 * self.inverse_dx * (self.value(up) - self.value(down))
        })
    }

    /// The lattice cell that contains `x`, and the coordinates of `x` in it.
    fn locate(&self, x: &Vector<D>) -> ([isize; D], [f64; D]) {
        let mut base = [0; D];
        let mut t = [0.0; D];
        for a in 0..D {
            // Clamp to two cells beyond the edge: there is no data farther out.
            let s = x[a] * self.inverse_dx + (self.margin_cells[a] - self.stagger_cells[a]);
            let s = s.clamp(-2.0, self.lattice.extent[a] as f64 + 1.0);
            let floor = s.floor();
            base[a] = floor as isize;
            t[a] = s - floor;
        }
        (base, t)
    }

    fn stencil(&self, base: [isize; D]) -> Stencil {
        self.rows::<4, 16>(base)
    }

    /// The values around a point, `N` along each axis; `R` is `N²`.
    fn rows<const N: usize, const R: usize>(&self, base: [isize; D]) -> [[f64; N]; R] {
        let mut rows = [[0.0; N]; R];
        let before = N / 2 - 1;
        let first = base.map(|b| b - before as isize);
        let place = |row: usize, a: usize| row / N.pow(a as u32 - 1) % N;
        let inside =
            (0..D).all(|a| first[a] >= 0 && first[a] + N as isize <= self.lattice.extent[a] as isize);
        if inside {
            let origin = self.lattice.index(first.map(|i| i as usize));
            for (row, values) in rows.iter_mut().enumerate().take(N.pow(D as u32 - 1)) {
                let at = origin + (1..D).map(|a| place(row, a) * self.lattice.stride[a]).sum::<usize>();
                values.copy_from_slice(&self.data[at..at + N]);
            }
        } else {
            for (row, values) in rows.iter_mut().enumerate().take(N.pow(D as u32 - 1)) {
                for (i, value) in values.iter_mut().enumerate() {
                    let shift = |a: usize| if a == 0 { i } else { place(row, a) };
                    *value = self.value(std::array::from_fn(|a| first[a] + shift(a) as isize));
                }
            }
        }
        rows
    }

    /// The value at a lattice point that may lie beyond the edges.
    pub fn value(&self, mut at: [isize; D]) -> f64 {
        let mut sign = 1.0;
        for a in 0..D {
            let n = self.lattice.extent[a] as isize;
            // The mirror planes are the domain's sides: half a cell beyond the outermost centre, or on the outermost face.
            let beyond = if self.stagger_cells[a] == 0.5 { 1 } else { 0 };
            let (edge, mirrored) = if at[a] < 0 {
                (self.boundary_extensions[a][0], -at[a] - beyond)
            } else if at[a] >= n {
                (self.boundary_extensions[a][1], 2 * (n - 1) + beyond - at[a])
            } else {
                continue;
            };
            match edge {
                BoundaryExtension::Even => at[a] = mirrored.clamp(0, n - 1),
                BoundaryExtension::Odd => {
                    at[a] = mirrored.clamp(0, n - 1);
                    sign = -sign;
                }
                BoundaryExtension::Clamp => at[a] = at[a].clamp(0, n - 1),
            }
        }
        sign * self.data[self.lattice.index(std::array::from_fn(|a| at[a] as usize))]
    }
}

/// Multilinear interpolation between the middle points of a stencil.
fn multilinear<const D: usize>(stencil: &Stencil, t: &[f64; D]) -> f64 {
    let weights: [[f64; 4]; D] = std::array::from_fn(|a| [0.0, 1.0 - t[a], t[a], 0.0]);
    contract::<D>(&stencil[..1 << (2 * (D - 1))], &weights)
}

/// Weights of the cubic through the points −1, 0, 1, 2 at `t`.
fn cubic_weights(t: f64) -> [f64; 4] {
    let (a, b, c) = (t + 1.0, t - 1.0, t - 2.0);
    [-t * b * c / 6.0, a * b * c / 2.0, -a * t * c / 2.0, a * t * b / 6.0]
}

/// Derivatives of [`cubic_weights`].
fn cubic_weight_derivatives(t: f64) -> [f64; 4] {
    let s = t * t;
    [
        (-3.0 * s + 6.0 * t - 2.0) / 6.0,
        (3.0 * s - 4.0 * t - 1.0) / 2.0,
        (-3.0 * s + 2.0 * t + 2.0) / 2.0,
        (3.0 * s - 1.0) / 6.0,
    ]
}

/// Third difference, in cells, up to which a distance counts as smooth: a ball with a radius of seven cells has no larger one.
const MAX_SMOOTH_THIRD_DIFFERENCE_CELLS: f64 = 0.02;
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
fn eno_cubic_weights(v: &[f64; 4], t: f64, kink_indicator: f64) -> ([f64; 4], [f64; 4]) {
    let (a, b) = (v[0] - 2.0 * v[1] + v[2], v[1] - 2.0 * v[2] + v[3]);
    let differ =
        (((a - b).abs() - MAX_SMOOTH_THIRD_DIFFERENCE_CELLS).max(0.0) / KINK_TRANSITION_CELLS).powi(4);
    let smooth = 1.0 / (1.0 + differ) / 3.0;
    let (q, dq) = (0.5 * t * (t - 1.0), t - 0.5);
    let (mut left, mut right) = (smooth * (2.0 - t), smooth * (1.0 + t));
    let (mut l, mut r) = ([q * left, dq * left - q * smooth], [q * right, dq * right + q * smooth]);
    if a * b > 0.0 {
        let rest = 1.0 - 3.0 * smooth;
        let kink_indicator = kink_indicator * rest;
        (left, right) = if a.abs() < b.abs() { (rest, 0.0) } else { (0.0, rest) };
        let near = t * a.abs() < (1.0 - t) * b.abs();
        let (low, high) = if near { ([-t, -1.0], [0.0; 2]) } else { ([0.0; 2], [t - 1.0, 1.0]) };
        for (i, q) in [q, dq].into_iter().enumerate() {
            l[i] += q * left;
            r[i] += q * right;
            l[i] += kink_indicator * (low[i] - l[i]);
            r[i] += kink_indicator * (high[i] - r[i]);
        }
    }
    let sum = |chord: [f64; 2], l: f64, r: f64| [l, chord[0] - 2.0 * l + r, chord[1] + l - 2.0 * r, r];
    (sum([1.0 - t, t], l[0], r[0]), sum([-1.0, 1.0], l[1], r[1]))
}

/// Certainty, 0 to 1, that a kink passes through the middle cube of a stencil: the differences there see a smaller slope
/// than those in the cubes on both sides.
fn kink_indicator<const D: usize>(rows: &Stencil) -> f64 {
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

fn dot(a: &[f64; 4], b: &[f64; 4]) -> f64 {
    (a[0] * b[0] + a[1] * b[1]) + (a[2] * b[2] + a[3] * b[3])
}

/// Sum of a stencil with product weights, and its gradient: the weights of each axis in turn are replaced by `slopes`.
fn contract_with_gradient<const N: usize, const D: usize>(
    rows: &[[f64; N]],
    weights: &[[f64; N]; D],
    slopes: &[[f64; N]; D],
) -> (f64, Vector<D>) {
    let mut value = [0.0; N];
    let mut across = [[0.0; N]; D];
    // The rows at one position along the last axis are summed first.
    for (k, plane) in rows.chunks_exact(rows.len() / N).enumerate() {
        let (mut sum, mut turned) = ([0.0; N], [0.0; N]);
        for (j, row) in plane.iter().enumerate() {
            let (weight, slope) = if D == 3 { (weights[1][j], slopes[1][j]) } else { (1.0, 0.0) };
            for i in 0..N {
                sum[i] += weight * row[i];
                turned[i] += slope * row[i];
            }
        }
        for i in 0..N {
            value[i] += weights[D - 1][k] * sum[i];
            across[1][i] += weights[D - 1][k] * turned[i];
        }
        for i in 0..N {
            across[D - 1][i] += slopes[D - 1][k] * sum[i];
        }
    }
    let along = |w: &[f64; N], v: &[f64; N]| (0..N).map(|i| w[i] * v[i]).sum::<f64>();
    let slope = |a: usize| if a == 0 { along(&slopes[0], &value) } else { along(&weights[0], &across[a]) };
    (along(&weights[0], &value), Vector::from_fn(|a, _| slope(a)))
}

/// Weights of the quintic through the points −2 ... 3 at `t`, and their derivatives.
fn quintic_weights(t: f64) -> ([f64; 6], [f64; 6]) {
    const SCALE: [f64; 6] = [-1.0 / 120.0, 1.0 / 24.0, -1.0 / 12.0, 1.0 / 12.0, -1.0 / 24.0, 1.0 / 120.0];
    // Products of the distances to the points before and after each one, with derivatives.
    let away = |i: usize| t + 2.0 - i as f64;
    let (mut before, mut after) = ([(1.0, 0.0); 6], [(1.0, 0.0); 6]);
    for i in 1..6 {
        let (p, dp) = before[i - 1];
        before[i] = (p * away(i - 1), dp * away(i - 1) + p);
        let (q, dq) = after[6 - i];
        after[5 - i] = (q * away(6 - i), dq * away(6 - i) + q);
    }
    let weight = |i: usize| SCALE[i] * before[i].0 * after[i].0;
    let slope = |i: usize| SCALE[i] * (before[i].1 * after[i].0 + before[i].0 * after[i].1);
    (std::array::from_fn(weight), std::array::from_fn(slope))
}

/// The largest third difference of a stencil.
fn max_third_difference<const D: usize>(rows: &Stencil) -> f64 {
    let mut worst = [0.0f64; 4];
    let rows = &rows[..1 << (2 * (D - 1))];
    for row in rows {
        worst[0] = worst[0].max((3.0 * (row[1] - row[2]) + row[3] - row[0]).abs());
    }
    for a in 1..D {
        let step = 1 << (2 * (a - 1));
        for first in (0..rows.len()).filter(|r| r / step % 4 == 0) {
            let line: [&[f64; 4]; 4] = std::array::from_fn(|k| &rows[first + k * step]);
            for i in 0..4 {
                let third = 3.0 * (line[1][i] - line[2][i]) + line[3][i] - line[0][i];
                worst[i] = worst[i].max(third.abs());
            }
        }
    }
    worst[0].max(worst[1]).max(worst[2].max(worst[3]))
}

/// Sum of the stencil with product weights.
fn contract<const D: usize>(rows: &[[f64; 4]], weights: &[[f64; 4]; D]) -> f64 {
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

#[cfg(test)]
#[path = "interpolate_tests.rs"]
mod tests;
