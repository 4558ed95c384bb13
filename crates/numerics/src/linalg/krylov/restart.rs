//! Restarts of a recursion from the true residual.
//!
//! Krylov methods iterate on a residual that a recursion updates, and which rounding separates from `b − A x` in time. A solve ends only
//! where the true residual is small; until then the recursion starts again from it.

use crate::linalg::operator::{LinearOperator, SolveError, SolveLimits, SolveReport};
use crate::linalg::vectors;

/// Initial data of a recursion. The first work vector holds the residual, divided by the norm of the right-hand side.
#[derive(Clone, Copy, Debug)]
pub struct Start {
    /// Norm of the right-hand side.
    pub norm: f64,
    /// Square of the norm of the residual, relative to the right-hand side.
    pub square: f64,
    /// Iterations done so far.
    pub iterations: usize,
}

/// Runs a recursion until the true residual is small enough. The recursion takes the iterate, the work vectors and its start, and
/// returns the number of iterations done in all. The second work vector takes the image of the iterate.
///
/// # Errors
/// Those of the recursion, and [`SolveError::NotFinite`].
pub fn with_restarts<const N: usize>(
    operator: &impl LinearOperator,
    b: &[f64],
    x: &mut [f64],
    limits: SolveLimits,
    work: &mut [Vec<f64>; N],
    recursion: impl Fn(&mut [f64], &mut [Vec<f64>; N], Start) -> Result<usize, SolveError>,
) -> Result<SolveReport, SolveError> {
    const { assert!(N >= 2, "residual and image") };
    let norm = vectors::dot(b, b).sqrt();
    if !norm.is_finite() {
        return Err(SolveError::NotFinite { iteration: 0 });
    }
    if norm == 0.0 {
        x.fill(0.0);
        return Ok(SolveReport::default());
    }
    let mut iterations = 0;
    loop {
        let (residual, others) = work.split_at_mut(1);
        let (residual, image) = (&mut residual[0], &mut others[0]);
        operator.apply(x, image);
        let square = vectors::scaled_residual(1.0 / norm, b, image, residual);
        if !square.is_finite() {
            return Err(SolveError::NotFinite { iteration: iterations });
        }
        if square.sqrt() <= limits.tolerance {
            return Ok(SolveReport { iterations, residual: square.sqrt() });
        }
        iterations = recursion(x, work, Start { norm, square, iterations })?;
    }
}
