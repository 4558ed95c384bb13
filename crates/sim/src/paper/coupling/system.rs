//! The systems of Eq. 11 and 15.
//!
//! ```text
//! ⎡ −V/ρ ∇²    V∇·W       ⎤ ⎡p̂⎤   ⎡ −V∇·u* ⎤
//! ⎣ −Wᵀ V∇    −(M̃ − Δt D) ⎦ ⎣v⎦ = ⎣ −b     ⎦
//! ```
//!
//! with the unknown velocities `v` of solids (Eq. 11), or of solids and line (Eq. 15), and the right-hand sides `b` of their momentum rows.
//! `∇²` and `∇·u*` leave out the faces that move with `v` (E20). The pressure is zero in air cells and in solid ones, which have no
//! unknowns, so that the matrix is symmetric. It is indefinite.
//!
//! The rows are divided by their units: lengths are in cells, masses in those of a cell of liquid, and the unknown of the pressure is
//! `q = p̂/(ρ Δx)`; all unknowns and right-hand sides are in m/s.

use super::momentum::MomentumRows;
use super::sparse_matrix::{Entry, SparseMatrix};
use crate::paper::fluid::cells::{CellType, CellTypes, Face, FaceType};
use meniscus_numerics::grid::FaceField;

/// No unknown.
const NONE: u32 = u32::MAX;

/// A coupled system.
#[derive(Clone, Debug)]
pub struct CoupledSystem {
    /// The symmetric matrix: first the rows of liquid cells, then those of the velocities.
    pub matrix: SparseMatrix,
    /// The right-hand side, m/s.
    pub right: Vec<f64>,
    /// The liquid cells, in order.
    pub cells: Vec<u32>,
    /// For every cell of the grid its row, or [`NONE`].
    slots: Vec<u32>,
}

impl CoupledSystem {
    /// The system of a velocity `u*` (m/s) and momentum rows, for a liquid of a density (kg/m³).
    pub fn new<const D: usize>(
        types: &CellTypes<D>,
        density: f64,
        velocity: &FaceField<D>,
        rows: &MomentumRows,
    ) -> Self {
        let cells = types.cells(CellType::Liquid);
        let mut slots = vec![NONE; types.grid().lattice().len()];
        cells.iter().enumerate().for_each(|(i, c)| slots[*c as usize] = i as u32);
        let (count, unknowns) = (cells.len(), rows.mass.rows());
        let cell_mass = density * types.grid().cell_volume();
        let mut system =
            Self { matrix: SparseMatrix::new(0, []), right: vec![0.0; count + unknowns], cells, slots };
        let mut entries = Vec::new();
        for row in 0..count {
            system.add_cell(row, types, velocity, rows, &mut entries);
        }
        let given = |j: u32| rows.prescribed[j as usize];
        for (j, k, mass) in rows.mass.entries().filter(|(j, ..)| given(*j).is_none()) {
            match given(k) {
                Some(value) => system.right[count + j as usize] += mass / cell_mass * value,
                None => entries.push((count as u32 + j, count as u32 + k, -mass / cell_mass)),
            }
        }
        for (j, momentum) in rows.momentum.iter().enumerate() {
            let right = &mut system.right[count + j];
            match rows.prescribed[j] {
                Some(value) => {
                    *right = -value;
                    entries.push(((count + j) as u32, (count + j) as u32, -1.0));
                }
                None => *right -= momentum / cell_mass,
            }
        }
        system.matrix = SparseMatrix::of_entries([count + unknowns; 2], entries);
        system
    }

    /// Adds a source of volume in every liquid cell, 1/s, for cells of a size, m: the divergence that the velocity then has.
    pub fn add_source(&mut self, source: f64, dx: f64) {
        self.right[..self.cells.len()].iter_mut().for_each(|right| *right += source * dx);
    }

    /// Adds the row of a cell, and the entries of its column in the momentum rows.
    fn add_cell<const D: usize>(
        &mut self,
        row: usize,
        types: &CellTypes<D>,
        velocity: &FaceField<D>,
        rows: &MomentumRows,
        entries: &mut Vec<(u32, u32, f64)>,
    ) {
        let (cell, count) = (self.cells[row] as usize, self.cells.len() as u32);
        let (own, mut diagonal) = (row as u32, 0.0);
        for (axis, side) in (0..D).flat_map(|axis| [(axis, 0), (axis, 1)]) {
            let face = types.faces(cell, axis)[side];
            let sign = if side == 0 { -1.0 } else { 1.0 };
            match FaceOwner::of(types, rows, face) {
                FaceOwner::Unknowns(map) => {
                    for (j, weight) in map {
                        let entry = sign * weight;
                        match rows.prescribed[*j as usize] {
                            Some(value) => self.right[row] -= entry * value,
                            None => {
                                entries.extend([(own, count + j, entry), (count + j, own, entry)]);
                            }
                        }
                    }
                }
                FaceOwner::Pressure => {
                    diagonal += 1.0;
                    self.right[row] -= sign * velocity.axes[axis][face.index];
                    let other = types.sides(face)[side].map_or(NONE, |c| self.slots[c]);
                    if other != NONE {
                        entries.push((own, other, -1.0));
                    }
                }
                FaceOwner::None => {}
            }
        }
        entries.push((own, own, diagonal));
    }

    /// Sets the velocity of the liquid's faces from a solution, m/s: `u* − ∇p̂/ρ`, and `W v` on faces that move with unknowns. Faces of
    /// closed sides, and of solids without unknowns, are at rest. Returns the velocities `v`, m/s.
    pub fn apply<'s, const D: usize>(
        &self,
        types: &CellTypes<D>,
        rows: &MomentumRows,
        solution: &'s [f64],
        velocity: &mut FaceField<D>,
    ) -> &'s [f64] {
        let (pressure, unknowns) = solution.split_at(self.cells.len());
        let at = |cell: Option<usize>| match cell.map_or(NONE, |c| self.slots[c]) {
            NONE => 0.0,
            slot => pressure[slot as usize],
        };
        for (axis, values) in velocity.axes.iter_mut().enumerate() {
            for (index, value) in values.iter_mut().enumerate() {
                let face = Face { axis, index };
                let sides = types.sides(face);
                if sides.iter().all(|c| c.map_or(NONE, |c| self.slots[c]) == NONE) {
                    continue;
                }
                *value = match FaceOwner::of(types, rows, face) {
                    FaceOwner::Unknowns(map) => map.iter().map(|(j, w)| w * unknowns[*j as usize]).sum(),
                    FaceOwner::Pressure => *value - (at(sides[1]) - at(sides[0])),
                    FaceOwner::None => 0.0,
                };
            }
        }
        unknowns
    }

    /// Pressure times the length of the step, `p̂`, of each liquid cell, Pa s, from a solution.
    pub fn pressure_impulses(&self, solution: &[f64], density: f64, dx: f64) -> Vec<f64> {
        solution[..self.cells.len()].iter().map(|q| q * density * dx).collect()
    }
}

/// What gives a face of a liquid cell its velocity.
enum FaceOwner<'a> {
    /// Unknown velocities, by these weights.
    Unknowns(&'a [Entry]),
    /// The gradient of the pressure.
    Pressure,
    /// Nothing: it is at rest.
    None,
}

impl<'a> FaceOwner<'a> {
    fn of<const D: usize>(types: &CellTypes<D>, rows: &'a MomentumRows, face: Face) -> Self {
        match types.face(face) {
            FaceType::ClosedSide => return Self::None,
            FaceType::Liquid => return Self::Pressure,
            _ => {}
        }
        match rows.owned.binary_search(&face) {
            Ok(row) => Self::Unknowns(rows.map.row(row)),
            Err(_) if types.face(face) == FaceType::LiquidSolid => Self::None,
            Err(_) => Self::Pressure,
        }
    }
}
