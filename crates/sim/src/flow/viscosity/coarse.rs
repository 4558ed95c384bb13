//! Viscous systems on grids of twice the spacing, for multigrid.
//!
//! A coarse system has the form of the finest one, with `ν h/Δ²` of its own spacing. The liquid fraction of a coarse control volume is the
//! mean over the finer ones within, those on its boundary by the part that lies inside; so is the mass of a coarse face. Rigid motions of a
//! coarse grid dissipate nothing, as those of the finest. Grids coarsen until the mass outweighs the viscosity.

use super::cells::{CellList, Taps};
use super::operator::{CELLS_PER_TASK, Cell, ViscousOperator};
use meniscus_numerics::rotation_planes;
use rayon::prelude::*;

/// Largest `ν h/Δ²` of the coarsest grid, and of systems that need none. Below, conjugate gradients with the diagonal take less time.
pub const COARSEST_STIFFNESS: f64 = 0.5;

/// Weights of the finer control volumes within one, along the axes for which one lies in its middle and two on its boundary.
const CENTERED: &[f32] = &[0.25, 0.5, 0.25];
/// The same along the axes for which there are two.
const PAIRED: &[f32] = &[0.5, 0.5];

/// The operator of listed cells.
pub struct ViscousSystem<const D: usize> {
    /// The cells.
    pub cells: CellList<D>,
    /// Their operator.
    pub operator: ViscousOperator<D>,
    /// `ν h/Δ²`.
    pub stiffness: f64,
}

/// Adds coarser systems to the finest one.
pub fn add_coarse_systems<const D: usize>(systems: &mut Vec<ViscousSystem<D>>) {
    while let Some(fine) = systems.last().filter(|last| last.stiffness > COARSEST_STIFFNESS) {
        let coarse = fine.coarsened();
        systems.push(coarse);
    }
}

impl<const D: usize> ViscousSystem<D> {
    fn coarsened(&self) -> Self {
        let stiffness = self.stiffness / 4.0;
        let cells = self.cells.coarsened();
        let of_cells = (0..cells.count()).into_par_iter().with_min_len(CELLS_PER_TASK);
        let is_unknown: Vec<[bool; D]> = of_cells.clone().map(|i| self.unknown_faces(&cells, i)).collect();
        let coefficients = of_cells.clone().map(|i| self.coarse_cell(&cells, &is_unknown, i, stiffness));
        let coefficients: Vec<Cell<D>> = coefficients.collect();
        let full: Vec<bool> = coefficients.iter().map(|cell| cell.is_full(stiffness)).collect();
        let beside_full = |cell: &Cell<D>| cell.next.iter().flatten().all(|n| full[*n as usize]);
        let deep: Vec<bool> = of_cells.map(|i| full[i] && beside_full(&coefficients[i])).collect();
        let operator = ViscousOperator::new(&deep, |i| coefficients[i].next, |i| coefficients[i], stiffness);
        Self { cells, operator, stiffness }
    }

    /// Whether the lower faces of a coarse cell are unknowns: one of the faces that they correct is.
    fn unknown_faces(&self, coarse: &CellList<D>, i: usize) -> [bool; D] {
        let at = coarse.coordinates(i);
        std::array::from_fn(|a| {
            let mut any = false;
            let is_unknown = |slot: usize| self.operator.cell(slot).is_unknown[a];
            self.cells.for_each_tap(&control_volume(at, &[a]), |slot, _| any |= is_unknown(slot));
            any && i > 0 && !coarse.is_on_closed_side(a, at[a])
        })
    }

    /// The coefficients of a coarse cell.
    fn coarse_cell(
        &self,
        coarse: &CellList<D>,
        is_unknown: &[[bool; D]],
        i: usize,
        stiffness: f64,
    ) -> Cell<D> {
        if i == 0 {
            return Cell::empty();
        }
        let at = coarse.coordinates(i);
        let mean = |centered: &[usize], value: &dyn Fn(&Cell<D>) -> f64| {
            let mut sum = 0.0;
            self.cells.for_each_tap(&control_volume(at, centered), |slot, w| {
                sum += f64::from(w) * value(self.operator.cell(slot));
            });
            sum
        };
        let next = coarse.neighbours(coarse.list[i] as usize, at);
        // A term needs the values of all its faces; on closed sides they are zero.
        let has_value = |slot: usize, a: usize, at: usize| {
            (slot != 0 && is_unknown[slot][a]) || coarse.is_on_closed_side(a, at)
        };
        let along = |a: usize| has_value(i, a, at[a]) && has_value(next[a][1] as usize, a, at[a] + 1);
        let normal = if (0..D).all(along) { mean(&[], &|c| c.normal / (2.0 * self.stiffness)) } else { 0.0 };
        let across = |a: usize, b: usize| {
            let below = next[b][0] as usize;
            below != 0 && has_value(i, a, at[a]) && has_value(below, a, at[a])
        };
        let mut shear = [0.0; D];
        for (k, &(p, q, _)) in rotation_planes::<D>().iter().enumerate() {
            if across(p, q) && across(q, p) {
                shear[k] = stiffness * mean(&[p, q], &|c| c.shear[k] / self.stiffness);
            }
        }
        let mass = |a: usize| if is_unknown[i][a] { mean(&[a], &|c| c.face_mass[a]) } else { 0.0 };
        let face_mass = std::array::from_fn(mass);
        Cell { next, normal: 2.0 * stiffness * normal, shear, face_mass, is_unknown: is_unknown[i] }
    }
}

/// The finer control volumes within the one at `at` that is centred on a grid plane normal to the axes `centered`.
fn control_volume<const D: usize>(at: [usize; D], centered: &[usize]) -> [Taps; D] {
    std::array::from_fn(|a| {
        let first = 2 * at[a] as isize;
        if centered.contains(&a) {
            Taps { first: first - 1, weights: CENTERED }
        } else {
            Taps { first, weights: PAIRED }
        }
    })
}
