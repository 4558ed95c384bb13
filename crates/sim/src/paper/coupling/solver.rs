//! Solvers of the indefinite systems of Eq. 11 and 15.
//!
//! The paper solves them by conjugate gradients with a Jacobi preconditioner to a tolerance of 10⁻⁵ (Section 7.3), and says that their
//! convergence is not guaranteed (Section 8). The diagonal is positive in the rows of the pressure and negative in those of the
//! velocities. With it as preconditioner the preconditioned matrix `[L B; −Bᵀ M]` has a positive definite symmetric part; the squares of
//! the method's norms may vanish or change their sign all the same. MINRES minimises the residual for any symmetric matrix; its
//! preconditioner has to be positive, the absolute values of the diagonal.

use super::system::CoupledSystem;
use meniscus_numerics::linalg::{Jacobi, LinearOperator, SolveError, SolveLimits, SolveReport, dot, minres};

/// A solver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Solver {
    /// Conjugate gradients with the diagonal as preconditioner, as in the paper.
    ConjugateGradient,
    /// MINRES with the absolute values of the diagonal.
    Minres,
}

/// Limits of the paper's solver: the tolerance of Section 7.3, and a number of iterations that it does not give.
pub const PAPER_LIMITS: SolveLimits = SolveLimits { tolerance: 1e-5, max_iterations: 20_000 };

impl Solver {
    /// Solves a system from the `x` passed in until the true residual, recomputed at the end, is small enough.
    ///
    /// # Errors
    /// [`SolveError::NotConverged`], also where the conjugate gradients break down, and [`SolveError::NotFinite`].
    pub fn solve(
        self,
        system: &CoupledSystem,
        x: &mut [f64],
        limits: SolveLimits,
    ) -> Result<SolveReport, SolveError> {
        let diagonal = system.matrix.diagonal();
        match self {
            Self::ConjugateGradient => {
                indefinite_conjugate_gradient(&system.matrix, &diagonal, &system.right, x, limits)
            }
            Self::Minres => {
                let sizes: Vec<f64> = diagonal.iter().map(|d| d.abs()).collect();
                minres(&system.matrix, &Jacobi::new(&sizes), &system.right, x, limits)
            }
        }
    }
}

/// Conjugate gradients that do not ask for signs. Restarts where the recursive residual is small and the true one is not.
fn indefinite_conjugate_gradient(
    matrix: &impl LinearOperator,
    diagonal: &[f64],
    b: &[f64],
    x: &mut [f64],
    SolveLimits { tolerance, max_iterations }: SolveLimits,
) -> Result<SolveReport, SolveError> {
    let norm = dot(b, b).sqrt();
    if norm == 0.0 {
        x.fill(0.0);
        return Ok(SolveReport::default());
    }
    let preconditioned = |r: &[f64]| -> Vec<f64> {
        r.iter().zip(diagonal).map(|(r, d)| if *d == 0.0 { 0.0 } else { r / d }).collect()
    };
    let mut image = vec![0.0; b.len()];
    let mut iterations = 0;
    // Every turn but the last does an iteration at least.
    loop {
        matrix.apply(x, &mut image);
        let mut r: Vec<f64> = b.iter().zip(&image).map(|(b, q)| b - q).collect();
        let residual = dot(&r, &r).sqrt() / norm;
        let failed = |iterations| SolveError::NotConverged { iterations, residual, tolerance };
        if !residual.is_finite() {
            return Err(SolveError::NotFinite { iteration: iterations });
        }
        if residual <= tolerance {
            return Ok(SolveReport { iterations, residual });
        }
        let mut p = preconditioned(&r);
        let mut rho = dot(&r, &p);
        let mut square = f64::INFINITY;
        while square.sqrt() > tolerance * norm {
            let curvature = matrix.apply_dot(&p, &mut image);
            if iterations == max_iterations || curvature == 0.0 || rho == 0.0 {
                return Err(failed(iterations));
            }
            let alpha = rho / curvature;
            x.iter_mut().zip(&p).for_each(|(x, p)| *x += alpha * p);
            r.iter_mut().zip(&image).for_each(|(r, q)| *r -= alpha * q);
            iterations += 1;
            square = dot(&r, &r);
            if !square.is_finite() {
                return Err(SolveError::NotFinite { iteration: iterations });
            }
            let z = preconditioned(&r);
            let next = dot(&r, &z);
            let beta = next / rho;
            rho = next;
            p.iter_mut().zip(&z).for_each(|(p, z)| *p = z + beta * *p);
        }
    }
}
