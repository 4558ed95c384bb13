//! Linear operators and preconditioners, and the results of solvers.

use super::{Real, vectors};
use thiserror::Error;

/// A symmetric operator on vectors of [`size`](Self::size) entries; each solver says whether it has to be positive (semi-)definite.
pub trait LinearOperator<T: Real = f64>: Sync {
    /// Number of unknowns.
    fn size(&self) -> usize;
    /// `y = A x`.
    fn apply(&self, x: &[T], y: &mut [T]);
    /// `y = A x`; returns `x · y`.
    fn apply_dot(&self, x: &[T], y: &mut [T]) -> f64 {
        self.apply(x, y);
        vectors::dot(x, y)
    }
}

/// A symmetric positive definite approximation of the inverse of an operator.
pub trait Preconditioner<T: Real = f64>: Sync {
    /// `z ≈ A⁻¹ r`; returns `r · z`.
    fn apply(&self, r: &[T], z: &mut [T]) -> f64;
    /// `r −= α q`; returns `r · r`. One that acts entry by entry sets `q = z ≈ A⁻¹ r` in the same pass, and returns `r · z`.
    fn subtract_and_apply(&self, alpha: f64, q: &mut [T], r: &mut [T]) -> (f64, Option<f64>) {
        (vectors::subtract_scaled(alpha, q, r), None)
    }
}

/// When an iterative solve ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolveLimits {
    /// Largest norm of the residual at the end, relative to the right-hand side (dimensionless).
    pub tolerance: f64,
    /// Largest number of iterations.
    pub max_iterations: usize,
}

/// Result of a solve.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SolveReport {
    /// Number of iterations.
    pub iterations: usize,
    /// Norm of the true residual at the end, relative to the right-hand side.
    pub residual: f64,
}

/// Why a solve failed.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum SolveError {
    /// The tolerance was not reached.
    #[error(
        "the linear solve stopped after {iterations} iterations at a relative residual of {residual:.2e}; the tolerance is {tolerance:.1e}"
    )]
    NotConverged {
        /// Iterations done.
        iterations: usize,
        /// Relative residual reached.
        residual: f64,
        /// Relative residual requested.
        tolerance: f64,
    },
    /// Newton's method for solids and pressure did not converge.
    #[error(
        "Newton's method for the velocities of the solids stopped after {iterations} iterations; the next iteration would still change a \
         velocity by {off:.1e} times the tolerance (inf: the line search allowed no whole step); jammed solids have no solution"
    )]
    NewtonNotConverged {
        /// Iterations done.
        iterations: usize,
        /// Step of the next iteration, relative to the tolerance.
        off: f64,
    },
    /// A solid deforms too much in one step.
    #[error(
        "the deformation gradient of an element changes by {increment:.2} in one time step; at most {limit:.2} is allowed"
    )]
    DeformationTooLarge {
        /// Norm of the change.
        increment: f64,
        /// Largest norm allowed.
        limit: f64,
    },
    /// An input or a result was not finite.
    #[error("the linear solve met a number that is not finite in iteration {iteration}")]
    NotFinite {
        /// Iteration in which it appeared.
        iteration: usize,
    },
    /// The matrix of the solids is not positive definite.
    #[error(
        "the matrix of the solids is not positive definite for a time step of {step:.3e} s: a solid is too stiff for double precision, \
         elements are crushed, or solids are jammed"
    )]
    NotPositiveDefinite {
        /// Length of the step, s.
        step: f64,
    },
    /// There is not enough memory for a matrix or its factors.
    #[error("the memory does not suffice for the matrix of the solids, which has {unknowns} unknowns")]
    OutOfMemory {
        /// Number of unknowns.
        unknowns: usize,
    },
}
