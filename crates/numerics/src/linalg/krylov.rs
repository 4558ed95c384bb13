//! The conjugate gradient method.

use super::operator::{LinearOperator, Preconditioner, SolveError, SolveReport};
use super::vectors;

/// Solves `A x = b` by preconditioned conjugate gradients, starting from the `x` passed in.
///
/// Stops when the true residual `b − A x`, recomputed at the end, is at most `tolerance` times `b` in the 2-norm. If the
/// recursive residual reached that but the true one did not, the iteration restarts from there.
///
/// # Errors
/// [`SolveError`] after `max_iterations`, with the last iterate in `x`. It is also returned if the operator or the
/// preconditioner is not positive or a number is not finite; `x` is then meaningless.
pub fn conjugate_gradient(
    operator: &impl LinearOperator,
    preconditioner: &impl Preconditioner,
    b: &[f64],
    x: &mut [f64],
    tolerance: f64,
    max_iterations: usize,
) -> Result<SolveReport, SolveError> {
    let mut work = [(); 3].map(|()| vec![0.0; operator.size()]);
    conjugate_gradient_with_workspace(operator, preconditioner, b, x, (tolerance, max_iterations), &mut work)
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
    (tolerance, max_iterations): (f64, usize),
    work: &mut [Vec<f64>; 3],
) -> Result<SolveReport, SolveError> {
    let norm = vectors::dot(b, b).sqrt();
    if !norm.is_finite() {
        return Err(SolveError::NotFinite { iteration: 0 });
    }
    if norm == 0.0 {
        x.fill(0.0);
        return Ok(SolveReport::default());
    }
    // The last vector holds the preconditioned residual and the image of the direction in turn.
    let [r, p, q] = work;
    // The recursion uses residuals relative to the right-hand side.
    let scale = 1.0 / norm;
    let mut iterations = 0;
    loop {
        operator.apply(x, q);
        let mut square = vectors::scaled_residual(scale, b, q, r);
        let start = square;
        let failed = |iterations, square: f64| SolveError::NotConverged {
            iterations,
            residual: square.sqrt(),
            tolerance,
        };
        if !square.is_finite() {
            return Err(SolveError::NotFinite { iteration: iterations });
        }
        if square.sqrt() <= tolerance {
            return Ok(SolveReport { iterations, residual: square.sqrt() });
        }
        let (mut alpha, mut rho) = (0.0, 0.0);
        while square.sqrt() > tolerance {
            if iterations == max_iterations {
                if rho != 0.0 {
                    vectors::axpy(alpha * norm, p, x);
                }
                return Err(failed(iterations, square));
            }
            let next = preconditioner.apply(r, q);
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
            square = vectors::subtract_scaled(alpha, q, r);
            iterations += 1;
            if !square.is_finite() || square > 1e12 * start {
                return Err(SolveError::NotFinite { iteration: iterations });
            }
        }
        vectors::axpy(alpha * norm, p, x);
    }
}
