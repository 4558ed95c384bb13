//! The pressure system: a variable-coefficient Poisson equation on runs of cells, coupled with bodies, solved by
//! conjugate gradients with multigrid, or by another backend.

mod backend;
mod coupled;
#[cfg(test)]
mod coupled_tests;
mod flux_components;
mod multigrid;
mod multigrid_backend;
mod schwarz;
mod solver;
mod system;
#[cfg(test)]
mod tests;

pub use backend::{PreparedPressureSystem, PressureBackend};
pub use multigrid_backend::MultigridBackend;
pub use solver::PressureSolver;
pub use system::{CoupledBodies, InPlaceSolve, PoissonInput, PressureSystem, SparseColumn};
