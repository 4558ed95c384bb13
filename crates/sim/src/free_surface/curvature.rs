//! Curvature of the free surface on the cells of the band.
//!
//! Differences of the signed distance ([`level_set::curvatures`]) give it; near solids and kinks the energy
//! gradient `(∂E/∂φ) / (∂V/∂φ)` ([`super::energy`]) replaces them. The energy gradient alone has ripples of the
//! grid's period: a drop's frequency then varies by ±0.5 % with its position, and its damping by more than all
//! the viscous damping of Lamb's case.
//!
//! The implicit biharmonic filter `F = (W + s² L W⁻¹ L)⁻¹ W`, with the surface measure `W = −∂V/∂φ`,
//! `s² = c/k_c⁴ + b Δ⁴` and `k_c = (4ρ/(γ h t))^⅓`, keeps capillary waves stable at steps `h` with the impulse
//! time `t` far beyond the explicit limit (`c`) and removes noise between neighbours (`b`). A band-pass term
//! damps the waves in between, which the step does not resolve. `F` preserves constants: a drop at rest stays
//! at rest.

use super::curvature_filter::{FilterResult, Graph};
use super::dual_cell::DualCell;
use super::extension::GhostCell;
use crate::simulation::repairs::Repairs;
use meniscus_numerics::grid::{Band, CutCells, Grid, Sampler};
use meniscus_numerics::lanes::LANES;
use meniscus_numerics::{Vector, level_set, par};

/// Strength `c` of the filter. Long steps are stable from 0.4725 on with the filter alone, from 1.70 on with
/// the band-pass damping (book/theory/free-surface.md). The value 2 measured best.
const FILTER_STRENGTH: f64 = 2.0;
/// Width `b` of the filter that always acts, in cells⁴. It slows a wave by `b k⁴/2`; below 0.3 noise tore a flying drop of 8
/// cells a radius (with cubic distances; not tested with quintic ones).
const BASE_FILTER_CELLS4: f64 = 0.5;
/// Width of the band that is always damped, in cells⁴: 1 left a flying drop noisy, with 16 one that hits a wall
/// blew up. In steps shorter than [`DAMPING_TIME`] a wave with `b k⁴ ≪ 1` is damped by
/// `ω²/2 · DAMPING_TIME · b k⁴` per unit of time.
const DAMPING_FILTER_CELLS4: f64 = 4.0;
/// Time scale of this damping, in √(ρΔ³/γ): where the impulse time is the length of the step, shorter steps
/// damp about as much per time as a step of this length. Half of it still kept a flying drop round, a quarter
/// with twice the width did not. It adds 2 % (2D) and 3 % (3D) to the viscous damping of Lamb's case (steps of
/// half the explicit limit).
const DAMPING_TIME: f64 = 1.0;
/// Distance from solids, in cells, up to which the curvature is the energy gradient.
const CURVATURE_BLEND_START_CELLS: f64 = 3.0;
/// Distance from solids, in cells, beyond which it comes from differences of φ.
const CURVATURE_BLEND_END_CELLS: f64 = 5.0;
/// Largest curvature, in 1/cells.
const MAX_CURVATURE_PER_CELL: f64 = 2.0;

/// Curvature on the first cells of the band.
pub struct Curvature {
    /// Curvature, in 1/cells; 0 where unknown.
    pub kappa: Vec<f64>,
    /// Whether it is known.
    pub known: Vec<bool>,
    /// Clamped curvatures and filters that did not converge.
    pub repairs: Repairs,
}

impl Curvature {
    /// Unknown everywhere.
    pub fn unknown() -> Self {
        Self { kappa: Vec::new(), known: Vec::new(), repairs: Repairs::default() }
    }
}

/// What the filter needs of the step, in cells.
pub struct FilterStep<const D: usize> {
    /// `γ h t / (ρ Δ³)` with the length `h` of the step and the impulse time `t`.
    pub capillary_cfl_squared: f64,
    /// Normal and displacement during the step at each cell of the band.
    pub displacements: Vec<InterfaceDisplacement<D>>,
}

/// Motion of the interface near a cell.
#[derive(Clone, Copy)]
pub struct InterfaceDisplacement<const D: usize> {
    /// Outward normal.
    pub normal: Vector<D>,
    /// Displacement in a step, in cells.
    pub displacement_cells: Vector<D>,
}

/// What the curvature needs of the solids.
pub struct SolidContext<'a, const D: usize> {
    /// Their cut cells.
    pub cut_cells: &'a CutCells<D>,
    /// The cells of the band within them.
    pub ghosts: &'a [GhostCell<D>],
    /// The liquid's weight, in 1/cells² ([`super::energy`]).
    pub bond_vector: Vector<D>,
}

/// The interface on the first layers of the band.
pub struct InterfaceLayers<'a, const D: usize> {
    /// The grid.
    pub grid: &'a Grid<D>,
    /// The band.
    pub band: &'a Band<D>,
    /// Number of layers.
    pub layers: usize,
    /// The signed distance, m.
    pub phi: &'a Sampler<'a, D>,
    /// The dual cells, with the slopes of energy and volume.
    pub dual_cells: &'a [DualCell],
}

/// Computes the filtered curvature on these layers.
pub fn curvature<const D: usize>(
    interface: &InterfaceLayers<'_, D>,
    solids: &SolidContext<'_, D>,
    step: &FilterStep<D>,
) -> Curvature {
    let InterfaceLayers { grid, band, .. } = *interface;
    let mut slopes = interface.slopes();
    let ghosts = solids.move_slopes_out_of_solids(grid, band, &mut slopes);
    let weight: Vec<f64> = slopes.iter().map(|s| s[1]).collect();
    let graph = Graph::new(grid, band, &weight);
    let hydrostatic = |slot: usize| interface.hydrostatic(slot, &solids.bond_vector, step);
    let (raw, clamped) = raw_curvature(interface, solids, &graph, &slopes, hydrostatic);
    let mut repairs = Repairs::default();
    let filtered = filter_curvature(&graph, &raw, step, &mut repairs);
    let count = slopes.len();
    let (mut kappa, mut known, mut cut) = (vec![0.0; count], vec![false; count], vec![false; count]);
    graph.slots.iter().zip(clamped).for_each(|(slot, clamped)| cut[*slot as usize] = clamped);
    for (&slot, value) in graph.slots.iter().zip(filtered) {
        kappa[slot as usize] = value;
        known[slot as usize] = true;
    }
    for (slot, outside) in ghosts {
        let known_outside = outside.iter().filter(|(s, _)| known[*s]);
        let (sum, all) = known_outside.fold((0.0, 0.0), |(sum, all), (s, w)| (sum + w * kappa[*s], all + w));
        if all > 0.0 {
            kappa[slot] = sum / all;
            known[slot] = true;
        }
    }
    for slot in (0..count).filter(|s| known[*s]) {
        let free = kappa[slot] - hydrostatic(slot);
        kappa[slot] = free.clamp(-MAX_CURVATURE_PER_CELL, MAX_CURVATURE_PER_CELL);
        repairs.clamped_curvatures += u64::from(cut[slot] || kappa[slot] != free);
    }
    Curvature { kappa, known, repairs }
}

impl<const D: usize> InterfaceLayers<'_, D> {
    /// The slopes of energy and volume by φ in each cell of the layers.
    fn slopes(&self) -> Vec<[f64; 2]> {
        let count = self.band.first_layers(self.layers).end;
        let slots = |cube: &DualCell| -> [usize; 8] {
            std::array::from_fn(|k| match cube.corners[k] {
                u32::MAX => usize::MAX,
                cell => self.band.slot(cell as usize).unwrap_or(usize::MAX),
            })
        };
        let slots = par::map_slice(self.dual_cells, 256, slots);
        let mut slopes = vec![[0.0; 2]; count];
        for (cube, slots) in self.dual_cells.iter().zip(&slots) {
            for (k, slot) in slots.iter().enumerate().filter(|(_, slot)| **slot < count) {
                slopes[*slot][0] += cube.energy_slope[k];
                slopes[*slot][1] += cube.volume_slope[k];
            }
        }
        slopes
    }

    /// `w·x` at the surface point of a cell, with the liquid's weight `w` ([`SolidContext::bond_vector`]): the energy gradient contains it,
    /// the curvature does not.
    fn hydrostatic(&self, slot: usize, bond_vector: &Vector<D>, step: &FilterStep<D>) -> f64 {
        if bond_vector.norm_squared() == 0.0 {
            return 0.0;
        }
        let (grid, at) = (self.grid, self.grid.lattice().coordinates(self.band.cells[slot] as usize));
        let foot = grid.center(at) / grid.dx
            - step.displacements[slot].normal * (self.phi.value(at.map(|i| i as isize)) / grid.dx);
        bond_vector.dot(&foot)
    }
}

/// The curvature before the filter on the graph, with `hydrostatic` in it, and whether it was clamped. Near solids it is the smoothed
/// energy gradient, far from them it comes from differences of φ, and it is a blend in between.
fn raw_curvature<const D: usize>(
    interface: &InterfaceLayers<'_, D>,
    solids: &SolidContext<'_, D>,
    graph: &Graph,
    slopes: &[[f64; 2]],
    hydrostatic: impl Fn(usize) -> f64 + Sync,
) -> (Vec<f64>, Vec<bool>) {
    let InterfaceLayers { grid, band, phi, .. } = *interface;
    let near = solids.smoothed_energy_curvature(grid, band, slopes, &hydrostatic);
    let lattice = grid.lattice();
    let of_slots = |slots: &&[u32]| {
        let cells: [u32; LANES] = std::array::from_fn(|l| band.cells[slots[l.min(slots.len() - 1)] as usize]);
        let curvatures = level_set::curvatures(phi, grid.dx, cells.map(|c| lattice.coordinates(c as usize)));
        let mut values = [(0.0, false); LANES];
        for (l, &slot) in slots.iter().enumerate() {
            let s = slot as usize;
            let off = ((solids.cut_cells.distance_cells(cells[l] as usize) - CURVATURE_BLEND_START_CELLS)
                / (CURVATURE_BLEND_END_CELLS - CURVATURE_BLEND_START_CELLS))
                .clamp(0.0, 1.0);
            let (kappa, cut) = if off < 1.0 { near[s] } else { (0.0, false) };
            let differences = || {
                curvatures[l].map_or_else(|| slopes[s][0] / slopes[s][1], |k| k * grid.dx + hydrostatic(s))
            };
            let differences = if off > 0.0 { off * differences() } else { 0.0 };
            values[l] = (differences + if off < 1.0 { (1.0 - off) * kappa } else { 0.0 }, cut);
        }
        values
    };
    let packs: Vec<&[u32]> = graph.slots.chunks(LANES).collect();
    let values = par::map_slice(&packs, 64, of_slots);
    values.into_iter().flatten().take(graph.slots.len()).unzip()
}

/// The filtered curvature on the graph; `repairs` records solves that did not converge.
fn filter_curvature<const D: usize>(
    graph: &Graph,
    raw: &[f64],
    step: &FilterStep<D>,
    repairs: &mut Repairs,
) -> Vec<f64> {
    // Whatever is added to the curvature needs only the absolute accuracy of the curvature itself.
    let scale = graph.norm_squared(raw);
    let mut filter = |values: &[f64], width: f64| {
        let scale = scale.max(graph.norm_squared(values));
        let FilterResult { values, residual, converged } = graph.filter(values, width, scale);
        if !converged {
            repairs.filter_unconverged += 1;
            repairs.filter_residual = repairs.filter_residual.max(residual);
        }
        values
    };
    let mut filtered = filter(raw, filter_width(step.capillary_cfl_squared, BASE_FILTER_CELLS4));
    if step.capillary_cfl_squared > 0.0 {
        // F (r − F r), with the change r of the curvature in the step, holds the waves that the step does not resolve.
        let strength = filter_width(step.capillary_cfl_squared, DAMPING_FILTER_CELLS4);
        let stretch = (DAMPING_TIME / step.capillary_cfl_squared.sqrt()).max(1.0);
        let rate = curvature_rate(graph, &step.displacements, stretch);
        let rough: Vec<f64> = filter(&rate, strength).iter().zip(&rate).map(|(f, r)| r - f).collect();
        filtered.iter_mut().zip(filter(&rough, strength)).for_each(|(k, d)| *k += d);
    }
    filtered
}

/// A cell and others with weights, as slots of the band.
type SlotWeights = (usize, Vec<(usize, f64)>);

impl<const D: usize> SolidContext<'_, D> {
    /// Moves the slopes of cells within solids to the cells around their exit points, as φ within follows φ outside. Returns the
    /// weights of those cells.
    fn move_slopes_out_of_solids(
        &self,
        grid: &Grid<D>,
        band: &Band<D>,
        slopes: &mut [[f64; 2]],
    ) -> Vec<SlotWeights> {
        let lattice = grid.lattice();
        let mut spreads = Vec::new();
        for ghost in self.ghosts.iter().filter(|g| (g.slot as usize) < slopes.len()) {
            let place: [f64; D] =
                std::array::from_fn(|a| ghost.exit_point[a] / grid.dx + grid.margin_cells[a][0] as f64 - 0.5);
            let mut to = Vec::with_capacity(1 << D);
            for k in 0..1usize << D {
                let mut weight = 1.0;
                let at = std::array::from_fn(|a| {
                    let (low, up) = (place[a].floor(), (k >> a & 1) as f64);
                    weight *= 1.0 - (place[a] - low - up).abs();
                    (low + up).clamp(0.0, lattice.extent[a] as f64 - 1.0) as usize
                });
                let cell = lattice.index(at);
                let slot = band
                    .slot(cell)
                    .filter(|s| *s < slopes.len() && self.cut_cells.distance_cells(cell) >= 0.0);
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

    /// Curvature, in 1/cells, of the first cells of the band near solids: the energy gradient, smoothed to remove grid noise but
    /// not the contribution of the contact line. Slopes of energy and volume are smoothed alike, which preserves a constant
    /// curvature. The flag tells whether it was clamped.
    fn smoothed_energy_curvature(
        &self,
        grid: &Grid<D>,
        band: &Band<D>,
        slopes: &[[f64; 2]],
        hydrostatic: impl Fn(usize) -> f64,
    ) -> Vec<(f64, bool)> {
        let passes = if D == 2 { 2 } else { 4 };
        let reach = CURVATURE_BLEND_END_CELLS + passes as f64;
        let near: Vec<u32> = (0..slopes.len() as u32)
            .filter(|s| self.cut_cells.distance_cells(band.cells[*s as usize] as usize) < reach)
            .collect();
        if near.is_empty() {
            return Vec::new();
        }
        let mut values = slopes.to_vec();
        for _ in 0..passes {
            let smooth = |&s: &u32| binomial(grid, band, &values, band.cells[s as usize] as usize);
            let new = par::map_slice(&near, 256, smooth);
            near.iter().zip(new).for_each(|(s, v)| values[*s as usize] = v);
        }
        let curvature = |(slot, [e, v]): (usize, [f64; 2])| {
            let hydrostatic = hydrostatic(slot);
            let free = if v > 1e-5 { e / v - hydrostatic } else { 0.0 };
            let kappa = free.clamp(-MAX_CURVATURE_PER_CELL, MAX_CURVATURE_PER_CELL);
            (hydrostatic + kappa, kappa != free)
        };
        values.into_iter().enumerate().map(curvature).collect()
    }
}

/// Weighted mean (1/4, 1/2, 1/4 along each axis) of the values around a cell; sides mirror.
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

/// Change of the curvature, in 1/cells, by the displacement times `stretch`, to the leading order in the
/// wavenumber: `n · W⁻¹ L u`, which is zero for a translation. (`W⁻¹ L (n · u)` is not: the grid noise of the
/// Laplacian would grow with the speed.)
fn curvature_rate<const D: usize>(
    graph: &Graph,
    displacement: &[InterfaceDisplacement<D>],
    stretch: f64,
) -> Vec<f64> {
    let mut bend = vec![0.0; graph.slots.len()];
    for a in 0..D {
        let path: Vec<f64> =
            graph.slots.iter().map(|&s| displacement[s as usize].displacement_cells[a] * stretch).collect();
        for ((bend, &s), l) in bend.iter_mut().zip(&graph.slots).zip(graph.laplacian(&path)) {
            *bend += displacement[s as usize].normal[a] * l;
        }
    }
    bend
}

/// `s = √(c/k_c⁴ + b)` in cells².
fn filter_width(capillary: f64, base: f64) -> f64 {
    (FILTER_STRENGTH * (capillary / 4.0).powf(4.0 / 3.0) + base).sqrt()
}
