//! The minimal residual method (C. Paige, M. Saunders, "Solution of sparse indefinite systems of linear equations", SIAM J. Numer.
//! Anal. 12 (1975) 617) for `A x = b` with a symmetric `A` that may be indefinite.
//!
//! With a symmetric positive definite preconditioner `M ≈ |A|⁻¹`, iteration `k` finds the `x` in `x₀ + span{M r₀, M A M r₀, …}`, of
//! dimension `k`, whose residual has the least `rᵀ M r`. The Lanczos process gives a basis `V` of this space and a tridiagonal `T`:
//!
//! ```text
//! β_{k+1} p_{k+1} = A v_k − α_k p_k − β_k p_{k−1},   v_k = M p_k,   α_k = v_kᵀ A v_k,   p_kᵀ v_k = 1,   β_1 p_1 = r₀
//! ```
//!
//! so that `A V_k = P_{k+1} T_k`. Reflections `Q T = R` make `T` upper triangular with three diagonals; the directions `W = V R⁻¹`
//! follow from the last two, and the residual is `r_k = s_k² r_{k−1} − (φ_k/γ_k) β_{k+1} p_{k+1}` with the sine `s_k` of the last
//! reflection. It is carried along because its 2-norm, which ends the iteration, follows from no scalar where `M` is not the identity.
//!
//! Where the eigenvalues of `M A` lie in `[−b, −a] ∪ [a, b]`, the residual falls at least as fast as
//! `2 ((b/a − 1)/(b/a + 1))^⌊k/2⌋`.
//!
//! Limit: `A` may be singular if `b` is in its range; the solution is then not the shortest one in general. Each iteration works on eight
//! vectors; for definite systems conjugate gradients need three.

use super::restart::{Start, with_restarts};
use crate::linalg::operator::{LinearOperator, Preconditioner, SolveError, SolveLimits, SolveReport};
use crate::linalg::vectors;

/// Solves `A x = b` for a symmetric `A`, starting from the `x` passed in. The preconditioner is symmetric and positive definite.
///
/// Stops when the true residual `b − A x`, recomputed at the end, is at most `limits.tolerance` times `b` in the 2-norm. If the
/// recursive residual reached that but the true one did not, the iteration restarts from there.
///
/// # Errors
/// [`SolveError::NotConverged`] after `limits.max_iterations`, or where the search space is exhausted because `b` is not in the range of
/// `A`; `x` holds the last iterate. It is also returned if the preconditioner is not positive, and [`SolveError::NotFinite`] if a number
/// is not finite; `x` is then meaningless.
pub fn minres(
    operator: &impl LinearOperator,
    preconditioner: &impl Preconditioner,
    b: &[f64],
    x: &mut [f64],
    limits: SolveLimits,
) -> Result<SolveReport, SolveError> {
    let mut work = [(); 8].map(|()| vec![0.0; operator.size()]);
    minres_with_workspace(operator, preconditioner, b, x, limits, &mut work)
}

/// The same with eight work vectors from the caller. Their contents do not matter, except that entries that the operator
/// and the preconditioner do not write must be zero.
///
/// # Errors
/// As [`minres`].
pub fn minres_with_workspace(
    operator: &impl LinearOperator,
    preconditioner: &impl Preconditioner,
    b: &[f64],
    x: &mut [f64],
    limits: SolveLimits,
    work: &mut [Vec<f64>; 8],
) -> Result<SolveReport, SolveError> {
    with_restarts(operator, b, x, limits, work, |x, work, start| {
        iterate(operator, preconditioner, x, work, start, limits)
    })
}

/// Iterates from a true residual until the recursive one is small enough; returns the number of iterations done in all.
fn iterate(
    operator: &impl LinearOperator,
    preconditioner: &impl Preconditioner,
    x: &mut [f64],
    work: &mut [Vec<f64>; 8],
    Start { norm, mut square, mut iterations }: Start,
    SolveLimits { tolerance, max_iterations }: SolveLimits,
) -> Result<usize, SolveError> {
    // `q` holds `A v` and then `β p` of the next iteration, `z` its product with `M`; `w` are the last two directions.
    let [r, q, p, p_last, v, z, w, w_last] = work;
    let failed =
        |iterations, square: f64| SolveError::NotConverged { iterations, residual: square.sqrt(), tolerance };
    [&mut *p_last, &mut *w, &mut *w_last].into_iter().for_each(|vector| vector.fill(0.0));
    vectors::copy(r, p);
    let mut beta = positive_root(preconditioner.apply(p, v), iterations)?;
    let mut reflections = Reflections::new(beta);
    while square.sqrt() > tolerance {
        if iterations == max_iterations || beta == 0.0 {
            return Err(failed(iterations, square));
        }
        vectors::scale(1.0 / beta, p, v);
        let alpha = operator.apply_dot(v, q);
        vectors::orthogonalise(alpha, p, beta, p_last, q);
        let next = positive_root(preconditioner.apply(q, z), iterations)?;
        let step = reflections.advance(alpha, next);
        if !(step.phi.is_finite() && step.gamma.is_finite()) {
            return Err(SolveError::NotFinite { iteration: iterations });
        }
        if step.gamma == 0.0 {
            return Err(failed(iterations, square));
        }
        vectors::next_direction(1.0 / step.gamma, v, step.delta, w, step.epsilon, w_last);
        vectors::axpy(step.phi * norm, w_last, x);
        square = vectors::combine(step.sine * step.sine, -step.phi / step.gamma, q, r);
        iterations += 1;
        if !square.is_finite() {
            return Err(SolveError::NotFinite { iteration: iterations });
        }
        std::mem::swap(w, w_last);
        std::mem::swap(v, z);
        std::mem::swap(p, p_last);
        std::mem::swap(p, q);
        beta = next;
    }
    Ok(iterations)
}

/// The root of a square of the preconditioner's norm; zero where rounding or the preconditioner made it negative.
fn positive_root(square: f64, iteration: usize) -> Result<f64, SolveError> {
    if square.is_finite() { Ok(square.max(0.0).sqrt()) } else { Err(SolveError::NotFinite { iteration }) }
}

/// The reflections `[c s; s −c]` that make the tridiagonal matrix triangular, one a column.
struct Reflections {
    /// Cosine and sine of the last one.
    cosine: f64,
    sine: f64,
    /// Entry above the diagonal of the next column that the last reflection has not met yet.
    delta: f64,
    /// Entry two above its diagonal.
    epsilon: f64,
    /// Last entry of the reflected right-hand side: the norm of the residual in the preconditioner.
    phi: f64,
}

/// A column of the triangular matrix, and what follows from it.
struct Column {
    /// Entries two above, one above and on the diagonal.
    epsilon: f64,
    delta: f64,
    gamma: f64,
    /// Entry of the reflected right-hand side: the step along the column's direction.
    phi: f64,
    /// Sine of its reflection.
    sine: f64,
}

impl Reflections {
    /// No reflection yet; `beta` is the norm of the first residual in the preconditioner.
    fn new(beta: f64) -> Self {
        Self { cosine: -1.0, sine: 0.0, delta: 0.0, epsilon: 0.0, phi: beta }
    }

    /// Reflects the next column, with `alpha` on the diagonal and `beta` below it. If both vanish after the earlier reflections, the
    /// column's `gamma` is zero.
    fn advance(&mut self, alpha: f64, beta: f64) -> Column {
        let (epsilon, delta) = (self.epsilon, self.cosine * self.delta + self.sine * alpha);
        let diagonal = self.sine * self.delta - self.cosine * alpha;
        (self.epsilon, self.delta) = (self.sine * beta, -self.cosine * beta);
        let gamma = diagonal.hypot(beta);
        (self.cosine, self.sine) = if gamma > 0.0 { (diagonal / gamma, beta / gamma) } else { (1.0, 0.0) };
        let phi = self.cosine * self.phi;
        self.phi *= self.sine;
        Column { epsilon, delta, gamma, phi, sine: self.sine }
    }
}
