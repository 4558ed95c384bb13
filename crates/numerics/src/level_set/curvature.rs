//! Curvature of the zero set of a signed distance.

use crate::grid::Sampler;
use crate::{Matrix, Vector};

/// Fourth-order differences: first derivative, second derivative.
const FIRST_DERIVATIVE_WEIGHTS: [f64; 5] = [1.0 / 12.0, -8.0 / 12.0, 0.0, 8.0 / 12.0, -1.0 / 12.0];
const SECOND_DERIVATIVE_WEIGHTS: [f64; 5] =
    [-1.0 / 12.0, 16.0 / 12.0, -30.0 / 12.0, 16.0 / 12.0, -1.0 / 12.0];
/// |∇φ| below which the differences cross a kink of the distance.
const MIN_GRADIENT_NORM: f64 = 0.5;
/// Minimum ratio of the area element on the zero set to that on the level set through the cell's centre.
const MIN_AREA_RATIO: f64 = 0.3;

/// Curvature (1/m) of the zero set at its point closest to the centre of `cell`: the sum of the principal curvatures,
/// positive for a ball. `None` if a kink or a focus of the distance is too near.
///
/// `phi` must sample a signed distance, negative inside, within at least two cells. With `S` and `K` the sum and the
/// product of the principal curvatures of the level set through the centre, at distance `d`, the parallel surface `d = 0`
/// has the curvature `(S − 2 d K) / (1 − d S + d² K)`.
pub fn curvature<const D: usize>(phi: &Sampler<'_, D>, dx: f64, cell: [usize; D]) -> Option<f64> {
    let value = |shift: [isize; D]| phi.value(std::array::from_fn(|a| cell[a] as isize + shift[a])) / dx;
    let (gradient, hessian) = gradient_and_hessian(&value);
    let square = gradient.norm_squared();
    let slope = square.sqrt();
    if slope < MIN_GRADIENT_NORM {
        return None;
    }
    let sum = (hessian.trace() * square - gradient.dot(&(hessian * gradient))) / (square * slope);
    let product = if D == 3 { adjugate_product(&hessian, &gradient) / (square * square) } else { 0.0 };
    let d = value([0; D]) / slope;
    let area = 1.0 - d * sum + d * d * product;
    (area > MIN_AREA_RATIO).then(|| (sum - 2.0 * d * product) / (area * dx))
}

/// Gradient and Hessian, with lengths in cells.
fn gradient_and_hessian<const D: usize>(value: &impl Fn([isize; D]) -> f64) -> (Vector<D>, Matrix<D>) {
    let mut gradient = Vector::zeros();
    let mut hessian = Matrix::zeros();
    for a in 0..D {
        let line: [f64; 5] = std::array::from_fn(|i| {
            let mut shift = [0; D];
            shift[a] = i as isize - 2;
            value(shift)
        });
        gradient[a] = dot(&FIRST_DERIVATIVE_WEIGHTS, &line);
        hessian[(a, a)] = dot(&SECOND_DERIVATIVE_WEIGHTS, &line);
        for b in 0..a {
            let slopes: [f64; 5] = std::array::from_fn(|j| {
                if FIRST_DERIVATIVE_WEIGHTS[j] == 0.0 {
                    return 0.0;
                }
                let line: [f64; 5] = std::array::from_fn(|i| {
                    let mut shift = [0; D];
                    (shift[a], shift[b]) = (i as isize - 2, j as isize - 2);
                    if FIRST_DERIVATIVE_WEIGHTS[i] == 0.0 { 0.0 } else { value(shift) }
                });
                dot(&FIRST_DERIVATIVE_WEIGHTS, &line)
            });
            hessian[(a, b)] = dot(&FIRST_DERIVATIVE_WEIGHTS, &slopes);
            hessian[(b, a)] = hessian[(a, b)];
        }
    }
    (gradient, hessian)
}

/// `g · adj(H) g` in 3D.
fn adjugate_product<const D: usize>(h: &Matrix<D>, g: &Vector<D>) -> f64 {
    let next = |i: usize| ((i + 1) % 3, (i + 2) % 3);
    let mut sum = 0.0;
    for i in 0..D {
        for j in 0..D {
            let ((b, c), (e, f)) = (next(i), next(j));
            sum += g[i] * g[j] * (h[(b, e)] * h[(c, f)] - h[(b, f)] * h[(c, e)]);
        }
    }
    sum
}

fn dot(a: &[f64; 5], b: &[f64; 5]) -> f64 {
    (0..5).map(|i| a[i] * b[i]).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
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
