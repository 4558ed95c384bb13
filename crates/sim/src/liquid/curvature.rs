//! Curvature of the surface on the cells of the band.
//!
//! Differences of the distance ([`level_set::curvature`]) tell it; where they cannot, near kinks, the energy gradient
//! `(∂A/∂φ) / (∂V/∂φ)` does ([`super::surface`]). That gradient alone, the design's choice, makes a ripple in the
//! lattice's period: a drop's frequency then depends by ±0.5 % on where in the lattice it lies, its damping by more
//! than all the viscous damping of Lamb's case. The differences do not see the lattice.
//!
//! The implicit biharmonic filter `F = (W + s² L W⁻¹ L)⁻¹ W`, with `W` the surface measure `∂V/∂φ`, `s² = c/k_c⁴ + b Δ⁴`
//! and `k_c = (4ρ/(γ h²))^⅓`, keeps capillary waves stable at steps `h` far beyond the explicit limit (`c`) and removes
//! noise between neighbours (`b`). A band-pass term damps the waves in between, those that the step does not resolve
//! (design, experiments part 3, scheme C). `F` leaves a constant as it is: a drop at rest stays at rest.

use super::filter::Graph;
use super::cube::CutCube;
use meniscus_numerics::Vector;
use meniscus_numerics::grid::{Band, CutCells, Grid, Sampler};
use meniscus_numerics::level_set;
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

/// Filtered curvature on the first `layers` layers of the band; `phi` samples the distance.
pub fn curvature<const D: usize>(
    grid: &Grid<D>,
    band: &Band<D>,
    layers: usize,
    phi: &Sampler<'_, D>,
    cubes: &[CutCube],
    solids: &CutCells<D>,
    step: &FilterStep<D>,
) -> Curvature {
    let count = band.first_layers(layers).end;
    let (mut area, mut weight) = (vec![0.0; count], vec![0.0; count]);
    for cube in cubes {
        for k in 0..1 << D {
            if let Some(s) = band.slot(cube.corners[k] as usize).filter(|s| *s < count) {
                area[s] += cube.energy_slope[k];
                weight[s] += cube.volume_slope[k];
            }
        }
    }
    let graph = Graph::new(grid, band, &weight);
    let lattice = grid.lattice();
    let beside = beside_solids(grid, band, solids, &area, &weight);
    let seen = |&slot: &u32| {
        let s = slot as usize;
        let cell = band.cells[s] as usize;
        let off = ((solids.distance(cell) - NEAR) / (FAR - NEAR)).clamp(0.0, 1.0);
        let differences = || {
            let curvature = level_set::curvature(phi, grid.dx, lattice.coordinates(cell));
            curvature.map_or_else(|| area[s] / weight[s], |k| k * grid.dx)
        };
        off * if off > 0.0 { differences() } else { 0.0 } + (1.0 - off) * if off < 1.0 { beside[s] } else { 0.0 }
    };
    let raw: Vec<f64> = graph.slots.par_iter().with_min_len(512).map(seen).collect();
    let mut filtered = graph.filter(&raw, width(step.capillary, BASE));
    if step.capillary > 0.0 {
        // F (r − F r), the waves that the step does not resolve; r is what the step adds to the curvature.
        let strength = width(step.capillary, DAMPED);
        let stretch = (DAMPING_TIME / step.capillary.sqrt()).max(1.0);
        let bend = bend(&graph, &step.displacement, stretch);
        let rough: Vec<f64> = graph.filter(&bend, strength).iter().zip(&bend).map(|(f, r)| r - f).collect();
        filtered.iter_mut().zip(graph.filter(&rough, strength)).for_each(|(k, d)| *k += d);
    }
    let (mut kappa, mut known) = (vec![0.0; count], vec![false; count]);
    for (&slot, value) in graph.slots.iter().zip(filtered) {
        kappa[slot as usize] = value.clamp(-STEEPEST, STEEPEST);
        known[slot as usize] = true;
    }
    Curvature { kappa, known }
}

/// Curvature, in 1/cells, of the first cells of the band near solids as the energy's slope, smoothed: the lattice's noise
/// goes, what the contact line pulls stays. The energy and the volume are smoothed alike, so that a constant curvature stays
/// as it is (design, experiments parts 1 and 4).
fn beside_solids<const D: usize>(
    grid: &Grid<D>,
    band: &Band<D>,
    solids: &CutCells<D>,
    energy: &[f64],
    volume: &[f64],
) -> Vec<f64> {
    let passes = if D == 2 { 2 } else { 4 };
    let reach = FAR + passes as f64;
    let near: Vec<u32> = (0..energy.len() as u32)
        .filter(|s| solids.distance(band.cells[*s as usize] as usize) < reach)
        .collect();
    if near.is_empty() {
        return Vec::new();
    }
    let mut values: Vec<[f64; 2]> = energy.iter().zip(volume).map(|(e, v)| [*e, *v]).collect();
    for _ in 0..passes {
        let smooth = |&s: &u32| binomial(grid, band, &values, band.cells[s as usize] as usize);
        let new: Vec<[f64; 2]> = near.par_iter().with_min_len(256).map(smooth).collect();
        near.iter().zip(new).for_each(|(s, v)| values[*s as usize] = v);
    }
    let curvature = |[e, v]: [f64; 2]| if v > 1e-5 { (e / v).clamp(-STEEPEST, STEEPEST) } else { 0.0 };
    let mut out: Vec<f64> = values.iter().map(|v| curvature(*v)).collect();
    // Within a solid there is too little surface to tell: what is outside goes on.
    let lifted: Vec<(u32, f64)> = near
        .iter()
        .filter_map(|&s| {
            let cell = band.cells[s as usize] as usize;
            let above = band.slot(outward(grid, solids, cell)?).filter(|s| *s < values.len())?;
            (values[above][1] > 1e-5).then(|| (s, out[above]))
        })
        .collect();
    lifted.into_iter().for_each(|(s, v)| out[s as usize] = v);
    out
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

/// The neighbour of a cell with its centre in a solid that lies farthest out.
fn outward<const D: usize>(grid: &Grid<D>, solids: &CutCells<D>, cell: usize) -> Option<usize> {
    if solids.distance(cell) >= 0.0 {
        return None;
    }
    let far = |a: &usize, b: &usize| solids.distance(*a).total_cmp(&solids.distance(*b));
    grid.lattice().neighbours(cell).max_by(far)
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
