//! Linear operators, preconditioners and solvers.

mod connect;
mod coupled;
#[cfg(test)]
mod coupled_tests;
mod jacobi;
mod krylov;
mod layout;
mod level;
mod multigrid;
mod operator;
mod pressure;
mod sweep;
#[cfg(test)]
mod tests;
mod vectors;
mod wetted;

pub use coupled::{Column, Compliance, Solve};
pub use jacobi::Jacobi;
pub use krylov::{conjugate_gradient, conjugate_gradient_in};
pub use operator::{LinearOperator, Preconditioner, SolveError, SolveReport};
pub use pressure::{PoissonInput, PressureSolver};
pub use wetted::Wetted;
