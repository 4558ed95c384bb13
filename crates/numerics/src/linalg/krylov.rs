//! The conjugate gradient method.

use super::operator::{LinearOperator, Preconditioner, SolveError, SolveReport};
use super::vectors;

/// Solves `A x = b` by preconditioned conjugate gradients, starting from the `x` passed in.
///
/// Stops when the true residual `b − A x`, computed anew at the end, is at most `tolerance` times `b` in the 2-norm.
/// If the recursive residual reached that but the true one did not, the iteration starts anew from there.
///
/// # Errors
/// [`SolveError`] after `max_iterations`, when the operator or preconditioner turns out not to be positive, or when
/// a number is not finite; `x` is then of no use.
pub fn conjugate_gradient(
    operator: &impl LinearOperator,
    preconditioner: &impl Preconditioner,
    b: &[f64],
    x: &mut [f64],
    tolerance: f64,
    max_iterations: usize,
) -> Result<SolveReport, SolveError> {
    let n = operator.size();
    let norm = vectors::dot(b, b).sqrt();
    if !norm.is_finite() {
        return Err(SolveError::NotFinite { iteration: 0 });
    }
    if norm == 0.0 {
        x.fill(0.0);
        return Ok(SolveReport::default());
    }
    let (mut r, mut z, mut p, mut q) = (vec![0.0; n], vec![0.0; n], vec![0.0; n], vec![0.0; n]);
    // The recursion runs on residuals relative to the right-hand side.
    let scale = 1.0 / norm;
    let mut iterations = 0;
    loop {
        operator.apply(x, &mut q);
        let mut square = vectors::residual(scale, b, &q, &mut r);
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
                return Err(failed(iterations, square));
            }
            let next = preconditioner.apply(&r, &mut z);
            let beta = if rho == 0.0 { 0.0 } else { next / rho };
            vectors::advance(alpha * norm, beta, &z, x, &mut p);
            rho = next;
            let curvature = operator.apply_dot(&p, &mut q);
            if !(curvature.is_finite() && rho.is_finite()) {
                return Err(SolveError::NotFinite { iteration: iterations });
            }
            if curvature <= 0.0 || rho <= 0.0 {
                return Err(failed(iterations, square));
            }
            alpha = rho / curvature;
            square = vectors::subtract(alpha, &q, &mut r);
            iterations += 1;
            if !square.is_finite() || square > 1e12 * start {
                return Err(SolveError::NotFinite { iteration: iterations });
            }
        }
        vectors::add(alpha * norm, &p, x);
    }
}
