//! Small dense linear systems.

/// The solution of `A x = b` by Gaussian elimination with row pivoting; `None` if the matrix is singular.
pub fn solve(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Option<Vec<f64>> {
    let n = b.len();
    for k in 0..n {
        let pivot = (k..n).max_by(|&i, &j| a[i][k].abs().total_cmp(&a[j][k].abs()))?;
        a.swap(k, pivot);
        b.swap(k, pivot);
        if a[k][k] == 0.0 || !a[k][k].is_finite() {
            return None;
        }
        let (top, rest) = a.split_at_mut(k + 1);
        let row = &top[k];
        for (i, other) in rest.iter_mut().enumerate() {
            let factor = other[k] / row[k];
            if factor != 0.0 {
                (k..n).for_each(|j| other[j] -= factor * row[j]);
                b[k + 1 + i] -= factor * b[k];
            }
        }
    }
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|j| a[k][j] * b[j]).sum();
        b[k] = (b[k] - known) / a[k][k];
    }
    Some(b)
}

/// The smallest pivot of the Cholesky factorisation over the largest diagonal entry. It is positive if and only if the
/// symmetric matrix is positive definite.
pub fn min_relative_pivot(mut a: Vec<Vec<f64>>) -> f64 {
    let n = a.len();
    let scale = (0..n).map(|i| a[i][i]).fold(0.0, f64::max);
    let mut least = f64::INFINITY;
    for k in 0..n {
        let pivot = a[k][k];
        least = least.min(pivot / scale);
        if pivot <= 0.0 {
            break;
        }
        let (top, rest) = a.split_at_mut(k + 1);
        let row = &top[k];
        for other in rest.iter_mut() {
            let factor = other[k] / pivot;
            if factor != 0.0 {
                (k..n).for_each(|j| other[j] -= factor * row[j]);
            }
        }
    }
    least
}

/// Coefficients `c` that minimise `Σ w (value − c · basis)²`; each sample is a weight, a basis and a value.
pub fn least_squares<const N: usize>(
    samples: impl Iterator<Item = (f64, [f64; N], f64)>,
) -> Option<[f64; N]> {
    let mut a = vec![vec![0.0; N]; N];
    let mut b = vec![0.0; N];
    for (weight, basis, value) in samples {
        for i in 0..N {
            (0..N).for_each(|j| a[i][j] += weight * basis[i] * basis[j]);
            b[i] += weight * basis[i] * value;
        }
    }
    let x = solve(a, b)?;
    Some(std::array::from_fn(|i| x[i]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn systems_are_solved() {
        let a = vec![vec![0.0, 2.0, 1.0], vec![1.0, -1.0, 0.5], vec![3.0, 0.25, -2.0]];
        let x = [1.5, -0.5, 2.0];
        let b = a.iter().map(|row| (0..3).map(|j| row[j] * x[j]).sum()).collect();
        let found = solve(a, b).unwrap();
        (0..3).for_each(|i| assert!((found[i] - x[i]).abs() < 1e-14));
        assert!(solve(vec![vec![1.0, 1.0], vec![1.0, 1.0]], vec![1.0, 2.0]).is_none());
    }

    #[test]
    fn definite_matrices_have_positive_pivots() {
        assert!((min_relative_pivot(vec![vec![4.0, 2.0], vec![2.0, 3.0]]) - 0.5).abs() < 1e-15);
        assert!(min_relative_pivot(vec![vec![1.0, 2.0], vec![2.0, 1.0]]) < 0.0);
    }
}
