//! The conjugate gradient method (M. Hestenes, E. Stiefel, "Methods of conjugate gradients for solving linear systems", J. Res. NBS 49
//! (1952) 409) for `A x = b` with a symmetric positive definite `A`.
//!
//! With a preconditioner `M ≈ A⁻¹` iteration `k` finds the `x` in `x₀ + span{M r₀, M A M r₀, …}`, of dimension `k`, with the least error
//! `(x − A⁻¹ b)ᵀ A (x − A⁻¹ b)`, by a recursion of three vectors. The root of that error falls at least as fast as
//! `2 ((√κ − 1)/(√κ + 1))^k` with the condition number `κ` of `M A`.
//!
//! Limit: `A` may be singular if `b` is in its range, but not indefinite; for such systems see [`minres`](super::minres()).

use super::restart::{Start, with_restarts};
use crate::linalg::operator::{LinearOperator, Preconditioner, SolveError, SolveLimits, SolveReport};
use crate::linalg::{Real, vectors};

/// Growth of the square of the residual above which the iteration counts as divergent. The iterate loses as many digits as the
/// residual gains: here six of sixteen.
const MAX_RESIDUAL_GROWTH: f64 = 1e12;

/// Solves `A x = b` by preconditioned conjugate gradients, starting from the `x` passed in.
///
/// Stops when the true residual `b − A x`, recomputed at the end, is at most `limits.tolerance` times `b` in the 2-norm. If the
/// recursive residual reached that but the true one did not, the iteration restarts from there.
///
/// # Errors
/// [`SolveError::NotConverged`] after `limits.max_iterations`, with the last iterate in `x`. It is also returned if the operator or
/// the preconditioner is not positive, and [`SolveError::NotFinite`] if a number is not finite; `x` is then meaningless.
pub fn conjugate_gradient(
    operator: &impl LinearOperator,
    preconditioner: &impl Preconditioner,
    b: &[f64],
    x: &mut [f64],
    limits: SolveLimits,
) -> Result<SolveReport, SolveError> {
    let mut work = [(); 3].map(|()| vec![0.0; operator.size()]);
    conjugate_gradient_with_workspace(operator, preconditioner, b, x, limits, &mut work)
}

/// The same with three work vectors from the caller. Their contents do not matter, except that entries that the operator
/// and the preconditioner do not write must be zero.
///
/// # Errors
/// As [`conjugate_gradient`].
pub fn conjugate_gradient_with_workspace(
    operator: &impl LinearOperator,
    preconditioner: &impl Preconditioner,
    b: &[f64],
    x: &mut [f64],
    limits: SolveLimits,
    work: &mut [Vec<f64>; 3],
) -> Result<SolveReport, SolveError> {
    with_restarts(operator, b, x, limits, work, |x, work, start| {
        iterate(operator, preconditioner, x, work, start, limits)
    })
}

/// The same without a workspace, in single precision: each restart solves for the correction of `x` with vectors of half the size, and
/// only the true residuals and `x` itself are in double precision. Limit, as of every iterative refinement: the condition
/// number must stay well below 2²⁴, the inverse of the rounding error.
///
/// # Errors
/// As [`conjugate_gradient`].
pub fn conjugate_gradient_in_single_precision(
    operator: &(impl LinearOperator + LinearOperator<f32>),
    preconditioner: &impl Preconditioner<f32>,
    b: &[f64],
    x: &mut [f64],
    limits: SolveLimits,
) -> Result<SolveReport, SolveError> {
    let mut work = [(); 2].map(|()| vec![0.0; b.len()]);
    with_restarts(operator, b, x, limits, &mut work, |x, [residual, image], start| {
        let mut correction = vec![0.0; x.len()];
        // New zeros, unlike copies of zeros, are written first by the threads that use them.
        let mut work = [vectors::converted(residual), vec![0.0; x.len()], vec![0.0; x.len()]];
        let one = Start { norm: 1.0, ..start };
        let result = iterate(operator, preconditioner, &mut correction, &mut work, one, limits);
        *image = vectors::converted(&correction);
        vectors::axpy(start.norm, image, x);
        result
    })
}

/// Iterates from a true residual until the recursive one is small enough; returns the number of iterations done in all.
fn iterate<T: Real>(
    operator: &impl LinearOperator<T>,
    preconditioner: &impl Preconditioner<T>,
    x: &mut [T],
    work: &mut [Vec<T>; 3],
    Start { norm, square: first, mut iterations }: Start,
    SolveLimits { tolerance, max_iterations }: SolveLimits,
) -> Result<usize, SolveError> {
    // The last vector holds the preconditioned residual and the image of the direction in turn.
    let [r, p, q] = work;
    let failed =
        |iterations, square: f64| SolveError::NotConverged { iterations, residual: square.sqrt(), tolerance };
    let mut square = first;
    let (mut alpha, mut rho, mut applied) = (0.0, 0.0, None);
    while square.sqrt() > tolerance {
        if iterations == max_iterations {
            if rho != 0.0 {
                vectors::axpy(alpha * norm, p, x);
            }
            return Err(failed(iterations, square));
        }
        let next = applied.unwrap_or_else(|| preconditioner.apply(r, q));
        if rho == 0.0 {
            vectors::copy(q, p);
        } else {
            vectors::update_iterate_and_direction(alpha * norm, next / rho, q, x, p);
        }
        rho = next;
        let curvature = operator.apply_dot(p, q);
        if !(curvature.is_finite() && rho.is_finite()) {
            return Err(SolveError::NotFinite { iteration: iterations });
        }
        if curvature <= 0.0 || rho <= 0.0 {
            return Err(failed(iterations, square));
        }
        alpha = rho / curvature;
        (square, applied) = preconditioner.subtract_and_apply(alpha, q, r);
        iterations += 1;
        if !square.is_finite() || square > MAX_RESIDUAL_GROWTH * first {
            return Err(SolveError::NotFinite { iteration: iterations });
        }
    }
    vectors::axpy(alpha * norm, p, x);
    Ok(iterations)
}
