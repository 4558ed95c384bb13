//! Linear operators, preconditioners and solvers.

mod operator;

pub use operator::{LinearOperator, Preconditioner, SolveError, SolveReport};
