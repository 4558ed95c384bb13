//! A pressure system as data: the unknown cells with the coefficients between them, and the bodies that move under the pressure.

use crate::grid::{CellField, FaceField, Grid, Runs};

/// The pressure system `(A + F B⁻¹ Fᵀ − diag(lumped_compliance)) x = b`, for any number of right-hand sides `b`.
///
/// The bodies add `F B⁻¹ Fᵀ` to the matrix `A` of the liquid alone. `F` holds the flow into the cells per degree of freedom of the
/// bodies, and `B` is the bodies' own matrix, known by its solve only. The system is symmetric positive semidefinite for any `F` if
/// `A − diag(lumped_compliance)` is. Bodies at cells that are no unknowns are ignored.
#[derive(Clone, Copy, Debug)]
pub struct PressureSystem<'m, 'b, const D: usize> {
    /// `A`.
    pub matrix: PoissonInput<'m, D>,
    /// The bodies, if there are any.
    pub bodies: Option<&'b CoupledBodies<'b>>,
}

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
}

impl std::fmt::Debug for CoupledBodies<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { dof_count, flux_rows, .. } = self;
        f.debug_struct("CoupledBodies")
            .field("dof_count", dof_count)
            .field("flux_rows", flux_rows)
            .finish_non_exhaustive()
    }
}
