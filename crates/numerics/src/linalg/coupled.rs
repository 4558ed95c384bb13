//! A pressure system with bodies that the pressure sets in motion.
//!
//! Together they add `F B⁻¹ Fᵀ`, where `F` are the flows into cells by the bodies' degrees of freedom and `B` is their own matrix,
//! which is known by its solve only: the system stays symmetric positive definite, whatever `F` is. Of a rigid body that moves as many
//! eigenvalues apart as it has degrees of freedom, and costs about as many iterations (D. Aanjaneya, "An efficient solver for two-way
//! coupling rigid bodies with incompressible flow", CGF 2018). Of a body that deforms the multigrid sees what each cell by itself would
//! give way, as if the wall were porous (design, numerics §1): the caller adds that to the Dirichlet coefficients, and here it is taken
//! off again.

use super::operator::{LinearOperator, SolveError, SolveReport};
use super::pressure::PressureSolver;
use crate::grid::CellField;

/// Entries of a column: the cell (by its place in memory) and the value.
pub type Column = Vec<(u32, f64)>;

/// A function that overwrites a vector with another.
pub type Solve<'a> = dyn Fn(&mut [f64]) + Sync + 'a;

/// Bodies that move under the pressure.
pub struct Compliance<'a> {
    /// Number of their degrees of freedom.
    pub freedoms: usize,
    /// `F`: for each cell at their surfaces the degrees of freedom that flow into it, and how much.
    pub flows: Vec<(u32, Vec<(u32, f64)>)>,
    /// For each of these cells what the system's Dirichlet coefficient has already of `F B⁻¹ Fᵀ`.
    pub porous: Vec<f64>,
    /// `x → B⁻¹ x` for the degrees of freedom in `flows`, where `x` is 0 for all others.
    pub solve: Box<Solve<'a>>,
    /// Columns whose sums over a component of the liquid tell whether the bodies determine its mean pressure: they do not where each sum
    /// is zero.
    pub feelers: Vec<Column>,
}

/// Degrees of freedom of bodies from which on another thread solves for them while the liquid's part is worked out: to wake one takes
/// some 10 µs.
const APART: usize = 1 << 14;

struct Coupled<'a, const D: usize> {
    system: &'a PressureSolver<D>,
    body: &'a Compliance<'a>,
    /// For each of the bodies' cells the entry of the solver's vectors.
    entries: Vec<Option<usize>>,
}

impl<const D: usize> LinearOperator for Coupled<'_, D> {
    fn size(&self) -> usize {
        self.system.size()
    }

    fn apply(&self, x: &[f64], y: &mut [f64]) {
        self.apply_dot(x, y);
    }

    fn apply_dot(&self, x: &[f64], y: &mut [f64]) -> f64 {
        let (body, entries) = (self.body, &self.entries);
        let give = || {
            let mut push = vec![0.0; body.freedoms];
            for (entry, (_, flow)) in entries.iter().zip(&body.flows) {
                let Some(entry) = entry else { continue };
                flow.iter().for_each(|(k, v)| push[*k as usize] += v * x[*entry]);
            }
            (body.solve)(&mut push);
            push
        };
        let (mut dot, push) = if body.freedoms < APART {
            (self.system.apply_dot(x, y), give())
        } else {
            rayon::join(|| self.system.apply_dot(x, y), give)
        };
        for ((entry, (_, flow)), porous) in entries.iter().zip(&body.flows).zip(&body.porous) {
            let Some(entry) = *entry else { continue };
            let more = flow.iter().map(|(k, v)| v * push[*k as usize]).sum::<f64>() - porous * x[entry];
            y[entry] += more;
            dot += more * x[entry];
        }
        dot
    }
}

impl<const D: usize> PressureSolver<D> {
    /// Solves `(A + F B⁻¹ Fᵀ − porous) x = rhs` as [`solve`](Self::solve) does without bodies. What they say of cells that are no
    /// unknowns is left out. A component without Dirichlet values floats only if no body feels a constant on it.
    ///
    /// # Errors
    /// As [`solve`](Self::solve).
    pub fn solve_coupled(
        &self,
        bodies: Option<&Compliance<'_>>,
        rhs: &CellField<D>,
        x: &mut CellField<D>,
        limits: (f64, usize),
    ) -> Result<SolveReport, SolveError> {
        let Some(body) = bodies else { return self.solve(rhs, x, limits.0, limits.1) };
        let lattice = rhs.grid.lattice();
        let entry = |cell: u32| self.entry(lattice.coordinates(cell as usize));
        let translate = |column: &Column| {
            column.iter().filter_map(|&(cell, v)| entry(cell).map(|e| (e, v))).collect::<Vec<_>>()
        };
        let feelers: Vec<_> = body.feelers.iter().map(translate).collect();
        let floats = self.floating_under(&feelers);
        let entries = body.flows.iter().map(|(cell, _)| entry(*cell)).collect();
        let coupled = Coupled { system: self, body, entries };
        self.solve_system(&coupled, self.preconditioner(), &floats, (rhs, x), limits)
    }
}
