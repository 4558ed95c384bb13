//! A pressure system with a few more terms that reach across it: bodies that the pressure sets in motion.
//!
//! `A + Σ_k j_k j_kᵀ` stays symmetric positive definite, whatever the columns `j_k` are. A rigid body adds one column
//! for each of its degrees of freedom (D. Aanjaneya, "An efficient solver for two-way coupling rigid bodies with
//! incompressible flow", CGF 2018): that many eigenvalues lie apart and cost about as many iterations.

use super::operator::{LinearOperator, SolveError, SolveReport};
use super::pressure::PressureSolver;
use crate::grid::CellField;

/// Entries of a column: the cell (by its place in memory) and the value.
pub type Column = Vec<(u32, f64)>;

struct Coupled<'a, const D: usize> {
    system: &'a PressureSolver<D>,
    /// Entries of the solver's vectors, and values.
    columns: Vec<Vec<(usize, f64)>>,
}

impl<const D: usize> LinearOperator for Coupled<'_, D> {
    fn size(&self) -> usize {
        self.system.size()
    }

    fn apply(&self, x: &[f64], y: &mut [f64]) {
        self.apply_dot(x, y);
    }

    fn apply_dot(&self, x: &[f64], y: &mut [f64]) -> f64 {
        let mut dot = self.system.apply_dot(x, y);
        for column in &self.columns {
            let along: f64 = column.iter().map(|(i, v)| v * x[*i]).sum();
            column.iter().for_each(|(i, v)| y[*i] += v * along);
            dot += along * along;
        }
        dot
    }
}

impl<const D: usize> PressureSolver<D> {
    /// Solves `(A + Σ_k j_k j_kᵀ) x = rhs` as [`solve`](Self::solve) does without columns. Entries of a column in cells
    /// that are no unknowns are left out. A component without Dirichlet values floats only if no column feels a
    /// constant on it.
    ///
    /// # Errors
    /// As [`solve`](Self::solve).
    pub fn solve_coupled(
        &self,
        columns: &[Column],
        rhs: &CellField<D>,
        x: &mut CellField<D>,
        (tolerance, max_iterations): (f64, usize),
    ) -> Result<SolveReport, SolveError> {
        let lattice = rhs.grid.lattice();
        let translate = |column: &Column| {
            let entry =
                |&(cell, v): &(u32, f64)| self.entry(lattice.coordinates(cell as usize)).map(|e| (e, v));
            column.iter().filter_map(entry).collect()
        };
        let coupled = Coupled { system: self, columns: columns.iter().map(translate).collect() };
        let floats = self.floating_under(&coupled.columns);
        self.solve_system(&coupled, self.preconditioner(), &floats, (rhs, x), (tolerance, max_iterations))
    }
}
