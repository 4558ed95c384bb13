//! The pressure's system: a variable-coefficient Poisson equation on runs of cells, coupled with solids, by conjugate gradients with
//! multigrid.

mod connect;
mod coupled;
#[cfg(test)]
mod coupled_tests;
mod input;
mod layout;
mod level;
mod multigrid;
mod solver;
mod sweep;
#[cfg(test)]
mod tests;
mod wetted;

pub use coupled::{SparseColumn, CoupledBodies, InPlaceSolve};
pub use input::PoissonInput;
pub use solver::PressureSolver;
pub use wetted::SubdomainInverse;
