//! Linear operators, preconditioners and solvers.

mod jacobi;
mod krylov;
mod operator;
mod poisson;
mod vectors;

pub use jacobi::Jacobi;
pub use krylov::{conjugate_gradient, conjugate_gradient_in};
pub use operator::{LinearOperator, Preconditioner, SolveError, SolveReport};
pub use poisson::{Column, Compliance, PoissonInput, PressureSolver, Solve, Wetted};
