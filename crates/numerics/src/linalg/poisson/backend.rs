//! The door for other solvers of the pressure system, such as one on a device.
//!
//! A solver implements [`PressureBackend`], in this crate or another one, and `sim` chooses it where it makes its memory for the
//! pressure. The calls are few: one to prepare a system, and one a right-hand side.

use super::system::PressureSystem;
use crate::grid::CellField;
use crate::linalg::operator::{SolveError, SolveLimits, SolveReport};

/// A solver of pressure systems, with its memory, which it may keep from one system to the next.
///
/// Results must be the same bits in each run: they may depend on the system, the right-hand side and the initial guess only, not on the
/// number of threads or on systems before.
pub trait PressureBackend<const D: usize>: Send + Sync {
    /// Prepares a system for several solves. The fields of its matrix are copied; the caller may change them afterwards.
    ///
    /// # Errors
    /// [`SolveError`] if the system cannot be prepared.
    fn prepare<'a>(
        &'a mut self,
        system: &PressureSystem<'_, 'a, D>,
    ) -> Result<Box<dyn PreparedPressureSystem<D> + 'a>, SolveError>;
}

/// A pressure system that is ready to be solved.
pub trait PreparedPressureSystem<const D: usize> {
    /// Solves for a right-hand side, to `‖rhs − S x‖₂ ≤ limits.tolerance ‖rhs‖₂` with the system's matrix `S`, from the initial guess in
    /// `x`. Both are dense and cell-indexed; cells that are no unknowns are neither read nor written.
    ///
    /// A component without Dirichlet values floats if a constant pressure on it acts on no body: its mean is subtracted from the
    /// right-hand side and from the solution. Cells whose row is all zeros get 0. The norm is that of the right-hand side so corrected.
    ///
    /// # Errors
    /// [`SolveError`] if the tolerance was not reached or a number is not finite; `x` may then hold an iterate.
    fn solve(
        &mut self,
        rhs: &CellField<D>,
        x: &mut CellField<D>,
        limits: SolveLimits,
    ) -> Result<SolveReport, SolveError>;
}
