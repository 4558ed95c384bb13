//! The Jacobi preconditioner.

use super::operator::Preconditioner;
use super::{Real, vectors};
use crate::par;

/// Entries per task.
const CHUNK: usize = 1 << 14;

/// Division by the diagonal.
#[derive(Clone, Debug)]
pub struct Jacobi<T: Real = f64> {
    /// The inverse of the diagonal.
    pub(super) inverse: Vec<T>,
}

impl<T: Real> Jacobi<T> {
    /// Division by a diagonal whose inverse is given.
    pub fn of_inverse(inverse: Vec<T>) -> Self {
        Self { inverse }
    }

    /// Inverts the operator's diagonal; entries that are not positive get the inverse 0.
    pub fn new(diagonal: &[f64]) -> Self {
        let of = |d: &f64| T::from_f64(if *d > 0.0 { 1.0 / d } else { 0.0 });
        Self { inverse: par::map_slice(diagonal, CHUNK, of) }
    }
}

impl<T: Real> Preconditioner<T> for Jacobi<T> {
    fn apply(&self, r: &[T], z: &mut [T]) -> f64 {
        let parts = par::map_chunks_mut([z], CHUNK, |range, [z]| {
            let (r, inverse) = (&r[range.clone()], &self.inverse[range]);
            z.iter_mut().zip(r.iter().zip(inverse)).for_each(|(z, (r, i))| *z = *r * *i);
            vectors::dot_serial(z, r)
        });
        parts.iter().sum()
    }

    fn subtract_and_apply(&self, alpha: f64, q: &mut [T], r: &mut [T]) -> (f64, Option<f64>) {
        let [square, product] = vectors::subtract_scaled_and_multiply(alpha, &self.inverse, q, r);
        (square, Some(product))
    }
}
