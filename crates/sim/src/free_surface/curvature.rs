//! Curvature of the surface on the cells of the band.
//!
//! Differences of the distance ([`level_set::curvature`]) tell it; where they cannot, near kinks, the energy gradient
//! `(∂A/∂φ) / (∂V/∂φ)` does ([`super::energy`]). That gradient alone, the design's choice, makes a ripple in the
//! lattice's period: a drop's frequency then depends by ±0.5 % on where in the lattice it lies, its damping by more
//! than all the viscous damping of Lamb's case. The differences do not see the lattice.
//!
//! The implicit biharmonic filter `F = (W + s² L W⁻¹ L)⁻¹ W`, with `W` the surface measure `∂V/∂φ`, `s² = c/k_c⁴ + b Δ⁴`
//! and `k_c = (4ρ/(γ h²))^⅓`, keeps capillary waves stable at steps `h` far beyond the explicit limit (`c`) and removes
//! noise between neighbours (`b`). A band-pass term damps the waves in between, those that the step does not resolve
//! (design, experiments part 3, scheme C). `F` leaves a constant as it is: a drop at rest stays at rest.

use super::curvature_filter::{Filtered, Graph};
use super::dual_cell::CutCube;
use super::extension::Ghost;
use crate::repairs::Repairs;
use meniscus_numerics::grid::{Band, CutCells, Grid, Sampler};
use meniscus_numerics::{Vector, level_set};
use rayon::prelude::*;

/// Strength of the filter `c`; stable from 0.4725 on, 2 as measured best.
const STRENGTH: f64 = 2.0;
/// Width `b` of the filter that is always there, in cells⁴: it slows a wave by `b k⁴/2`, and below 0.3 a flying drop of 8
/// cells a radius was torn by its noise (with cubic distances; not tried again with quintics).
const BASE: f64 = 0.5;
/// Width of the band that is always damped, in cells⁴: 1 left a flying drop noisy, at 16 one that hits a wall blew up. It
/// damps a wave by `ω²/2 · DAMPING_TIME · b k⁴` a unit of time.
const DAMPED: f64 = 4.0;
/// Time in which that damping acts, in √(ρΔ³/γ): short steps damp as much in the same time as a step of this length. Half
/// of it, as half of the width above, still kept a flying drop round to 1e-5; a quarter with twice the width did not. It adds
/// 2 % (2D) and 3 % (3D) to the viscous damping of Lamb's case (steps of half the explicit limit).
const DAMPING_TIME: f64 = 1.0;
/// Distance from solids, in cells, up to which the curvature is the energy's slope.
const NEAR: f64 = 3.0;
/// Distance from which on differences of φ tell it.
const FAR: f64 = 5.0;
/// Largest curvature, in 1/cells.
const STEEPEST: f64 = 2.0;

/// Curvature on the first cells of the band.
pub struct Curvature {
    /// Curvature, in 1/cells; 0 where unknown.
    pub kappa: Vec<f64>,
    /// Whether it is known.
    pub known: Vec<bool>,
    /// What was mended on the way: clamped curvatures, filters that did not converge.
    pub repairs: Repairs,
}

impl Curvature {
    /// Unknown everywhere.
    pub fn unknown() -> Self {
        Self { kappa: Vec::new(), known: Vec::new(), repairs: Repairs::default() }
    }
}

/// What the filter must know of the step, in cells.
pub struct FilterStep<const D: usize> {
    /// `γ h² / (ρ Δ³)`.
    pub capillary: f64,
    /// Normal and displacement during the step, per cell of the band, in cells.
    pub displacement: Vec<Displacement<D>>,
}

/// How the surface moves near a cell.
#[derive(Clone, Copy)]
pub struct Displacement<const D: usize> {
    /// Outward normal.
    pub normal: Vector<D>,
    /// Displacement in a step, in cells.
    pub path: Vector<D>,
}

/// What curvature must know of solids.
pub struct Beside<'a, const D: usize> {
    /// Where they are.
    pub solids: &'a CutCells<D>,
    /// The cells of the band within them.
    pub ghosts: &'a [Ghost<D>],
    /// The liquid's weight, in 1/cells² ([`super::energy`]).
    pub weight: Vector<D>,
}

/// Filtered curvature on the first `layers` layers of the band; `phi` samples the distance.
pub fn curvature<const D: usize>(
    grid: &Grid<D>,
    band: &Band<D>,
    layers: usize,
    phi: &Sampler<'_, D>,
    cubes: &[CutCube],
    beside: &Beside<'_, D>,
    step: &FilterStep<D>,
) -> Curvature {
    let count = band.first_layers(layers).end;
    // The slopes of energy and volume.
    let mut slopes = vec![[0.0; 2]; count];
    for cube in cubes {
        for k in 0..1 << D {
            if let Some(s) = band.slot(cube.corners[k] as usize).filter(|s| *s < count) {
                slopes[s][0] += cube.energy_slope[k];
                slopes[s][1] += cube.volume_slope[k];
            }
        }
    }
    let ghosts = beside.out_of_solids(grid, band, &mut slopes);
    let weight: Vec<f64> = slopes.iter().map(|s| s[1]).collect();
    let graph = Graph::new(grid, band, &weight);
    let lattice = grid.lattice();
    // The weight times the height of the surface that a cell stands for: what the energy's slope has too much.
    let high = |slot: usize| {
        if beside.weight.norm_squared() == 0.0 {
            return 0.0;
        }
        let at = lattice.coordinates(band.cells[slot] as usize);
        let foot = grid.center(at) / grid.dx
            - step.displacement[slot].normal * (phi.value(at.map(|i| i as isize)) / grid.dx);
        beside.weight.dot(&foot)
    };
    let near = beside.smoothed(grid, band, &slopes, high);
    let seen = |&slot: &u32| {
        let s = slot as usize;
        let cell = band.cells[s] as usize;
        let off = ((beside.solids.distance(cell) - NEAR) / (FAR - NEAR)).clamp(0.0, 1.0);
        let differences = || {
            let curvature = level_set::curvature(phi, grid.dx, lattice.coordinates(cell));
            curvature.map_or_else(|| slopes[s][0] / slopes[s][1], |k| k * grid.dx + high(s))
        };
        let differences = if off > 0.0 { off * differences() } else { 0.0 };
        let (kappa, cut) = if off < 1.0 { near[s] } else { (0.0, false) };
        (differences + if off < 1.0 { (1.0 - off) * kappa } else { 0.0 }, cut)
    };
    let (raw, clamped): (Vec<f64>, Vec<bool>) = graph.slots.par_iter().with_min_len(512).map(seen).unzip();
    let mut repairs = Repairs::default();
    let filtered = filtered(&graph, &raw, step, &mut repairs);
    let (mut kappa, mut known, mut cut) = (vec![0.0; count], vec![false; count], vec![false; count]);
    graph.slots.iter().zip(clamped).for_each(|(slot, clamped)| cut[*slot as usize] = clamped);
    for (&slot, value) in graph.slots.iter().zip(filtered) {
        kappa[slot as usize] = value;
        known[slot as usize] = true;
    }
    for (slot, outside) in ghosts {
        let seen = outside.iter().filter(|(s, _)| known[*s]);
        let (sum, all) = seen.fold((0.0, 0.0), |(sum, all), (s, w)| (sum + w * kappa[*s], all + w));
        if all > 0.0 {
            kappa[slot] = sum / all;
            known[slot] = true;
        }
    }
    for slot in (0..count).filter(|s| known[*s]) {
        let free = kappa[slot] - high(slot);
        kappa[slot] = free.clamp(-STEEPEST, STEEPEST);
        repairs.clamped_curvatures += u64::from(cut[slot] || kappa[slot] != free);
    }
    Curvature { kappa, known, repairs }
}

/// The curvature on the graph without what the step does not resolve; `repairs` takes solves that did not converge.
fn filtered<const D: usize>(
    graph: &Graph,
    raw: &[f64],
    step: &FilterStep<D>,
    repairs: &mut Repairs,
) -> Vec<f64> {
    let mut filter = |values: &[f64], width: f64| {
        let Filtered { values, residual, converged } = graph.filter(values, width);
        if !converged {
            repairs.filter_unconverged += 1;
            repairs.filter_residual = repairs.filter_residual.max(residual);
        }
        values
    };
    let mut filtered = filter(raw, width(step.capillary, BASE));
    if step.capillary > 0.0 {
        // F (r − F r), the waves that the step does not resolve; r is what the step adds to the curvature.
        let strength = width(step.capillary, DAMPED);
        let stretch = (DAMPING_TIME / step.capillary.sqrt()).max(1.0);
        let bend = bend(graph, &step.displacement, stretch);
        let rough: Vec<f64> = filter(&bend, strength).iter().zip(&bend).map(|(f, r)| r - f).collect();
        filtered.iter_mut().zip(filter(&rough, strength)).for_each(|(k, d)| *k += d);
    }
    filtered
}

/// A cell and others with weights, as places in the band.
type Spread = (usize, Vec<(usize, f64)>);

impl<const D: usize> Beside<'_, D> {
    /// Moves what cells within solids hold to those around the points where the surface comes out: φ within follows φ
    /// outside, and so does what it does to the energy. Gives back where it went.
    fn out_of_solids(&self, grid: &Grid<D>, band: &Band<D>, slopes: &mut [[f64; 2]]) -> Vec<Spread> {
        let lattice = grid.lattice();
        let mut spreads = Vec::new();
        for ghost in self.ghosts.iter().filter(|g| (g.slot as usize) < slopes.len()) {
            let place: [f64; D] =
                std::array::from_fn(|a| ghost.outside[a] / grid.dx + grid.margin[a][0] as f64 - 0.5);
            let mut to = Vec::with_capacity(1 << D);
            for k in 0..1usize << D {
                let mut weight = 1.0;
                let at = std::array::from_fn(|a| {
                    let (low, up) = (place[a].floor(), (k >> a & 1) as f64);
                    weight *= 1.0 - (place[a] - low - up).abs();
                    (low + up).clamp(0.0, lattice.extent[a] as f64 - 1.0) as usize
                });
                let cell = lattice.index(at);
                let slot = band.slot(cell).filter(|s| *s < slopes.len() && self.solids.distance(cell) >= 0.0);
                if let Some(s) = slot.filter(|_| weight > 0.0) {
                    to.push((s, weight));
                }
            }
            spreads.push((ghost.slot as usize, to));
        }
        for (from, to) in &spreads {
            let all: f64 = to.iter().map(|t| t.1).sum();
            if all > 0.0 {
                let here = std::mem::take(&mut slopes[*from]);
                to.iter().for_each(|(s, w)| (0..2).for_each(|i| slopes[*s][i] += w / all * here[i]));
            }
        }
        spreads
    }

    /// Curvature, in 1/cells, of the first cells of the band near solids as the energy's slope, smoothed: the lattice's noise
    /// goes, what the contact line pulls stays. The energy and the volume are smoothed alike, so that a constant curvature
    /// stays as it is (design, experiments parts 1 and 4). With each goes whether it was clamped.
    fn smoothed(
        &self,
        grid: &Grid<D>,
        band: &Band<D>,
        slopes: &[[f64; 2]],
        high: impl Fn(usize) -> f64,
    ) -> Vec<(f64, bool)> {
        let passes = if D == 2 { 2 } else { 4 };
        let reach = FAR + passes as f64;
        let near: Vec<u32> = (0..slopes.len() as u32)
            .filter(|s| self.solids.distance(band.cells[*s as usize] as usize) < reach)
            .collect();
        if near.is_empty() {
            return Vec::new();
        }
        let mut values = slopes.to_vec();
        for _ in 0..passes {
            let smooth = |&s: &u32| binomial(grid, band, &values, band.cells[s as usize] as usize);
            let new: Vec<[f64; 2]> = near.par_iter().with_min_len(256).map(smooth).collect();
            near.iter().zip(new).for_each(|(s, v)| values[*s as usize] = v);
        }
        let curvature = |(slot, [e, v]): (usize, [f64; 2])| {
            let high = high(slot);
            let free = if v > 1e-5 { e / v - high } else { 0.0 };
            let kappa = free.clamp(-STEEPEST, STEEPEST);
            (high + kappa, kappa != free)
        };
        values.into_iter().enumerate().map(curvature).collect()
    }
}

/// Weighted mean (1/4, 1/2, 1/4 along each axis) of what the cells around one hold; sides mirror.
fn binomial<const D: usize>(grid: &Grid<D>, band: &Band<D>, values: &[[f64; 2]], cell: usize) -> [f64; 2] {
    let lattice = grid.lattice();
    let at = lattice.coordinates(cell);
    let mut sum = [0.0; 2];
    for n in 0..3usize.pow(D as u32) {
        let mut weight = 1.0;
        let mut rest = n;
        let to = std::array::from_fn(|a| {
            let step = rest % 3;
            rest /= 3;
            weight *= if step == 1 { 0.5 } else { 0.25 };
            (at[a] + step).saturating_sub(1).min(lattice.extent[a] - 1)
        });
        if let Some(v) = band.slot(lattice.index(to)).and_then(|s| values.get(s)) {
            (0..2).for_each(|i| sum[i] += weight * v[i]);
        }
    }
    sum
}

/// What the displacement, times `stretch`, adds to the curvature, in 1/cells: `n · L u`, which is nothing for a body that
/// just flies. (`L (n · u)` is not: the lattice's noise of the Laplacian would then feed on the speed.)
fn bend<const D: usize>(graph: &Graph, displacement: &[Displacement<D>], stretch: f64) -> Vec<f64> {
    let mut bend = vec![0.0; graph.slots.len()];
    for a in 0..D {
        let path: Vec<f64> =
            graph.slots.iter().map(|&s| displacement[s as usize].path[a] * stretch).collect();
        for ((bend, &s), l) in bend.iter_mut().zip(&graph.slots).zip(graph.laplacian(&path)) {
            *bend += displacement[s as usize].normal[a] * l;
        }
    }
    bend
}

/// `s = √(c/k_c⁴ + b)` in cells².
fn width(capillary: f64, base: f64) -> f64 {
    (STRENGTH * (capillary / 4.0).powf(4.0 / 3.0) + base).sqrt()
}
