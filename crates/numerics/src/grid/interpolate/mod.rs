//! Interpolation of lattice data.
//!
//! Cubic interpolation is Lagrange's through four points along each axis (fourth order). "Limited" means that the result
//! is clamped to the range of the stencil's values, so that repeated sampling creates no new extrema.

mod lane_sums;
mod lanes;
mod stencil;
mod velocity;
mod weights;

pub use velocity::VelocitySampler;

use super::{Grid, Lattice};
use crate::Vector;
use crate::lanes::LANES;
use stencil::{
    Stencil, Window, contract, contract_rows, contract_with_gradient, contract_within_range, dot, transposed,
};
use weights::{
    MAX_SMOOTH_THIRD_DIFFERENCE_CELLS, cubic_weight_derivatives, cubic_weights, eno_cubic_weights,
    kink_indicator, max_third_difference, quintic_weights,
};

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
        self.linear_at(base, &t)
    }

    /// Limited cubic interpolation at `x` (m).
    pub fn cubic(&self, x: &Vector<D>) -> f64 {
        let (base, t) = self.locate(x);
        self.cubic_at(base, &t.map(cubic_weights))
    }

    /// Multilinear interpolation in a cell of the lattice.
    #[inline(always)]
    fn linear_at(&self, base: [isize; D], t: &[f64; D]) -> f64 {
        let mut mirrored = None;
        let window = self.window_or_mirrored::<2, 2, 4>(base, &mut mirrored);
        let mut sum = 0.0;
        for row in 0..1usize << (D - 1) {
            let mut weight = 1.0;
            for a in 1..D {
                weight *= if row >> (a - 1) & 1 == 1 { t[a] } else { 1.0 - t[a] };
            }
            let [low, high] = *window.row::<2>(row & 1, row >> 1);
            sum += weight * (low + t[0] * (high - low));
        }
        sum
    }

    /// Limited cubic interpolation in a cell of the lattice.
    #[inline(always)]
    fn cubic_at(&self, base: [isize; D], weights: &[[f64; 4]; D]) -> f64 {
        let mut mirrored = None;
        let window = self.window_or_mirrored::<4, 4, 16>(base, &mut mirrored);
        contract_within_range::<D>(&window, weights)
    }

    /// Cubic interpolation (not limited) at `x` (m): the value and its gradient (per m).
    pub fn cubic_with_gradient(&self, x: &Vector<D>) -> (f64, Vector<D>) {
        let (base, t) = self.locate(x);
        let rows = self.stencil(base);
        let (mut weights, mut slopes) = ([[0.0; LANES]; 4], [[0.0; LANES]; 4]);
        for a in 0..D {
            let (weight, slope) = (cubic_weights(t[a]), cubic_weight_derivatives(t[a]));
            (0..4).for_each(|i| (weights[i][a], slopes[i][a]) = (weight[i], slope[i]));
        }
        let window = Window::of_rows::<4, 4>(&rows);
        let (value, slopes) = contract_with_gradient::<4, 4, D>(&window, &weights, &slopes);
        (value, slopes * self.inverse_dx)
    }

    /// Value and gradient (per m) of a signed distance at `x` (m): quintic where it is smooth, one-sided cubic at its
    /// kinks. A cubic across a kink overshoots, which thickens filaments.
    pub fn distance_with_gradient(&self, x: &Vector<D>) -> (f64, Vector<D>) {
        let (base, t) = self.locate(x);
        let mut mirrored = None;
        let window = self.window_or_mirrored::<6, 8, 36>(base, &mut mirrored);
        let middle = window.middle::<D>();
        if self.is_smooth(&middle) {
            let [weights, slopes] = quintic_weights(&t);
            let (value, slopes) = contract_with_gradient::<6, 8, D>(&window, &weights, &slopes);
            (value, slopes * self.inverse_dx)
        } else {
            self.eno_cubic_in(middle.stencil::<D>(), &t)
        }
    }

    /// The value of [`Self::distance_with_gradient`] alone.
    pub fn distance(&self, x: &Vector<D>) -> f64 {
        let (base, t) = self.locate(x);
        let mut mirrored = None;
        let window = self.window_or_mirrored::<6, 8, 36>(base, &mut mirrored);
        let middle = window.middle::<D>();
        if self.is_smooth(&middle) {
            contract_rows::<6, 8, D>(&window, &quintic_weights(&t)[0])
        } else {
            self.eno_cubic_in(middle.stencil::<D>(), &t).0
        }
    }

    /// Whether the third differences of a signed distance are small enough for a polynomial.
    fn is_smooth(&self, middle: &Window<'_>) -> bool {
        max_third_difference::<D>(middle) * self.inverse_dx < MAX_SMOOTH_THIRD_DIFFERENCE_CELLS
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

    /// ENO cubic interpolation of a function with kinks: value and gradient.
    fn eno_cubic_in(&self, mut values: Stencil, t: &[f64; D]) -> (f64, Vector<D>) {
        let kink_indicator = kink_indicator::<D>(&values);
        let mut slopes = [[[0.0; 4]; 16]; D];
        // Each row along an axis is reduced to one value; these values form the rows of the next axis.
        for a in 0..D {
            for four in 0..(1 << (2 * (D - 1 - a))) / 4 {
                let rows = 4 * four..4 * four + 4;
                let old = transposed(&values[rows.clone()]);
                let cells = old.map(|point| point.map(|v| v * self.inverse_dx));
                let (weights, rises) = eno_cubic_weights(&cells, t[a], kink_indicator);
                values[four] = dot(&weights, &old);
                for slope in &mut slopes[..a] {
                    slope[four] = dot(&weights, &transposed(&slope[rows.clone()]));
                }
                slopes[a][four] = dot(&rises, &old).map(|rise| rise * self.inverse_dx);
            }
        }
        let a = D - 1;
        let last = values[0];
        let (weights, rises) = eno_cubic_weights(&last.map(|v| [v * self.inverse_dx]), t[a], kink_indicator);
        let sum = |weights: &[[f64; 1]; 4], values: &[f64; 4]| dot(weights, &values.map(|v| [v]))[0];
        let slope = |b: usize| {
            if b == a { sum(&rises, &last) * self.inverse_dx } else { sum(&weights, &slopes[b][0]) }
        };
        (sum(&weights, &last), Vector::from_fn(|b, _| slope(b)))
    }

    /// Gradient (per m) at a lattice point by central differences.
    pub fn gradient(&self, at: [usize; D]) -> Vector<D> {
        let here = self.lattice.index(at);
        Vector::from_fn(|a, _| {
            let difference = if at[a] > 0 && at[a] + 1 < self.lattice.extent[a] {
                self.data[here + self.lattice.stride[a]] - self.data[here - self.lattice.stride[a]]
            } else {
                let (mut up, mut down) = (at.map(|i| i as isize), at.map(|i| i as isize));
                up[a] += 1;
                down[a] -= 1;
                self.value(up) - self.value(down)
            };
            0.5 * self.inverse_dx * difference
        })
    }

    /// Differences, per cell, of the values at cell centres at the face `at` normal to `axis`: that of its two cells, and along the other axes
    /// the mean of the central differences at these cells.
    pub fn face_differences(&self, axis: usize, at: [usize; D]) -> [f64; D] {
        let Lattice { extent, stride } = &self.lattice;
        let is_inner = (0..D).all(|b| at[b] > 0 && at[b] + usize::from(b != axis) < extent[b]);
        let (upper, values) = (self.lattice.index(at), self.data);
        if is_inner && let Some(lower) = upper.checked_sub(stride[axis]) {
            let slope = |c: usize, b: usize| values[c + stride[b]] - values[c - stride[b]];
            return std::array::from_fn(|b| {
                if b == axis {
                    values[upper] - values[lower]
                } else {
                    0.25 * (slope(upper, b) + slope(lower, b))
                }
            });
        }
        let upper = at.map(|i| i as isize);
        let mut lower = upper;
        lower[axis] -= 1;
        let slope = |mut cell: [isize; D], b: usize| {
            cell[b] += 1;
            let up = self.value(cell);
            cell[b] -= 2;
            up - self.value(cell)
        };
        std::array::from_fn(|b| {
            if b == axis {
                self.value(upper) - self.value(lower)
            } else {
                0.25 * (slope(upper, b) + slope(lower, b))
            }
        })
    }

    /// The value of a signed distance at the centre of the face `at` normal to `axis`: quintic along the axis where it is smooth, else as
    /// [`Self::distance`].
    pub fn distance_at_face(&self, grid: &Grid<D>, axis: usize, at: [usize; D]) -> f64 {
        let Lattice { extent, stride } = &self.lattice;
        if at[axis] >= 3 && at[axis] + 3 <= extent[axis] && (0..D).all(|b| b == axis || at[b] < extent[b]) {
            let first = self.lattice.index(at) - 3 * stride[axis];
            let v: [f64; 6] = std::array::from_fn(|k| self.data[first + k * stride[axis]]);
            let third_difference = (v[4] - v[1]) - 3.0 * (v[3] - v[2]);
            if third_difference.abs() * self.inverse_dx < MAX_SMOOTH_THIRD_DIFFERENCE_CELLS {
                return (150.0 * (v[2] + v[3]) - 25.0 * (v[1] + v[4]) + 3.0 * (v[0] + v[5])) / 256.0;
            }
        }
        self.distance(&grid.face_center(axis, at))
    }

    /// The lattice cell that contains `x`, and the coordinates of `x` in it.
    #[inline(always)]
    fn locate(&self, x: &Vector<D>) -> ([isize; D], [f64; D]) {
        let mut base = [0; D];
        let mut t = [0.0; D];
        for a in 0..D {
            (base[a], t[a]) = self.locate_along(a, x[a]);
        }
        (base, t)
    }

    /// The same along an axis.
    #[inline(always)]
    fn locate_along(&self, a: usize, x: f64) -> (isize, f64) {
        // Clamp to two cells beyond the edge: there is no data farther out.
        let s = x * self.inverse_dx + (self.margin_cells[a] - self.stagger_cells[a]);
        let s = s.clamp(-2.0, self.lattice.extent[a] as f64 + 1.0);
        // Plain x86-64 has no instruction for `floor`.
        let toward_zero = s as isize;
        let base = toward_zero - isize::from(s < toward_zero as f64);
        (base, s - base as f64)
    }

    /// The values of the 4 points along each axis around a point.
    fn stencil(&self, base: [isize; D]) -> Stencil {
        self.window_or_mirrored::<4, 4, 16>(base, &mut None).stencil::<D>()
    }

    /// The values around a point, `N` along each axis, in rows of `L` lanes of which the first `N` count: where they lie, or in `mirrored`
    /// where they are not all within the data. `R` is `N²`.
    #[inline(always)]
    fn window_or_mirrored<'w, const N: usize, const L: usize, const R: usize>(
        &'w self,
        base: [isize; D],
        mirrored: &'w mut Option<[[f64; L]; R]>,
    ) -> Window<'w> {
        self.window::<N, L>(base)
            .unwrap_or_else(|| Window::of_rows::<N, L>(mirrored.insert(self.mirrored_rows::<N, L, R>(base))))
    }

    /// The values around a point, `N` along each axis, in rows of `L` lanes of which the first `N` count; `None` where they are not all
    /// within the data.
    #[inline(always)]
    fn window<const N: usize, const L: usize>(&self, base: [isize; D]) -> Option<Window<'a>> {
        let lattice = &self.lattice;
        let (mut origin, mut reach) = (0, L);
        for a in 0..D {
            let first = base[a] - (N as isize / 2 - 1);
            if first < 0 || first as usize + N > lattice.extent[a] {
                return None;
            }
            origin += first as usize * lattice.stride[a];
            reach += if a > 0 { (N - 1) * lattice.stride[a] } else { 0 };
        }
        let strides = [lattice.stride[1], if D == 3 { lattice.stride[2] } else { 0 }];
        self.data.get(origin..origin + reach).map(|values| Window { values, strides })
    }

    /// The values around a point, `N` along each axis, in rows of `L` lanes of which the first `N` count; beyond the edges of the lattice they
    /// are extended. `R` is `N²`.
    #[cold]
    #[inline(never)]
    fn mirrored_rows<const N: usize, const L: usize, const R: usize>(
        &self,
        base: [isize; D],
    ) -> [[f64; L]; R] {
        let mut rows = [[0.0; L]; R];
        let first = base.map(|b| b - (N as isize / 2 - 1));
        let axes: [[(usize, f64); N]; D] =
            std::array::from_fn(|a| std::array::from_fn(|k| self.mirrored(a, first[a] + k as isize)));
        for (row, values) in rows.iter_mut().enumerate().take(N.pow(D as u32 - 1)) {
            let (mut at, mut sign) = (0, 1.0);
            for a in 1..D {
                let (index, factor) = axes[a][row / N.pow(a as u32 - 1) % N];
                at += index * self.lattice.stride[a];
                sign *= factor;
            }
            for (value, (index, factor)) in values.iter_mut().zip(axes[0]) {
                *value = sign * factor * self.data[at + index];
            }
        }
        rows
    }

    /// The value at a lattice point that may lie beyond the edges.
    #[inline]
    pub fn value(&self, at: [isize; D]) -> f64 {
        // A negative coordinate is larger than any extent as an unsigned number.
        if (0..D).all(|a| (at[a] as usize) < self.lattice.extent[a]) {
            self.data[self.lattice.index(at.map(|i| i as usize))]
        } else {
            self.mirrored_value(at)
        }
    }

    /// The value at a lattice point beyond the edges.
    #[cold]
    #[inline(never)]
    fn mirrored_value(&self, at: [isize; D]) -> f64 {
        let places: [(usize, f64); D] = std::array::from_fn(|a| self.mirrored(a, at[a]));
        let sign: f64 = places.iter().map(|place| place.1).product();
        sign * self.data[self.lattice.index(places.map(|place| place.0))]
    }

    /// The place along an axis that holds the value of a place that may lie beyond the edges, and the factor of this value.
    #[inline]
    fn mirrored(&self, a: usize, at: isize) -> (usize, f64) {
        let n = self.lattice.extent[a] as isize;
        // The mirror planes are the domain's sides: half a cell beyond the outermost centre, or on the outermost face.
        let beyond = if self.stagger_cells[a] == 0.5 { 1 } else { 0 };
        let (edge, mirrored) = if at < 0 {
            (self.boundary_extensions[a][0], -at - beyond)
        } else if at >= n {
            (self.boundary_extensions[a][1], 2 * (n - 1) + beyond - at)
        } else {
            return (at as usize, 1.0);
        };
        match edge {
            BoundaryExtension::Even => (mirrored.clamp(0, n - 1) as usize, 1.0),
            BoundaryExtension::Odd => (mirrored.clamp(0, n - 1) as usize, -1.0),
            BoundaryExtension::Clamp => (at.clamp(0, n - 1) as usize, 1.0),
        }
    }
}

/// Multilinear interpolation between the middle points of a stencil.
fn multilinear<const D: usize>(stencil: &Stencil, t: &[f64; D]) -> f64 {
    let weights: [[f64; 4]; D] = std::array::from_fn(|a| [0.0, 1.0 - t[a], t[a], 0.0]);
    contract::<D>(&Window::of_rows::<4, 4>(stencil), &weights)
}

#[cfg(test)]
mod tests;
