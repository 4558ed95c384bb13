//! Redistancing: signed distance from closest points.
//!
//! For every cell of the narrow band, Newton's method finds the closest point on the zero set of the interpolant of the
//! old values ([`Sampler::distance_with_gradient`]; Chopp 2001, "Some improvements of the fast marching method"). Where
//! the old values are nearly a signed distance, the iteration starts from the point that they predict. Elsewhere it
//! starts from the closest points of the neighbours nearer to the interface, layer by layer; other initial guesses
//! converge to wrong points. No first-order marching is used.

use crate::Vector;
use crate::grid::{Band, Grid, Sampler};
use crate::par;

/// Maximum number of Newton iterations.
const MAX_NEWTON_ITERATIONS: usize = 12;
/// Length of the last Newton step, in cells. The remaining error of the point is far smaller, and that of the distance is its square.
const NEWTON_TOLERANCE_CELLS: f64 = 1e-3;
/// Maximum deviation of |∇φ| from 1 for which the old values predict the initial guess.
const MAX_GRADIENT_DEVIATION: f64 = 0.2;

/// The signed distance (m) to the zero set of `phi` on the first `layers` layers of the band, in the order of
/// `band.cells`. Its magnitude is at most `limit` (m).
///
/// `sampler` must sample `phi`.
pub fn redistance<const D: usize>(
    grid: &Grid<D>,
    band: &Band<D>,
    layers: usize,
    phi: &[f64],
    sampler: &Sampler<'_, D>,
    limit: f64,
) -> Vec<f64> {
    let lattice = grid.lattice();
    let count = band.first_layers(layers).end;
    let mut closest: Vec<Vector<D>> = vec![Vector::zeros(); count];
    let mut distance = vec![f64::INFINITY; count];
    for layer in 0..layers.min(band.layers.len() - 1) {
        let range = band.layers[layer]..band.layers[layer + 1];
        let (done, _) = closest.split_at(range.start);
        let found = par::map_slice(&band.cells[range.clone()], 1, |&cell| {
            let cell = cell as usize;
            let at = lattice.coordinates(cell);
            let x = grid.center(at);
            let known = if layer == 0 {
                nearest_crossing(grid, phi, cell, &x)
            } else {
                nearest_neighbour_point(grid, band, done, cell, &x)
            };
            let Some(known) = known else { return (x, f64::INFINITY) };
            let closest_point = predicted_closest_point(sampler, phi[cell], at, &x)
                .and_then(|start| newton_closest_point(sampler, grid.dx, &x, start, &known))
                .or_else(|| newton_closest_point(sampler, grid.dx, &x, known, &known))
                .unwrap_or(known);
            (closest_point, (closest_point - x).norm())
        });
        for (i, (point, d)) in range.zip(found) {
            closest[i] = point;
            distance[i] = d;
        }
    }
    band.cells
        .iter()
        .zip(distance)
        .map(|(&cell, d)| if phi[cell as usize] < 0.0 { -d.min(limit) } else { d.min(limit) })
        .collect()
}

/// Closest point of the cell at `x`, predicted from its old value and gradient; `None` unless they are nearly those of a distance.
fn predicted_closest_point<const D: usize>(
    sampler: &Sampler<'_, D>,
    here: f64,
    cell: [usize; D],
    x: &Vector<D>,
) -> Option<Vector<D>> {
    let slope = sampler.gradient(cell);
    let square = slope.norm_squared();
    ((square.sqrt() - 1.0).abs() < MAX_GRADIENT_DEVIATION).then(|| x - slope * (here / square))
}

/// |∇φ| at the nearest crossing of the interface with a lattice edge of a cell; 1 if there is none.
pub fn interface_gradient_norm<const D: usize>(
    grid: &Grid<D>,
    phi: &[f64],
    sampler: &Sampler<'_, D>,
    cell: usize,
) -> f64 {
    let x = grid.center(grid.lattice().coordinates(cell));
    nearest_crossing(grid, phi, cell, &x).map_or(1.0, |point| sampler.distance_with_gradient(&point).1.norm())
}

/// The nearest crossing of the interface with the lattice edges of a cell.
fn nearest_crossing<const D: usize>(
    grid: &Grid<D>,
    phi: &[f64],
    cell: usize,
    x: &Vector<D>,
) -> Option<Vector<D>> {
    let here = phi[cell];
    let mut best: Option<(f64, Vector<D>)> = None;
    for n in grid.lattice().neighbours(cell) {
        if (phi[n] < 0.0) != (here < 0.0) {
            let t = here / (here - phi[n]);
            let point = x + (grid.center(grid.lattice().coordinates(n)) - x) * t;
            if best.is_none_or(|(d, _)| t < d) {
                best = Some((t, point));
            }
        }
    }
    best.map(|(_, p)| p)
}

/// The nearest of the neighbours' closest points.
fn nearest_neighbour_point<const D: usize>(
    grid: &Grid<D>,
    band: &Band<D>,
    done: &[Vector<D>],
    cell: usize,
    x: &Vector<D>,
) -> Option<Vector<D>> {
    let mut best: Option<(f64, Vector<D>)> = None;
    for n in grid.lattice().neighbours(cell) {
        if let Some(point) = band.slot(n).and_then(|s| done.get(s)) {
            let d = (point - x).norm_squared();
            if best.is_none_or(|(b, _)| d < b) {
                best = Some((d, *point));
            }
        }
    }
    best.map(|(_, p)| p)
}

/// Newton iteration for the point of the zero set closest to `x`; `None` if it fails or ends clearly farther away than `known`.
fn newton_closest_point<const D: usize>(
    sampler: &Sampler<'_, D>,
    dx: f64,
    x: &Vector<D>,
    start: Vector<D>,
    known: &Vector<D>,
) -> Option<Vector<D>> {
    let mut point = start;
    for _ in 0..MAX_NEWTON_ITERATIONS {
        let (value, gradient) = sampler.distance_with_gradient(&point);
        let square = gradient.norm_squared();
        if square < 1e-4 {
            return None;
        }
        let toward = gradient * (-value / square);
        let offset = x - point;
        let along = offset - gradient * (offset.dot(&gradient) / square);
        let mut step = toward + along;
        let length = step.norm();
        if length > 0.5 * dx {
            step *= 0.5 * dx / length;
        }
        point += step;
        if length < NEWTON_TOLERANCE_CELLS * dx {
            let nearer = (point - x).norm_squared() <= (known - x).norm_squared() * 1.01 + (0.2 * dx).powi(2);
            return nearer.then_some(point);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::{BoundaryExtension, CellField, Tiles};

    fn ball<const D: usize>(n: usize) -> f64 {
        let grid = Grid::<D>::new([n; D], 1.0 / n as f64);
        let lattice = grid.lattice();
        let center = Vector::from_fn(|a, _| 0.5 + 0.01 * a as f64);
        let mut phi = CellField::new(grid, 0.0);
        for i in 0..lattice.len() {
            let d = (grid.center(lattice.coordinates(i)) - center).norm() - 0.3;
            phi.data[i] = d * (1.0 + 0.3 * d) * 1.5;
        }
        let inside = Tiles::all(grid).negative_runs(&phi.data);
        let mut band = Band::new(grid);
        band.rebuild(&phi.data, &inside, 7);
        let sampler = Sampler::cells(&grid, &phi.data, [[BoundaryExtension::Even; 2]; D]);
        let new = redistance(&grid, &band, 7, &phi.data, &sampler, 6.0 * grid.dx);
        let mut worst = 0.0f64;
        for (&cell, d) in band.cells.iter().zip(new) {
            let exact = (grid.center(lattice.coordinates(cell as usize)) - center).norm() - 0.3;
            if exact.abs() < 5.5 * grid.dx {
                worst = worst.max((d - exact).abs());
            }
        }
        worst
    }

    #[test]
    fn distance_of_a_ball_is_better_than_second_order() {
        let (coarse, fine) = (ball::<2>(32), ball::<2>(64));
        assert!(fine < 2e-3 / 64.0 && coarse / fine > 4.0, "{coarse:e} {fine:e}");
        let (coarse, fine) = (ball::<3>(24), ball::<3>(48));
        assert!(fine < 4e-3 / 48.0 && coarse / fine > 3.5, "{coarse:e} {fine:e}");
    }
}
