//! The operator of a pressure system with bodies ([`super::PressureSystem`]), and its exact inverse on the bodies' cells.

use super::schwarz::SubdomainInverse;
use super::solver::PressureSolver;
use super::system::CoupledBodies;
use crate::linalg::operator::LinearOperator;
use nalgebra::DMatrix;
use std::collections::BTreeMap;

/// Number of body solves per batch when the exact inverse is assembled.
const SOLVES_PER_BATCH: usize = 16;
/// Number of body degrees of freedom from which the bodies are solved for on another thread: waking it takes some 10 µs.
const MIN_PARALLEL_DOFS: usize = 1 << 14;

/// `A + F B⁻¹ Fᵀ − diag(lumped_compliance)` on the vectors of a solver of `A`.
pub struct CoupledOperator<'a, const D: usize> {
    system: &'a PressureSolver<D>,
    body: &'a CoupledBodies<'a>,
    /// For each of the bodies' cells the entry of the solver's vectors.
    entries: Vec<Option<usize>>,
}

impl<'a, const D: usize> CoupledOperator<'a, D> {
    /// The operator of these bodies.
    pub fn new(system: &'a PressureSolver<D>, body: &'a CoupledBodies<'a>) -> Self {
        let entries = body.flux_rows.iter().map(|(cell, _)| system.entry_of(*cell)).collect();
        Self { system, body, entries }
    }

    /// Number of cells into which bodies flow, each counted once per surface in it.
    pub fn cell_count(&self) -> usize {
        self.entries.len()
    }
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

impl<const D: usize> CoupledOperator<'_, D> {
    /// The exact inverse on the bodies' cells.
    /// `None` where it does not exist.
    pub fn subdomain_inverse(&self) -> Option<SubdomainInverse> {
        let lattice = self.system.grid().lattice();
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
