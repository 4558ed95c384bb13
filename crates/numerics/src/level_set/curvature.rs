//! Curvature of the zero set of a signed distance.

use crate::grid::Sampler;
use crate::lanes::{Compiled, LANES, Lanes};
use std::ops::{Add, Div, Mul, Sub};

/// Fourth-order differences: first derivative, second derivative.
const FIRST_DERIVATIVE_WEIGHTS: [f64; 5] = [1.0 / 12.0, -8.0 / 12.0, 0.0, 8.0 / 12.0, -1.0 / 12.0];
const SECOND_DERIVATIVE_WEIGHTS: [f64; 5] =
    [-1.0 / 12.0, 16.0 / 12.0, -30.0 / 12.0, 16.0 / 12.0, -1.0 / 12.0];
/// |∇φ| below which the differences cross a kink of the distance.
const MIN_GRADIENT_NORM: f64 = 0.5;
/// Minimum ratio of the area element on the zero set to that on the level set through the cell's centre.
const MIN_AREA_RATIO: f64 = 0.3;

/// Numbers, of one cell or of the cells in all lanes.
trait Number:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Mul<f64, Output = Self>
    + Div<Output = Self>
{
    fn root(self) -> Self;
}

impl Number for f64 {
    fn root(self) -> Self {
        self.sqrt()
    }
}

impl Number for Lanes<Compiled> {
    #[inline(always)]
    fn root(self) -> Self {
        self.sqrt()
    }
}

/// Curvature (1/m) of the zero set at its point closest to the centre of `cell`: the sum of the principal curvatures,
/// positive for a ball. `None` if a kink or a focus of the distance is too near.
///
/// `phi` must sample a signed distance, negative inside, within at least two cells. With `S` and `K` the sum and the
/// product of the principal curvatures of the level set through the centre, at distance `d`, the parallel surface `d = 0`
/// has the curvature `(S − 2 d K) / (1 − d S + d² K)`.
pub fn curvature<const D: usize>(phi: &Sampler<'_, D>, dx: f64, cell: [usize; D]) -> Option<f64> {
    let value = |shift: [isize; D]| phi.value(std::array::from_fn(|a| cell[a] as isize + shift[a])) / dx;
    accepted(parallel_curvature(value, 1.0), dx)
}

/// [`curvature`] in each of several cells.
pub fn curvatures<const D: usize>(
    phi: &Sampler<'_, D>,
    dx: f64,
    cells: [[usize; D]; LANES],
) -> [Option<f64>; LANES] {
    let Some(values) = phi.values_around(Compiled, cells, 2) else {
        return cells.map(|cell| curvature(phi, dx, cell));
    };
    let [slope, area, kappa] =
        parallel_curvature(|shift| values(shift) / dx, Lanes::splat(Compiled, 1.0)).map(Lanes::to_array);
    std::array::from_fn(|l| accepted([slope[l], area[l], kappa[l]], dx))
}

/// The curvature of the parallel surface, unless a kink or a focus is too near.
fn accepted([slope, area, kappa]: [f64; 3], dx: f64) -> Option<f64> {
    (slope >= MIN_GRADIENT_NORM && area > MIN_AREA_RATIO).then(|| kappa / (area * dx))
}

/// |∇φ|, the ratio of the area elements and its product with the curvature on the zero set, with lengths in cells.
#[inline(always)]
fn parallel_curvature<T: Number, const D: usize>(value: impl Fn([isize; D]) -> T, one: T) -> [T; 3] {
    let (g, h) = gradient_and_hessian(&value);
    let sum = |of: &dyn Fn(usize) -> T| (1..D).fold(of(0), |sum, i| sum + of(i));
    let square = sum(&|i| g[i] * g[i]);
    let slope = square.root();
    let bent = sum(&|i| g[i] * sum(&|j| h[i][j] * g[j]));
    let total = (sum(&|i| h[i][i]) * square - bent) / (square * slope);
    let d = value([0; D]) / slope;
    if D == 2 {
        return [slope, one - d * total, total];
    }
    let product = adjugate_product(&h, &g) / (square * square);
    [slope, one - d * total + d * d * product, total - d * 2.0 * product]
}

/// Gradient and Hessian, with lengths in cells.
#[inline(always)]
fn gradient_and_hessian<T: Number, const D: usize>(
    value: &impl Fn([isize; D]) -> T,
) -> ([T; D], [[T; D]; D]) {
    let at = |steps: [(usize, isize); 2]| {
        let mut shift = [0; D];
        steps.iter().for_each(|(a, step)| shift[*a] += step);
        value(shift)
    };
    let mut gradient = [value([0; D]); D];
    let mut hessian = [gradient; D];
    for a in 0..D {
        let line: [T; 5] = std::array::from_fn(|i| at([(a, i as isize - 2), (a, 0)]));
        gradient[a] = dot(&FIRST_DERIVATIVE_WEIGHTS, &line);
        hessian[a][a] = dot(&SECOND_DERIVATIVE_WEIGHTS, &line);
        for b in 0..a {
            let along = |j: isize| first_derivative(|i| at([(a, i), (b, j)]));
            hessian[a][b] = first_derivative(along);
            hessian[b][a] = hessian[a][b];
        }
    }
    (gradient, hessian)
}

/// First derivative of values at whole places around zero.
#[inline(always)]
fn first_derivative<T: Number>(value: impl Fn(isize) -> T) -> T {
    let [low, below, _, above, high] = FIRST_DERIVATIVE_WEIGHTS;
    value(-2) * low + value(-1) * below + value(1) * above + value(2) * high
}

/// `g · adj(H) g` in 3D.
#[inline(always)]
fn adjugate_product<T: Number, const D: usize>(h: &[[T; D]; D], g: &[T; D]) -> T {
    let next = |i: usize| ((i + 1) % 3, (i + 2) % 3);
    let term = |i: usize, j: usize| {
        let ((b, c), (e, f)) = (next(i), next(j));
        g[i] * g[j] * (h[b][e] * h[c][f] - h[b][f] * h[c][e])
    };
    (1..D * D).fold(term(0, 0), |sum, k| sum + term(k / D, k % D))
}

#[inline(always)]
fn dot<T: Number>(weights: &[f64; 5], values: &[T; 5]) -> T {
    (1..5).fold(values[0] * weights[0], |sum, i| sum + values[i] * weights[i])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Vector;
    use crate::grid::{BoundaryExtension, CellField, Grid};

    /// Largest relative error of the curvature near a ball with a radius of `n / 4` cells.
    fn error<const D: usize>(n: usize) -> f64 {
        let grid = Grid::<D>::new([n; D], 1.0 / n as f64);
        let lattice = grid.lattice();
        let center = Vector::from_fn(|a, _| 0.5 + 0.013 * a as f64);
        let mut phi = CellField::new(grid, 0.0);
        for i in 0..lattice.len() {
            phi.data[i] = (grid.center(lattice.coordinates(i)) - center).norm() - 0.25;
        }
        let sampler = Sampler::cells(&grid, &phi.data, [[BoundaryExtension::Even; 2]; D]);
        let exact = (D - 1) as f64 / 0.25;
        (0..lattice.len())
            .filter(|&i| phi.data[i].abs() < 1.5 * grid.dx)
            .map(|i| curvature(&sampler, grid.dx, lattice.coordinates(i)))
            .map(|k| k.map_or(f64::INFINITY, |k| (k / exact - 1.0).abs()))
            .fold(0.0, f64::max)
    }

    #[test]
    fn curvature_of_a_ball_is_of_fourth_order() {
        let (coarse, fine) = (error::<2>(32), error::<2>(64));
        assert!(fine < 2e-4 && coarse / fine > 10.0, "{coarse:e} {fine:e}");
        let (coarse, fine) = (error::<3>(32), error::<3>(64));
        assert!(fine < 2e-4 && coarse / fine > 10.0, "{coarse:e} {fine:e}");
    }

    #[test]
    fn a_kink_has_no_curvature() {
        let grid = Grid::<2>::new([16, 16], 1.0);
        let data: Vec<f64> = (0..256).map(|i| ((i % 16) as f64 - 7.0).abs() - 1.5).collect();
        let sampler = Sampler::cells(&grid, &data, [[BoundaryExtension::Even; 2]; 2]);
        assert_eq!(curvature(&sampler, grid.dx, [7, 8]), None);
        assert!(curvature(&sampler, grid.dx, [3, 8]).is_some_and(|k| k.abs() < 1e-12));
    }
}
