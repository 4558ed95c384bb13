//! Chebyshev iteration (Y. Saad, "Iterative Methods for Sparse Linear Systems", 2nd ed., SIAM 2003, algorithm 12.1) with the Jacobi
//! preconditioner, as a smoother of multigrid (M. Adams et al., "Parallel multigrid smoothing: polynomial versus Gauss-Seidel", J. Comput.
//! Phys. 188 (2003) 593).
//!
//! For `A x = b` and eigenvalues of `D⁻¹ A` in `[a, c]`, `n` steps reduce the error by at least `1/T_n(σ)` with the Chebyshev polynomial
//! `T_n` and `σ = (c + a)/(c − a)`; eigenvalues in `(0, a)` are reduced less, and none up to `c` grow. The result is `p(D⁻¹ A) D⁻¹ b` with a
//! fixed polynomial, a symmetric function of `b`.

use super::{Jacobi, LinearOperator, Real, vectors};

/// A fixed number of steps for a range of eigenvalues.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chebyshev {
    /// Number of steps.
    pub degree: usize,
    /// Lowest eigenvalue of the matrix divided by its diagonal that is reduced by the full factor.
    pub lowest: f64,
    /// Bound of these eigenvalues.
    pub largest: f64,
}

/// Work vectors: residual, last step, and its image. The operator must leave entries that it does not write zero.
pub type ChebyshevWork<T> = [Vec<T>; 3];

impl Chebyshev {
    /// Sets `x` to the iterate that starts from zero.
    pub fn from_zero<T: Real>(
        &self,
        operator: &impl LinearOperator<T>,
        jacobi: &Jacobi<T>,
        b: &[T],
        x: &mut [T],
        work: &mut ChebyshevWork<T>,
    ) {
        x.fill(T::default());
        vectors::copy(b, &mut work[0]);
        self.iterate(operator, jacobi, x, work);
    }

    /// The same from the `x` passed in.
    pub fn improve<T: Real>(
        &self,
        operator: &impl LinearOperator<T>,
        jacobi: &Jacobi<T>,
        b: &[T],
        x: &mut [T],
        work: &mut ChebyshevWork<T>,
    ) {
        let [residual, _, image] = &mut *work;
        operator.apply(x, image);
        vectors::copy(b, residual);
        vectors::axpy(-1.0, image, residual);
        self.iterate(operator, jacobi, x, work);
    }

    /// After one of these: the residual `b − A x`.
    pub fn residual<'w, T: Real>(
        operator: &impl LinearOperator<T>,
        work: &'w mut ChebyshevWork<T>,
    ) -> &'w mut [T] {
        let [residual, step, image] = work;
        operator.apply(step, image);
        vectors::axpy(-1.0, image, residual);
        residual
    }

    /// Takes the steps from an `x` whose residual is in the first work vector.
    fn iterate<T: Real>(
        &self,
        operator: &impl LinearOperator<T>,
        jacobi: &Jacobi<T>,
        x: &mut [T],
        work: &mut ChebyshevWork<T>,
    ) {
        let (center, radius) = (0.5 * (self.largest + self.lowest), 0.5 * (self.largest - self.lowest));
        let sigma = center / radius;
        let (mut rho, mut factors) = (1.0 / sigma, [0.0, 1.0 / center]);
        for k in 0..self.degree {
            if k > 0 {
                Self::residual(operator, work);
                let next = 1.0 / (2.0 * sigma - rho);
                factors = [next * rho, 2.0 * next / radius];
                rho = next;
            }
            let [residual, step, _] = &mut *work;
            vectors::add_preconditioned_step(factors, &jacobi.inverse, residual, step, x);
        }
    }
}
