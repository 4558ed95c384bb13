//! The input of a pressure system: the unknown cells and the coefficients between them.

use crate::grid::{CellField, FaceField, Grid, Runs};

/// The pressure system `(A x)_i = Σ c_f (x_i − x_j) + d_i x_i`; the sum runs over the faces `f` to unknown
/// neighbours `j`.
///
/// The unit of the coefficients is the caller's; only their ratio to the right-hand side matters.
#[derive(Clone, Copy, Debug)]
pub struct PoissonInput<'a, const D: usize> {
    /// The grid.
    pub grid: Grid<D>,
    /// The unknown cells, each run labelled with its connected component.
    pub unknowns: &'a Runs,
    /// `c_f ≥ 0`; read only on faces between two unknown cells.
    pub coefficients: &'a FaceField<D>,
    /// `d_i ≥ 0`: sum of the coefficients toward known values; read only on unknown cells.
    pub dirichlet: &'a CellField<D>,
}
