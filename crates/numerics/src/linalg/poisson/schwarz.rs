//! Schwarz preconditioner for a pressure system with bodies that multigrid alone preconditions poorly.
//!
//! Let `w` be the cells into which bodies flow, and `n` all others. The bodies change only the block `S_ww` of the system
//! `S = A + F B⁻¹ Fᵀ − diag(lumped_compliance)`. The preconditioner is the symmetric multiplicative Schwarz method: exact
//! on `w`, multigrid `M` on the rest (B. Smith, P. Bjørstad, W. Gropp, "Domain Decomposition", 1996):
//!
//! ```text
//! z_n = (M (0, r_n − A_nw S_ww⁻¹ r_w))_n,   z_w = S_ww⁻¹ (r_w − A_wn z_n)
//! ```
//!
//! Applying it needs no solve of the bodies. Limit: `S_ww` is dense; its factorisation costs a third of the cube of the number of cells.

use crate::linalg::operator::{LinearOperator, Preconditioner};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use std::sync::Mutex;

/// The exact inverse on the bodies' cells.
#[derive(Debug)]
pub struct SubdomainInverse {
    /// Entries of the cells, sorted.
    entries: Vec<usize>,
    factor: Cholesky<f64, Dyn>,
}

impl SubdomainInverse {
    /// Factorises a matrix on the cells' entries. `None` if it is not positive definite, as where all cells of a
    /// component without a free surface are among them.
    pub fn new(entries: Vec<usize>, matrix: DMatrix<f64>) -> Option<Self> {
        Some(Self { entries, factor: Cholesky::new(matrix)? })
    }

    /// Applies `S_ww⁻¹` to the values at the cells.
    fn solve(&self, values: impl Fn(usize) -> f64) -> DVector<f64> {
        self.factor
            .solve(&DVector::from_iterator(self.entries.len(), self.entries.iter().map(|e| values(*e))))
    }
}

/// Multigrid with the exact inverse on the bodies' cells.
pub struct Schwarz<'a, S, M> {
    /// The system without bodies.
    pub system: &'a S,
    /// Multigrid on it.
    pub multigrid: &'a M,
    /// The exact inverse.
    pub subdomain: &'a SubdomainInverse,
    /// Two work vectors of the system, zero at entries that are no unknowns.
    pub work: Mutex<[Vec<f64>; 2]>,
}

impl<S: LinearOperator, M: Preconditioner> Preconditioner for Schwarz<'_, S, M> {
    fn apply(&self, r: &[f64], z: &mut [f64]) -> f64 {
        let mut memory = self.work.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let [first, second] = &mut *memory;
        let (wetted, entries) = (self.subdomain, &self.subdomain.entries);
        // The residual of the other cells after the exact solve on the bodies' cells.
        let alone = wetted.solve(|e| r[e]);
        first.fill(0.0);
        entries.iter().zip(&alone).for_each(|(e, v)| first[*e] = *v);
        self.system.apply(first, second);
        second.iter_mut().zip(r).for_each(|(s, r)| *s = r - *s);
        entries.iter().for_each(|e| second[*e] = 0.0);
        self.multigrid.apply(second, z);
        entries.iter().for_each(|e| z[*e] = 0.0);
        self.system.apply(z, first);
        let last = wetted.solve(|e| r[e] - first[e]);
        entries.iter().zip(&last).for_each(|(e, v)| z[*e] = *v);
        crate::linalg::vectors::dot(r, z)
    }
}
