//! The pressure system: a variable-coefficient Poisson equation on runs of cells, coupled with solids, solved by
//! conjugate gradients with multigrid.

mod coupled;
#[cfg(test)]
mod coupled_tests;
mod flux_components;
mod input;
mod layout;
mod level;
mod multigrid;
mod schwarz;
mod solver;
mod sweep;
#[cfg(test)]
mod tests;

pub use coupled::{CoupledBodies, InPlaceSolve, SparseColumn};
pub use input::PoissonInput;
pub use schwarz::SubdomainInverse;
pub use solver::PressureSolver;
