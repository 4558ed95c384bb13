//! Linear operators, preconditioners and solvers.

mod chebyshev;
mod jacobi;
mod krylov;
mod operator;
mod poisson;
mod real;
mod vectors;

pub use chebyshev::{Chebyshev, ChebyshevWork};
pub use jacobi::Jacobi;
pub use krylov::{
    conjugate_gradient, conjugate_gradient_in_single_precision, conjugate_gradient_with_workspace, minres,
    minres_with_workspace,
};
pub use operator::{LinearOperator, Preconditioner, SolveError, SolveLimits, SolveReport};
pub use poisson::{
    CoupledBodies, InPlaceSolve, MultigridBackend, PoissonInput, PreparedPressureSystem, PressureBackend,
    PressureSolver, PressureSystem, SparseColumn,
};
pub use real::Real;
pub use vectors::{dot, dot_serial};
