//! The implicit biharmonic filter `F = (W + s² L W⁻¹ L)⁻¹ W` ([`super::curvature`]) on the cells of the free surface.

use meniscus_numerics::grid::{Band, Grid};
use meniscus_numerics::par;

/// Surface measure, in cells², below which a cell is left out.
const MIN_SURFACE_MEASURE_CELLS2: f64 = 0.004;
/// Tolerance of the filter's solve: residual relative to the norm that the caller gives.
const TOLERANCE: f64 = 1e-8;
/// Maximum number of its iterations.
const MAX_ITERATIONS: usize = 500;
/// Number of cells that one task sums in sequence.
const CHUNK: usize = 2048;

/// The cells with free surface, and the surface Laplacian `L` on them.
pub struct Graph {
    /// Slots in the band.
    pub slots: Vec<u32>,
    /// Surface measure `w`.
    measure: Vec<f64>,
    /// Neighbours (the cell itself where there is none) and the coupling ½(w_i + w_j).
    links: Vec<[(u32, f32); 6]>,
}

type Complex = [f64; 2];

/// Result of the filter.
pub struct FilterResult {
    /// Filtered values.
    pub values: Vec<f64>,
    /// Final residual of the solve, relative to the norm that the caller gave.
    pub residual: f64,
    /// Whether the solve converged within the maximum number of iterations.
    pub converged: bool,
}

impl Graph {
    /// The graph of the band's first cells with this surface measure (cells²).
    pub fn new<const D: usize>(grid: &Grid<D>, band: &Band<D>, measure: &[f64]) -> Self {
        let lattice = grid.lattice();
        let mut place = vec![u32::MAX; measure.len()];
        let slots: Vec<u32> =
            (0..measure.len() as u32).filter(|&s| measure[s as usize] > MIN_SURFACE_MEASURE_CELLS2).collect();
        slots.iter().enumerate().for_each(|(i, &s)| place[s as usize] = i as u32);
        let weight: Vec<f64> = slots.iter().map(|&s| measure[s as usize]).collect();
        let links = par::map(slots.len(), 512, |i| {
            let mut links = [(i as u32, 0.0); 6];
            for (k, n) in lattice.neighbours(band.cells[slots[i] as usize] as usize).enumerate() {
                let other = band.slot(n).and_then(|s| place.get(s)).filter(|p| **p != u32::MAX);
                if let Some(&j) = other {
                    links[k] = (j, (0.5 * (weight[i] + weight[j as usize])) as f32);
                }
            }
            links
        });
        Self { slots, measure: weight, links }
    }

    /// `W⁻¹ L v` in 1/cells².
    pub fn laplacian(&self, v: &[f64]) -> Vec<f64> {
        let row = |i: usize| -> f64 {
            self.links[i].iter().map(|&(j, c)| c as f64 * (v[i] - v[j as usize])).sum::<f64>()
                / self.measure[i]
        };
        par::map(v.len(), CHUNK, row)
    }

    /// `|W v|²`.
    pub fn norm_squared(&self, v: &[f64]) -> f64 {
        v.iter().zip(&self.measure).map(|(v, w)| (v * w).powi(2)).sum()
    }

    /// `F v = (W + s² L W⁻¹ L)⁻¹ W v = Re (W + i s L)⁻¹ W v` by conjugate gradients for complex symmetric matrices, started from `v`. The
    /// residual is relative to the root of `scale`, usually [`Self::norm_squared`] of `v`.
    pub fn filter(&self, v: &[f64], s: f64, scale: f64) -> FilterResult {
        let n = v.len();
        let degree = |i: usize| self.links[i].iter().map(|l| l.1 as f64).sum::<f64>();
        let diagonal: Vec<Complex> = par::map(n, CHUNK, |i| [self.measure[i], s * degree(i)]);
        let mut x: Vec<Complex> = par::map(n, CHUNK, |i| [v[i], 0.0]);
        let mut q = vec![[0.0; 2]; n];
        self.multiply(s, &x, &mut q);
        let mut r: Vec<Complex> = par::map(n, CHUNK, |i| [self.measure[i] * v[i] - q[i][0], -q[i][1]]);
        let mut p: Vec<Complex> = par::map(n, CHUNK, |i| over(r[i], diagonal[i]));
        let start = par::sums(n, |i| with_square(times(r[i], p[i]), r[i]));
        let (mut rho, mut square) = ([start[0], start[1]], start[2]);
        for _ in 0..MAX_ITERATIONS {
            if square <= TOLERANCE * TOLERANCE * scale {
                break;
            }
            let product = self.multiply(s, &p, &mut q);
            let alpha = over(rho, product);
            let sums = update(&mut x, &mut r, &p, &q, &diagonal, alpha);
            let next = [sums[0], sums[1]];
            let beta = over(next, rho);
            (rho, square) = (next, sums[2]);
            par::map_chunks_mut([&mut p], CHUNK, |range, [p]| {
                for (at, p) in range.zip(p) {
                    let (z, t) = (over(r[at], diagonal[at]), times(beta, *p));
                    *p = [z[0] + t[0], z[1] + t[1]];
                }
            });
        }
        let converged = square <= TOLERANCE * TOLERANCE * scale;
        let residual = if square == 0.0 { 0.0 } else { (square / scale).sqrt() };
        FilterResult { values: x.into_iter().map(|x| x[0]).collect(), residual, converged }
    }

    /// Computes `y = (W + i s L) x`; returns `Σ x y`.
    fn multiply(&self, s: f64, x: &[Complex], y: &mut [Complex]) -> Complex {
        let sums: Vec<Complex> = par::map_chunks_mut([y], CHUNK, |range, [part]| {
            let mut sum = [0.0; 2];
            for (at, y) in range.zip(part) {
                let here = x[at];
                let mut bend = [0.0; 2];
                for &(j, link) in &self.links[at] {
                    let there = x[j as usize];
                    bend[0] += link as f64 * (here[0] - there[0]);
                    bend[1] += link as f64 * (here[1] - there[1]);
                }
                let w = self.measure[at];
                *y = [w * here[0] - s * bend[1], w * here[1] + s * bend[0]];
                let t = times(here, *y);
                sum = [sum[0] + t[0], sum[1] + t[1]];
            }
            sum
        });
        sums.iter().fold([0.0; 2], |a, b| [a[0] + b[0], a[1] + b[1]])
    }
}

/// Computes `x += α p`, `r −= α q`; returns `Σ r r/d` (complex) and `Σ |r|²`.
fn update(
    x: &mut [Complex],
    r: &mut [Complex],
    p: &[Complex],
    q: &[Complex],
    diagonal: &[Complex],
    alpha: Complex,
) -> [f64; 3] {
    let sums: Vec<[f64; 3]> = par::map_chunks_mut([x, r], CHUNK, |range, [x, r]| {
        let mut sum = [0.0; 3];
        for (i, at) in range.enumerate() {
            let (dx, dr) = (times(alpha, p[at]), times(alpha, q[at]));
            x[i] = [x[i][0] + dx[0], x[i][1] + dx[1]];
            r[i] = [r[i][0] - dr[0], r[i][1] - dr[1]];
            let terms = with_square(times(r[i], over(r[i], diagonal[at])), r[i]);
            (0..3).for_each(|k| sum[k] += terms[k]);
        }
        sum
    });
    sums.iter().fold([0.0; 3], |a, b| [a[0] + b[0], a[1] + b[1], a[2] + b[2]])
}

fn with_square(a: Complex, r: Complex) -> [f64; 3] {
    [a[0], a[1], r[0] * r[0] + r[1] * r[1]]
}

fn times(a: Complex, b: Complex) -> Complex {
    [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]]
}

fn over(a: Complex, b: Complex) -> Complex {
    let square = b[0] * b[0] + b[1] * b[1];
    if square == 0.0 { [0.0; 2] } else { times(a, [b[0] / square, -b[1] / square]) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ring of cells with uneven weights.
    fn ring(n: usize) -> Graph {
        let measure: Vec<f64> = (0..n).map(|i| 0.1 + 0.09 * (1.7 * i as f64).sin()).collect();
        let links = (0..n)
            .map(|i| {
                let mut links = [(i as u32, 0.0); 6];
                for (k, j) in [(i + 1) % n, (i + n - 1) % n].into_iter().enumerate() {
                    links[k] = (j as u32, (0.5 * (measure[i] + measure[j])) as f32);
                }
                links
            })
            .collect();
        Graph { slots: (0..n as u32).collect(), measure, links }
    }

    fn filtered(graph: &Graph, v: &[f64], s: f64) -> FilterResult {
        graph.filter(v, s, graph.norm_squared(v))
    }

    #[test]
    fn a_constant_passes_and_the_force_is_conserved() {
        let graph = ring(5000);
        let constant = filtered(&graph, &vec![0.7; 5000], 3.0).values;
        assert!(constant.iter().all(|v| (v - 0.7).abs() < 1e-12));
        let noise: Vec<f64> = (0..5000).map(|i| (i as f64 * 12.9898).sin()).collect();
        let force = |v: &[f64]| v.iter().zip(&graph.measure).map(|(v, w)| v * w).sum::<f64>();
        let smooth = filtered(&graph, &noise, 3.0);
        assert!(smooth.converged && !filtered(&graph, &noise, 1e9).converged);
        let smooth = smooth.values;
        let size = noise.iter().zip(&graph.measure).map(|(v, w)| (v * w).abs()).sum::<f64>();
        assert!((force(&smooth) - force(&noise)).abs() < 1e-6 * size);
    }

    #[test]
    fn the_complex_solve_is_the_biharmonic_filter() {
        // W v' + s² L W⁻¹ L v' = W v
        let graph = ring(300);
        let v: Vec<f64> = (0..300).map(|i| (i as f64 * 0.9).sin()).collect();
        let (s, out) = (2.0, filtered(&graph, &v, 2.0).values);
        let twice = graph.laplacian(&graph.laplacian(&out));
        for i in 0..300 {
            assert!((out[i] + s * s * twice[i] - v[i]).abs() < 1e-5, "{i}");
        }
    }
}
