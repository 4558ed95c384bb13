//! Curvature of the surface on the cells of the band.
//!
//! Raw: `κ = (∂A/∂φ) / (∂V/∂φ)` per cell ([`super::surface`]), noisy from one cell to the next. The implicit
//! biharmonic filter `F = (W + (c/k_c⁴ + b Δ⁴) L W⁻¹ L)⁻¹ W`, with `W` the surface measure `∂V/∂φ` and
//! `k_c = (4ρ/(γ h²))^⅓`, removes that noise (`b`) and keeps capillary waves stable at steps `h` far beyond the
//! explicit limit (`c`); a band-pass term damps those that the step does not resolve (design, experiments part 3,
//! scheme C). `F` leaves a constant as it is and conserves `Σ w κ`: a drop at rest stays at rest. Binomial smoothing
//! before the filter, as in the design's prototypes, was measured to cost frequency and bring nothing.

use super::surface::CutCube;
use meniscus_numerics::grid::{Band, Grid};
use meniscus_numerics::par;
use rayon::prelude::*;

/// Strength of the filter `c`; stable from 0.4725 on, 2 as measured best.
const STRENGTH: f64 = 2.0;
/// Width of the filter that is always there, in cells⁴: it removes the lattice's noise.
const BASE: f64 = 4.0;
/// Cells whose surface measure is below this take no part.
const THIN: f64 = 0.004;
/// Cells that are worth a thread's while.
const GRAIN: usize = 2048;
/// No neighbour inside the band.
const NONE: u32 = u32::MAX;

/// Curvature and surface measure on the first cells of the band.
pub struct Curvature {
    /// Curvature, in 1/cells; 0 where unknown.
    pub kappa: Vec<f64>,
    /// Whether it is known.
    pub known: Vec<bool>,
    /// Share of the interface cells whose curvature had to be cut.
    pub clipped: f64,
}

/// The first layers of the band as a graph.
struct Graph<const D: usize> {
    neighbours: Vec<[u32; 6]>,
}

/// What the filter must know of the step, in cells.
pub struct FilterStep {
    /// `γ h² / (ρ Δ³)`.
    pub capillary: f64,
    /// Displacement along the normal during the step, per cell of the band, in cells.
    pub displacement: Vec<f64>,
}

/// Filtered curvature on the first `layers` layers of the band.
pub fn curvature<const D: usize>(
    grid: &Grid<D>,
    band: &Band<D>,
    layers: usize,
    cubes: &[CutCube],
    step: &FilterStep,
) -> Curvature {
    let count = band.first_layers(layers).end;
    let graph = Graph::<D>::new(grid, band, count);
    let (mut area, mut weight) = (vec![0.0; count], vec![0.0; count]);
    for cube in cubes {
        for k in 0..1 << D {
            if let Some(s) = band.slot(cube.corners[k] as usize).filter(|s| *s < count) {
                area[s] += cube.area_slope[k];
                weight[s] += cube.volume_slope[k];
            }
        }
    }
    let known: Vec<bool> = weight.iter().map(|w| *w > THIN).collect();
    let raw: Vec<f64> = (0..count).map(|i| if known[i] { area[i] / weight[i] } else { 0.0 }).collect();
    weight.iter_mut().zip(&known).for_each(|(w, k)| *w = if *k { *w } else { 0.0 });
    let filter = Filter { graph: &graph, weight: &weight, strength: filter_strength(step.capillary) };
    let mut kappa = filter.apply(&raw);
    if step.capillary > 0.0 {
        // r − F r, then F of it: only waves that the step does not resolve.
        let bend: Vec<f64> = filter.laplacian(&step.displacement[..count]);
        let r: Vec<f64> = (0..count).map(|i| if known[i] { bend[i] / weight[i] } else { 0.0 }).collect();
        let smooth = filter.apply(&r);
        let rough: Vec<f64> = r.iter().zip(&smooth).map(|(r, s)| r - s).collect();
        kappa.iter_mut().zip(filter.apply(&rough)).for_each(|(k, d)| *k += d);
    }
    let edge = band.first_layers(1).end;
    let mut clipped = 0;
    for (i, k) in kappa.iter_mut().enumerate() {
        if k.abs() > 2.0 {
            *k = k.clamp(-2.0, 2.0);
            clipped += (i < edge) as usize;
        }
    }
    Curvature { kappa, known, clipped: clipped as f64 / edge.max(1) as f64 }
}

/// `√(c/k_c⁴ + base)` in cells².
fn filter_strength(capillary: f64) -> f64 {
    (STRENGTH * (capillary / 4.0).powf(4.0 / 3.0) + BASE).sqrt()
}

impl<const D: usize> Graph<D> {
    fn new(grid: &Grid<D>, band: &Band<D>, count: usize) -> Self {
        let lattice = grid.lattice();
        let neighbours = band.cells[..count]
            .par_iter()
            .enumerate()
            .map(|(i, &cell)| {
                let at = lattice.coordinates(cell as usize);
                std::array::from_fn(|n| {
                    let a = n / 2;
                    if a >= D {
                        return NONE;
                    }
                    let at_wall = if n % 2 == 0 { at[a] == 0 } else { at[a] + 1 == lattice.extent[a] };
                    if at_wall {
                        return i as u32;
                    }
                    let other = if n % 2 == 0 { cell as usize - lattice.stride[a] } else { cell as usize + lattice.stride[a] };
                    band.slot(other).filter(|s| *s < count).map_or(NONE, |s| s as u32)
                })
            })
            .collect();
        Self { neighbours }
    }
}

/// `W + i s L` and its use.
struct Filter<'a, const D: usize> {
    graph: &'a Graph<D>,
    weight: &'a [f64],
    strength: f64,
}

type Complex = (f64, f64);

fn times(a: Complex, b: Complex) -> Complex {
    (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0)
}

fn over(a: Complex, b: Complex) -> Complex {
    let square = b.0 * b.0 + b.1 * b.1;
    if square == 0.0 { (0.0, 0.0) } else { times(a, (b.0 / square, -b.1 / square)) }
}

impl<const D: usize> Filter<'_, D> {
    /// `L v`, the weighted surface Laplacian (positive) in 1/cells².
    fn laplacian(&self, v: &[f64]) -> Vec<f64> {
        (0..v.len()).into_par_iter().with_min_len(GRAIN).map(|i| self.row(i, |j| v[j] - v[i])).collect()
    }

    /// −Σ_j ½(w_i + w_j) difference(j) over the neighbours that take part.
    fn row(&self, i: usize, difference: impl Fn(usize) -> f64) -> f64 {
        let w = self.weight[i];
        if w == 0.0 {
            return 0.0;
        }
        let mut sum = 0.0;
        for &n in &self.graph.neighbours[i][..2 * D] {
            if n != NONE && self.weight[n as usize] > 0.0 {
                sum -= 0.5 * (w + self.weight[n as usize]) * difference(n as usize);
            }
        }
        sum
    }

    /// `F v = Re (W + i s L)⁻¹ W v` by conjugate gradients for complex symmetric matrices, from the start `v`.
    fn apply(&self, v: &[f64]) -> Vec<f64> {
        let n = v.len();
        let s = self.strength;
        let multiply = |x: &[Complex]| -> Vec<Complex> {
            (0..n)
                .into_par_iter()
                .with_min_len(GRAIN)
                .map(|i| {
                    let re = self.row(i, |j| x[j].0 - x[i].0);
                    let im = self.row(i, |j| x[j].1 - x[i].1);
                    (self.weight[i] * x[i].0 - s * im, self.weight[i] * x[i].1 + s * re)
                })
                .collect()
        };
        let diagonal: Vec<Complex> =
            (0..n).into_par_iter().with_min_len(GRAIN).map(|i| (self.weight[i], s * self.row(i, |_| -1.0))).collect();
        let precondition = |r: &[Complex]| -> Vec<Complex> {
            r.par_iter().with_min_len(GRAIN).zip(&diagonal).map(|(r, d)| over(*r, *d)).collect()
        };
        let dot = |a: &[Complex], b: &[Complex]| -> Complex {
            let [re, im] = par::sums(n, |i| times(a[i], b[i]).into());
            (re, im)
        };
        let norm = |a: &[Complex]| par::sum(n, |i| a[i].0 * a[i].0 + a[i].1 * a[i].1).sqrt();
        let mut x: Vec<Complex> = v.iter().map(|v| (*v, 0.0)).collect();
        let product = multiply(&x);
        let mut r: Vec<Complex> =
            (0..n).map(|i| (self.weight[i] * v[i] - product[i].0, -product[i].1)).collect();
        let scale = par::sum(n, |i| (self.weight[i] * v[i]).powi(2)).sqrt();
        let mut z = precondition(&r);
        let mut p = z.clone();
        let mut rho = dot(&r, &z);
        for _ in 0..400 {
            if norm(&r) <= 1e-8 * scale {
                break;
            }
            let q = multiply(&p);
            let alpha = over(rho, dot(&p, &q));
            let step = |a: &mut [Complex], b: &[Complex], c: Complex| {
                a.par_iter_mut().with_min_len(GRAIN).zip(b).for_each(|(a, b)| {
                    let t = times(c, *b);
                    *a = (a.0 + t.0, a.1 + t.1);
                })
            };
            step(&mut x, &p, alpha);
            step(&mut r, &q, (-alpha.0, -alpha.1));
            z = precondition(&r);
            let next = dot(&r, &z);
            let beta = over(next, rho);
            rho = next;
            p.par_iter_mut().with_min_len(GRAIN).zip(&z).for_each(|(p, z)| {
                let t = times(beta, *p);
                *p = (z.0 + t.0, z.1 + t.1);
            });
        }
        x.into_iter().map(|x| x.0).collect()
    }
}
