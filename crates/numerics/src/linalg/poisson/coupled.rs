//! A pressure system coupled with bodies that move under the pressure.
//!
//! The bodies add `F B⁻¹ Fᵀ` to the system. `F` holds the flow into the cells per degree of freedom of the bodies, and
//! `B` is the bodies' own matrix, known by its solve only. The system stays symmetric positive definite for any `F`. A
//! rigid body separates as many eigenvalues as it has degrees of freedom, and costs about as many iterations (D.
//! Aanjaneya, "An efficient solver for two-way coupling rigid bodies with incompressible flow", CGF 2018). For a
//! deformable body the multigrid uses the compliance of each cell by itself, as if the wall were porous: the caller adds
//! this lumped compliance to the Dirichlet coefficients, and it is subtracted here.

use super::schwarz::{Schwarz, SubdomainInverse};
use super::solver::{PressureSolver, RelatedSystem, UnconvergedIterate};
use crate::grid::{CellField, Lattice};
use crate::linalg::operator::{LinearOperator, SolveError, SolveLimits, SolveReport};
use nalgebra::DMatrix;
use std::collections::BTreeMap;
use std::sync::{Mutex, OnceLock};

/// Entries of a column: the index of the cell, and the value.
pub type SparseColumn = Vec<(u32, f64)>;

/// A linear solve that overwrites the right-hand side with the solution.
pub type InPlaceSolve<'a> = dyn Fn(&mut [f64]) + Sync + 'a;

/// Bodies that move under the pressure.
pub struct CoupledBodies<'a> {
    /// Number of their degrees of freedom.
    pub dof_count: usize,
    /// `F`: for each cell at the bodies' surfaces, the degrees of freedom that flow into it, with coefficients.
    pub flux_rows: Vec<(u32, Vec<(u32, f64)>)>,
    /// For each of these cells, the part of `F B⁻¹ Fᵀ` that the system's Dirichlet coefficient already contains.
    pub lumped_compliance: Vec<f64>,
    /// `x → B⁻¹ x` for the degrees of freedom in `flux_rows`; `x` is 0 at all others. It takes one vector, or several one after another.
    pub solve: Box<InPlaceSolve<'a>>,
    /// Columns that tell whether the bodies determine the mean pressure of a component of the liquid: they do not where
    /// each column sums to zero over it.
    pub mean_pressure_probes: Vec<SparseColumn>,
    /// The exact inverse on these cells, built once a solve without it was too slow; contains `None` where it does not exist.
    pub subdomain_inverse: OnceLock<Option<SubdomainInverse>>,
}

/// Number of body solves per batch when the exact inverse is assembled.
const SOLVES_PER_BATCH: usize = 16;
/// Number of batched body solves that take as long as a single one: an estimate for supernodal factors, which affects the cost only.
const BATCH_SPEEDUP: usize = 4;

/// Number of body degrees of freedom from which the bodies are solved for on another thread: waking it takes some 10 µs.
const MIN_PARALLEL_DOFS: usize = 1 << 14;

struct CoupledOperator<'a, const D: usize> {
    system: &'a PressureSolver<D>,
    body: &'a CoupledBodies<'a>,
    /// For each of the bodies' cells the entry of the solver's vectors.
    entries: Vec<Option<usize>>,
}

impl<const D: usize> LinearOperator for CoupledOperator<'_, D> {
    fn size(&self) -> usize {
        self.system.size()
    }

    fn apply(&self, x: &[f64], y: &mut [f64]) {
        self.apply_dot(x, y);
    }

    fn apply_dot(&self, x: &[f64], y: &mut [f64]) -> f64 {
        let (body, entries) = (self.body, &self.entries);
        let body_response = || {
            let mut push = vec![0.0; body.dof_count];
            for (entry, (_, flow)) in entries.iter().zip(&body.flux_rows) {
                let Some(entry) = entry else { continue };
                flow.iter().for_each(|(k, v)| push[*k as usize] += v * x[*entry]);
            }
            (body.solve)(&mut push);
            push
        };
        let (mut dot, push) = if body.dof_count < MIN_PARALLEL_DOFS {
            (self.system.apply_dot(x, y), body_response())
        } else {
            rayon::join(|| self.system.apply_dot(x, y), body_response)
        };
        for ((entry, (_, flow)), porous) in entries.iter().zip(&body.flux_rows).zip(&body.lumped_compliance) {
            let Some(entry) = *entry else { continue };
            let more = flow.iter().map(|(k, v)| v * push[*k as usize]).sum::<f64>() - porous * x[entry];
            y[entry] += more;
            dot += more * x[entry];
        }
        dot
    }
}

impl<const D: usize> PressureSolver<D> {
    /// Solves `(A + F B⁻¹ Fᵀ − diag(lumped_compliance)) x = rhs` as [`solve`](Self::solve) does without bodies. Entries
    /// of bodies at cells that are no unknowns are ignored. A component without Dirichlet values floats only if a
    /// constant pressure on it acts on no body.
    ///
    /// # Errors
    /// As [`solve`](Self::solve), except that `x` may then hold an iterate.
    pub fn solve_coupled(
        &self,
        bodies: Option<&CoupledBodies<'_>>,
        rhs: &CellField<D>,
        x: &mut CellField<D>,
        limits: SolveLimits,
    ) -> Result<SolveReport, SolveError> {
        let Some(body) = bodies else { return self.solve(rhs, x, limits) };
        let lattice = rhs.grid.lattice();
        let entry = |cell: u32| self.entry(lattice.coordinates(cell as usize));
        let translate = |column: &SparseColumn| {
            column.iter().filter_map(|&(cell, v)| entry(cell).map(|e| (e, v))).collect::<Vec<_>>()
        };
        let feelers: Vec<_> = body.mean_pressure_probes.iter().map(translate).collect();
        let floats = self.floating_with_columns(&feelers);
        let entries = body.flux_rows.iter().map(|(cell, _)| entry(*cell)).collect();
        let coupled = CoupledOperator { system: self, body, entries };
        // Multigrid alone may take as long as building the exact inverse on the bodies' cells would: the total is at most
        // twice the time of the faster of both (ski rental).
        let multigrid =
            RelatedSystem { operator: &coupled, preconditioner: self.preconditioner(), floats: &floats };
        let SolveLimits { tolerance, max_iterations: most } = limits;
        let mut done = 0;
        if body.subdomain_inverse.get().is_none() {
            let first = most.min(body.flux_rows.len().div_ceil(BATCH_SPEEDUP));
            let limits = SolveLimits { tolerance, max_iterations: first };
            let report = self.solve_system(&multigrid, rhs, x, limits, UnconvergedIterate::Keep);
            let slow =
                matches!(report, Err(SolveError::NotConverged { iterations, .. }) if iterations == first);
            if !slow || first == most {
                return report;
            }
            done = first;
        }
        let subdomain = body.subdomain_inverse.get_or_init(|| coupled.assemble_subdomain_inverse(lattice));
        let limits = SolveLimits { tolerance, max_iterations: most - done };
        let report = match subdomain {
            Some(subdomain) => {
                let work = Mutex::new([(); 2].map(|()| vec![0.0; self.size()]));
                let schwarz = Schwarz { system: self, multigrid: self.preconditioner(), subdomain, work };
                let schwarz = RelatedSystem { preconditioner: &schwarz, operator: &coupled, floats: &floats };
                self.solve_system(&schwarz, rhs, x, limits, UnconvergedIterate::Discard)
            }
            None => self.solve_system(&multigrid, rhs, x, limits, UnconvergedIterate::Discard),
        };
        report.map(|report| SolveReport { iterations: report.iterations + done, ..report })
    }
}

impl<const D: usize> CoupledOperator<'_, D> {
    /// The exact inverse on the bodies' cells.
    fn assemble_subdomain_inverse(&self, lattice: Lattice<D>) -> Option<SubdomainInverse> {
        let mut cells: BTreeMap<usize, [usize; D]> = BTreeMap::new();
        for (entry, (cell, _)) in self.entries.iter().zip(&self.body.flux_rows) {
            if let Some(entry) = entry {
                cells.insert(*entry, lattice.coordinates(*cell as usize));
            }
        }
        let entries: Vec<usize> = cells.keys().copied().collect();
        let mut matrix = self.subdomain_matrix(&cells, &entries);
        self.add_compliance(&entries, &mut matrix);
        SubdomainInverse::new(entries, matrix)
    }

    /// The system's entries between cells. The colour `x + 2 y + 3 z` modulo `2 D + 1` differs for a cell and all its
    /// neighbours, so that as many products with the system give all entries.
    fn subdomain_matrix(&self, cells: &BTreeMap<usize, [usize; D]>, entries: &[usize]) -> DMatrix<f64> {
        let colours = 2 * D + 1;
        let colour =
            |at: &[usize; D]| at.iter().enumerate().map(|(a, i)| (a + 1) * i).sum::<usize>() % colours;
        let numbers: BTreeMap<[usize; D], usize> =
            cells.values().enumerate().map(|(n, at)| (*at, n)).collect();
        let mut matrix = DMatrix::zeros(entries.len(), entries.len());
        let (mut x, mut y) = (vec![0.0; self.size()], vec![0.0; self.size()]);
        for chosen in 0..colours {
            cells.iter().for_each(|(e, at)| x[*e] = if colour(at) == chosen { 1.0 } else { 0.0 });
            self.system.apply(&x, &mut y);
            for (row, (entry, at)) in cells.iter().enumerate() {
                let neighbour = (0..D).flat_map(|a| [(a, 1), (a, usize::MAX)]).map(|(a, step)| {
                    let mut at = *at;
                    at[a] = at[a].wrapping_add(step);
                    at
                });
                let known = neighbour.chain([*at]).filter_map(|at| Some((*numbers.get(&at)?, colour(&at))));
                known.filter(|(_, c)| *c == chosen).for_each(|(column, _)| matrix[(row, column)] = y[*entry]);
            }
        }
        matrix
    }

    /// Adds `F B⁻¹ Fᵀ − diag(lumped_compliance)` to the cells' matrix.
    fn add_compliance(&self, entries: &[usize], matrix: &mut DMatrix<f64>) {
        let body = self.body;
        let mut flows: Vec<Vec<(u32, f64)>> = vec![Vec::new(); entries.len()];
        for ((entry, (_, flow)), porous) in
            self.entries.iter().zip(&body.flux_rows).zip(&body.lumped_compliance)
        {
            let Some(number) = entry.and_then(|e| entries.binary_search(&e).ok()) else { continue };
            flows[number].extend_from_slice(flow);
            matrix[(number, number)] -= porous;
        }
        let n = body.dof_count;
        for (first, some) in (0..).step_by(SOLVES_PER_BATCH).zip(flows.chunks(SOLVES_PER_BATCH)) {
            let mut pushes = vec![0.0; some.len() * n];
            for (push, flow) in pushes.chunks_exact_mut(n).zip(some) {
                flow.iter().for_each(|(k, v)| push[*k as usize] += v);
            }
            (body.solve)(&mut pushes);
            for (column, push) in pushes.chunks_exact(n).enumerate() {
                for (row, flow) in flows.iter().enumerate() {
                    let more: f64 = flow.iter().map(|(k, v)| v * push[*k as usize]).sum();
                    matrix[(row, first + column)] += more;
                }
            }
        }
    }
}
