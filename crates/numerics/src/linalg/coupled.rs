//! A pressure system with a few more terms that reach across it: bodies that the pressure sets in motion.
//!
//! `A + Σ_k j_k j_kᵀ` stays symmetric positive definite, whatever the columns `j_k` are. A rigid body adds one column
//! for each of its degrees of freedom (D. Aanjaneya, "An efficient solver for two-way coupling rigid bodies with
//! incompressible flow", CGF 2018): that many eigenvalues lie apart and cost about as many iterations.
//!
//! A body that deforms adds `F B⁻¹ Fᵀ` with its own matrix `B`, which is known by its solve only. The multigrid sees of it
//! what each cell by itself would give way, as if the wall were porous (design, numerics §1): the caller adds that to
//! the Dirichlet coefficients, and here it is taken off again.

use super::operator::{LinearOperator, SolveError, SolveReport};
use super::pressure::PressureSolver;
use crate::grid::CellField;
use rayon::prelude::*;

/// Entries of a column: the cell (by its place in memory) and the value.
pub type Column = Vec<(u32, f64)>;

/// A function that overwrites a vector with another.
pub type Solve<'a> = dyn Fn(&mut [f64]) + Sync + 'a;

/// A body that deforms under the pressure.
pub struct Compliance<'a> {
    /// Number of its degrees of freedom.
    pub freedoms: usize,
    /// `F`: for each cell at its surface the degrees of freedom that flow into it, and how much.
    pub flows: Vec<(u32, Vec<(u32, f64)>)>,
    /// For each of these cells what the system's Dirichlet coefficient has already of `F B⁻¹ Fᵀ`; where that is nothing a
    /// component is not held by it.
    pub porous: Vec<f64>,
    /// `x → B⁻¹ x` for the degrees of freedom in `flows`, where `x` is 0 for all others.
    pub solve: Box<Solve<'a>>,
}

/// What the pressure sets in motion.
#[derive(Default)]
pub struct Bodies<'a> {
    /// The degrees of freedom of rigid bodies.
    pub columns: Vec<Column>,
    /// Those that deform.
    pub soft: Vec<Compliance<'a>>,
}

struct Coupled<'a, const D: usize> {
    system: &'a PressureSolver<D>,
    /// Entries of the solver's vectors, and values.
    columns: Vec<Vec<(usize, f64)>>,
    /// The bodies that deform, and for each of their cells the entry.
    soft: Vec<(&'a Compliance<'a>, Vec<Option<usize>>)>,
}

impl<const D: usize> LinearOperator for Coupled<'_, D> {
    fn size(&self) -> usize {
        self.system.size()
    }

    fn apply(&self, x: &[f64], y: &mut [f64]) {
        self.apply_dot(x, y);
    }

    fn apply_dot(&self, x: &[f64], y: &mut [f64]) -> f64 {
        let given = |(body, entries): &(&Compliance<'_>, Vec<Option<usize>>)| {
            let mut push = vec![0.0; body.freedoms];
            for (entry, (_, flow)) in entries.iter().zip(&body.flows) {
                let Some(entry) = entry else { continue };
                flow.iter().for_each(|(k, v)| push[*k as usize] += v * x[*entry]);
            }
            (body.solve)(&mut push);
            push
        };
        // A body's solve is serial: the bodies give way side by side, and with them the liquid.
        let (mut dot, given): (f64, Vec<Vec<f64>>) =
            rayon::join(|| self.system.apply_dot(x, y), || self.soft.par_iter().map(given).collect());
        for column in &self.columns {
            let along: f64 = column.iter().map(|(i, v)| v * x[*i]).sum();
            column.iter().for_each(|(i, v)| y[*i] += v * along);
            dot += along * along;
        }
        for ((body, entries), push) in self.soft.iter().zip(&given) {
            for ((entry, (_, flow)), porous) in entries.iter().zip(&body.flows).zip(&body.porous) {
                let Some(entry) = *entry else { continue };
                let more = flow.iter().map(|(k, v)| v * push[*k as usize]).sum::<f64>() - porous * x[entry];
                y[entry] += more;
                dot += more * x[entry];
            }
        }
        dot
    }
}

impl<const D: usize> PressureSolver<D> {
    /// Solves `(A + Σ_k j_k j_kᵀ + F B⁻¹ Fᵀ − porous) x = rhs` as [`solve`](Self::solve) does without bodies. What they say
    /// of cells that are no unknowns is left out. A component without Dirichlet values floats only if no body feels a
    /// constant on it.
    ///
    /// # Errors
    /// As [`solve`](Self::solve).
    pub fn solve_coupled(
        &self,
        bodies: &Bodies<'_>,
        rhs: &CellField<D>,
        x: &mut CellField<D>,
        (tolerance, max_iterations): (f64, usize),
    ) -> Result<SolveReport, SolveError> {
        let lattice = rhs.grid.lattice();
        let entry = |cell: u32| self.entry(lattice.coordinates(cell as usize));
        let translate = |column: &Column| {
            column.iter().filter_map(|&(cell, v)| entry(cell).map(|e| (e, v))).collect::<Vec<_>>()
        };
        let columns: Vec<_> = bodies.columns.iter().map(translate).collect();
        let soft: Vec<_> = bodies
            .soft
            .iter()
            .map(|body| (body, body.flows.iter().map(|(cell, _)| entry(*cell)).collect::<Vec<_>>()))
            .collect();
        let mut feelers = columns.clone();
        feelers.extend(soft.iter().map(|(body, entries)| {
            let felt = entries.iter().zip(&body.porous).filter(|(_, porous)| **porous > 0.0);
            felt.filter_map(|(entry, _)| entry.map(|e| (e, 1.0))).collect()
        }));
        let floats = self.floating_under(&feelers);
        let coupled = Coupled { system: self, columns, soft };
        self.solve_system(&coupled, self.preconditioner(), &floats, (rhs, x), (tolerance, max_iterations))
    }
}
