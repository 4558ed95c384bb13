//! Viscous systems on grids of twice the spacing, for multigrid.
//!
//! A coarse system has the form of the finest one, with `ν h/Δ²` of its own spacing. The liquid fraction of a coarse control volume is the
//! mean over the finer ones within, those on its boundary by the part that lies inside; so is the mass of a coarse face. Rigid motions of a
//! coarse grid dissipate nothing, as those of the finest. Grids coarsen until the mass keeps the eigenvalues away from zero.

use super::cells::{CellList, tensor_product};
use super::operator::{CELLS_PER_TASK, Cell, ViscousOperator};
use meniscus_numerics::{par, rotation_planes};

/// Largest `ν h/Δ²` of the coarsest grid. A system up to it needs no coarser one: a polynomial alone takes no longer.
pub const COARSEST_STIFFNESS: f64 = 3.0;

/// Weights of the finer control volumes in a coarse one along axes with three of them: one in its middle and two on its boundary.
const CENTERED: &[f32] = &[0.25, 0.5, 0.25];
/// The same along axes with two of them.
const PAIRED: &[f32] = &[0.0, 0.5, 0.5];

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

/// Adds up the coefficients of a system within coarse control volumes.
struct Coarsening<'a, const D: usize> {
    fine: &'a ViscousSystem<D>,
    cells: &'a CellList<D>,
    /// Shares of the finer control volumes in those around the cell, around its lower edge in each plane, around its lower faces.
    around_cell: Vec<f32>,
    around_edges: [Vec<f32>; D],
    around_faces: [Vec<f32>; D],
}

impl<const D: usize> ViscousSystem<D> {
    fn coarsened(&self) -> Self {
        let (stiffness, cells) = (self.stiffness / 4.0, self.cells.coarsened());
        let coarsening = Coarsening::new(self, &cells);
        let count = cells.count();
        let is_unknown = par::map(count, CELLS_PER_TASK, |i| coarsening.unknown_faces(i));
        let coefficients = par::map(count, CELLS_PER_TASK, |i| coarsening.cell(&is_unknown, i, stiffness));
        let full: Vec<bool> = coefficients.iter().map(|cell| cell.is_full(stiffness)).collect();
        let beside_full = |cell: &Cell<D>| cell.next.iter().flatten().all(|n| full[*n as usize]);
        let deep = par::map(count, CELLS_PER_TASK, |i| full[i] && beside_full(&coefficients[i]));
        let operator = ViscousOperator::new(&deep, |i| coefficients[i].next, |i| coefficients[i], stiffness);
        Self { cells, operator, stiffness }
    }
}

impl<'a, const D: usize> Coarsening<'a, D> {
    fn new(fine: &'a ViscousSystem<D>, cells: &'a CellList<D>) -> Self {
        let around = |centered: &[usize]| {
            let along = |a: usize| if centered.contains(&a) { CENTERED } else { PAIRED };
            tensor_product(std::array::from_fn::<_, D, _>(along))
        };
        let mut around_edges = std::array::from_fn(|_| Vec::new());
        let planes = rotation_planes::<D>().iter().zip(&mut around_edges);
        planes.for_each(|(&(p, q, _), edges)| *edges = around(&[p, q]));
        let around_faces = std::array::from_fn(|a| around(&[a]));
        Self { fine, cells, around_cell: around(&[]), around_edges, around_faces }
    }

    /// Calls `f` with the finer cells in a control volume of the coarse cell at `at`, and their shares.
    fn for_each_within(&self, at: [usize; D], shares: &[f32], mut f: impl FnMut(&Cell<D>, f64)) {
        self.fine.cells.for_each_slot(at.map(|x| 2 * x as isize - 1), 3, |k, slot| {
            if shares[k] > 0.0 && slot != 0 {
                f(self.fine.operator.cell(slot), f64::from(shares[k]));
            }
        });
    }

    fn mean(&self, at: [usize; D], shares: &[f32], value: impl Fn(&Cell<D>) -> f64) -> f64 {
        let mut sum = 0.0;
        self.for_each_within(at, shares, |cell, share| sum += share * value(cell));
        sum
    }

    /// Whether the lower faces of a coarse cell are unknowns: one of the faces that they correct is.
    fn unknown_faces(&self, i: usize) -> [bool; D] {
        let at = self.cells.coordinates(i);
        std::array::from_fn(|a| {
            let mut any = false;
            self.for_each_within(at, &self.around_faces[a], |cell, _| any |= cell.is_unknown[a]);
            any && i > 0 && !self.cells.is_on_closed_side(a, at[a])
        })
    }

    /// The coefficients of a coarse cell.
    fn cell(&self, is_unknown: &[[bool; D]], i: usize, stiffness: f64) -> Cell<D> {
        if i == 0 {
            return Cell::empty();
        }
        let at = self.cells.coordinates(i);
        let next = self.cells.neighbours(self.cells.list[i] as usize, at);
        // A term needs the values of all its faces; on closed sides they are zero.
        let has_value = |slot: usize, a: usize, at: usize| {
            (slot != 0 && is_unknown[slot][a]) || self.cells.is_on_closed_side(a, at)
        };
        let along = |a: usize| has_value(i, a, at[a]) && has_value(next[a][1] as usize, a, at[a] + 1);
        let mut normal = 0.0;
        if (0..D).all(along) {
            normal = self.mean(at, &self.around_cell, |c| c.normal / (2.0 * self.fine.stiffness));
        }
        let across = |a: usize, b: usize| {
            let below = next[b][0] as usize;
            below != 0 && has_value(i, a, at[a]) && has_value(below, a, at[a])
        };
        let mut shear = [0.0; D];
        for (k, &(p, q, _)) in rotation_planes::<D>().iter().enumerate() {
            if across(p, q) && across(q, p) {
                shear[k] =
                    stiffness * self.mean(at, &self.around_edges[k], |c| c.shear[k] / self.fine.stiffness);
            }
        }
        let is_unknown = is_unknown[i];
        let mass = |a: usize| self.mean(at, &self.around_faces[a], |c| c.face_mass[a]);
        let face_mass = std::array::from_fn(|a| if is_unknown[a] { mass(a) } else { 0.0 });
        Cell { next, normal: 2.0 * stiffness * normal, shear, face_mass, is_unknown }
    }
}
