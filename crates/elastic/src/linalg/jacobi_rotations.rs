//! Singular values and eigenvalues of 2×2 and 3×3 matrices by Jacobi rotations: accurate to rounding for any matrix, with the same
//! code in both dimensions.

use meniscus_numerics::{Matrix, Vector};

/// Largest number of sweeps; four are typical.
const MAX_SWEEPS: usize = 20;

/// `F = U diag(σ) Vᵀ` with rotations `U` and `V`. The magnitudes of `σ` descend; the last is negative where `det F` is.
#[derive(Clone, Copy, Debug)]
pub struct Svd<const D: usize> {
    pub u: Matrix<D>,
    pub values: Vector<D>,
    pub v: Matrix<D>,
}

/// Singular value decomposition by one-sided rotations (Hestenes 1958), with signs as in Irving et al. 2004, §3.
pub fn svd<const D: usize>(f: &Matrix<D>) -> Svd<D> {
    let (mut w, mut v) = (*f, Matrix::identity());
    for _ in 0..MAX_SWEEPS {
        let mut turned = false;
        for (p, q) in axis_pairs::<D>() {
            let (pp, qq) = (w.column(p).norm_squared(), w.column(q).norm_squared());
            let pq = w.column(p).dot(&w.column(q));
            if pq.abs() > 1e-15 * (pp * qq).sqrt() {
                let (c, s) = jacobi_rotation(pp, qq, pq);
                rotate_columns(&mut w, p, q, c, s);
                rotate_columns(&mut v, p, q, c, s);
                turned = true;
            }
        }
        if !turned {
            break;
        }
    }
    for (p, q) in axis_pairs::<D>() {
        if w.column(p).norm_squared() < w.column(q).norm_squared() {
            // A quarter turn exchanges the columns and preserves the orientation.
            rotate_columns(&mut w, p, q, 0.0, -1.0);
            rotate_columns(&mut v, p, q, 0.0, -1.0);
        }
    }
    let u = completed_rotation(&w);
    Svd { u, values: Vector::from_fn(|k, _| u.column(k).dot(&w.column(k))), v }
}

/// Eigenvalues and eigenvectors (columns) of a symmetric matrix (Golub & Van Loan, §8.5).
pub fn symmetric_eigen<const D: usize>(a: &Matrix<D>) -> (Vector<D>, Matrix<D>) {
    let (mut a, mut v) = (*a, Matrix::identity());
    for _ in 0..MAX_SWEEPS {
        let mut turned = false;
        for (p, q) in axis_pairs::<D>() {
            if a[(p, q)].abs() > 1e-15 * (a[(p, p)].abs() + a[(q, q)].abs()) {
                let (c, s) = jacobi_rotation(a[(p, p)], a[(q, q)], a[(p, q)]);
                rotate_columns(&mut a, p, q, c, s);
                a = a.transpose();
                rotate_columns(&mut a, p, q, c, s);
                rotate_columns(&mut v, p, q, c, s);
                turned = true;
            }
        }
        if !turned {
            break;
        }
    }
    (a.diagonal(), v)
}

/// Pairs of axes `p < q`.
pub(crate) fn axis_pairs<const D: usize>() -> impl Iterator<Item = (usize, usize)> {
    (0..D).flat_map(|p| (p + 1..D).map(move |q| (p, q)))
}

/// Cosine and sine of the rotation that makes columns with these inner products orthogonal.
fn jacobi_rotation(pp: f64, qq: f64, pq: f64) -> (f64, f64) {
    let zeta = (qq - pp) / (2.0 * pq);
    // Where the square overflows the angle correctly vanishes; `hypot` is several times slower.
    let t = 1f64.copysign(zeta) / (zeta.abs() + (1.0 + zeta * zeta).sqrt());
    let c = 1.0 / (1.0 + t * t).sqrt();
    (c, c * t)
}

/// Rotates columns `p` and `q`.
fn rotate_columns<const D: usize>(m: &mut Matrix<D>, p: usize, q: usize, c: f64, s: f64) {
    for row in 0..D {
        let (x, y) = (m[(row, p)], m[(row, q)]);
        m[(row, p)] = c * x - s * y;
        m[(row, q)] = s * x + c * y;
    }
}

/// A rotation whose columns except the last have the directions of those of `w`, which are orthogonal and may vanish.
fn completed_rotation<const D: usize>(w: &Matrix<D>) -> Matrix<D> {
    let mut u = Matrix::<D>::zeros();
    for k in 0..D - 1 {
        let mut along: Vector<D> = w.column(k).into_owned();
        let size = along.norm();
        if size > 1e-150 {
            along /= size;
        }
        // Orthogonalises again against rounding, and tries axes where the column vanishes.
        let axes = (0..D).map(|a| Vector::<D>::from_fn(|r, _| f64::from(r == a)));
        for start in std::iter::once(along).chain(axes) {
            let free = (0..k).fold(start, |x, j| x - u.column(j) * u.column(j).dot(&start));
            if free.norm() > 0.5 {
                u.set_column(k, &free.normalize());
                break;
            }
        }
    }
    let last = if D == 2 {
        Vector::<D>::from_fn(|r, _| if r == 0 { -u[(1, 0)] } else { u[(0, 0)] })
    } else {
        let (i, j) = (D - 3, D - 2);
        Vector::<D>::from_fn(|r, _| {
            let (a, b) = ((r + 1) % D, (r + 2) % D);
            u[(a, i)] * u[(b, j)] - u[(b, i)] * u[(a, j)]
        })
    };
    u.set_column(D - 1, &last);
    u
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check<const D: usize>(f: &Matrix<D>) {
        let size = f.norm().max(1e-300);
        let Svd { u, values, v } = svd(f);
        let back = u * Matrix::from_diagonal(&values) * v.transpose();
        assert!((back - f).norm() < 1e-14 * size, "{f} {back}");
        for r in [u, v] {
            assert!((r.transpose() * r - Matrix::identity()).norm() < 1e-14, "{r}");
            let det = if D == 2 {
                r[(0, 0)] * r[(1, 1)] - r[(0, 1)] * r[(1, 0)]
            } else {
                r.fixed_view::<3, 3>(0, 0).determinant()
            };
            assert!((det - 1.0).abs() < 1e-14);
        }
        for k in 1..D {
            assert!(values[k - 1] >= values[k].abs() - 1e-15 * size && values[k - 1] >= 0.0);
        }
        let a = f + f.transpose();
        let (e, q) = symmetric_eigen(&a);
        assert!((q * Matrix::from_diagonal(&e) * q.transpose() - a).norm() < 1e-14 * size);
    }

    fn many<const D: usize>() {
        let mut s = 7u64;
        let mut random = move || {
            s = s.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (s >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        for k in 0..2000 {
            let mut f = Matrix::<D>::from_fn(|_, _| random());
            match k % 5 {
                1 => f.set_column(0, &Vector::zeros()),
                2 => f = Matrix::identity() * (k as f64),
                3 => f = f.column(0) * f.column(1).transpose(),
                4 => f.column_mut(1).scale_mut(1e-9),
                _ => {}
            }
            check(&f);
        }
        check(&Matrix::<D>::zeros());
    }

    #[test]
    fn decompositions_hold_for_any_matrix() {
        many::<2>();
        many::<3>();
    }
}
