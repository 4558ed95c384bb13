//! Preconditioned conjugate gradients, for matrices with factors that would be too large: those of large 3D meshes.
//!
//! The preconditioner is additive with two levels: the diagonal blocks (block Jacobi) and the matrix on a coarse lattice (Bramble,
//! Pasciak & Xu 1990).

use super::{BlockMatrix, CoarseFactor, CoarseLattice};
use meniscus_numerics::{Matrix, Vector, par};
use std::sync::Arc;

/// Largest number of iterations.
const MAX_ITERATIONS: usize = 20_000;
/// Fewest rows of a parallel task.
const MIN_ROWS_PER_TASK: usize = 512;

/// Matrix with both triangles, without the rows and columns of anchored vertices, and its preconditioner.
#[derive(Clone, Debug)]
pub struct IterativeInverse<const D: usize> {
    /// Start of each row among the blocks; one more entry than rows.
    starts: Vec<usize>,
    columns: Vec<u32>,
    blocks: Vec<Matrix<D>>,
    /// Inverse of each diagonal block; zero for anchored vertices.
    diagonal: Vec<Matrix<D>>,
    coarse: CoarseFactor,
    /// Bound on the residual over the initial one, in the norm of the preconditioner.
    tolerance: f64,
}

impl<const D: usize> IterativeInverse<D> {
    /// Builds the preconditioner. `None` where the matrix is found not to be positive definite.
    pub fn new(
        matrix: &BlockMatrix<D>,
        anchored: &[bool],
        lattice: &Arc<CoarseLattice>,
        tolerance: f64,
    ) -> Option<Self> {
        let n = anchored.len();
        let mut rows: Vec<Vec<(u32, Matrix<D>)>> = vec![Vec::new(); n];
        for j in (0..n).filter(|j| !anchored[*j]) {
            let start = matrix.pattern.starts[j];
            for (k, i) in matrix.pattern.column(j).iter().enumerate().filter(|(_, i)| !anchored[**i as usize])
            {
                let block = matrix.blocks[start + k];
                rows[*i as usize].push((j as u32, block));
                if k > 0 {
                    rows[j].push((*i, block.transpose()));
                }
            }
        }
        let inverse = |j: usize| match anchored[j] {
            true => Some(Matrix::zeros()),
            false => Some(matrix.blocks[matrix.pattern.starts[j]].cholesky()?.inverse()),
        };
        let diagonal = (0..n).map(inverse).collect::<Option<_>>()?;
        let (mut starts, mut columns, mut blocks) = (vec![0], Vec::new(), Vec::new());
        for row in rows {
            columns.extend(row.iter().map(|r| r.0));
            blocks.extend(row.iter().map(|r| r.1));
            starts.push(blocks.len());
        }
        let coarse = lattice.factorised(&starts, &columns, &blocks)?;
        Some(Self { starts, columns, blocks, diagonal, coarse, tolerance })
    }

    /// `b ← A⁻¹ b` for consecutive right-hand sides of the components of all vertices. Entries of anchored vertices become 0.
    pub fn solve(&self, b: &mut [f64]) {
        for b in b.chunks_exact_mut(D * self.diagonal.len()) {
            let x = self.solved(b.chunks_exact(D).map(Vector::from_column_slice).collect());
            b.chunks_exact_mut(D).zip(x).for_each(|(b, x)| b.copy_from_slice(x.as_slice()));
        }
    }

    /// `A⁻¹ r`; NaN where the iteration does not converge, which the pressure solve reports as its own failure.
    fn solved(&self, mut r: Vec<Vector<D>>) -> Vec<Vector<D>> {
        let dot = |a: &[Vector<D>], b: &[Vector<D>]| par::sum(a.len(), |k| a[k].dot(&b[k]));
        let mut x = vec![Vector::zeros(); r.len()];
        let mut z = self.preconditioned(&r);
        let mut p = z.clone();
        let mut size = dot(&r, &z);
        let target = size * self.tolerance * self.tolerance;
        for _ in 0..MAX_ITERATIONS {
            if size <= target {
                return x;
            }
            if size.is_nan() {
                break;
            }
            let pulled = self.product(&p);
            let step = size / dot(&p, &pulled);
            x.iter_mut().zip(&p).for_each(|(x, p)| *x += p * step);
            r.iter_mut().zip(&pulled).for_each(|(r, q)| *r -= q * step);
            z = self.preconditioned(&r);
            let last = std::mem::replace(&mut size, dot(&r, &z));
            p.iter_mut().zip(&z).for_each(|(p, z)| *p = z + *p * (size / last));
        }
        vec![Vector::repeat(f64::NAN); x.len()]
    }

    fn preconditioned(&self, r: &[Vector<D>]) -> Vec<Vector<D>> {
        let mut z: Vec<Vector<D>> = r.iter().zip(&self.diagonal).map(|(r, inverse)| inverse * r).collect();
        self.coarse.add_correction(r, &mut z);
        z
    }

    fn product(&self, x: &[Vector<D>]) -> Vec<Vector<D>> {
        let row = |i: usize| {
            let all = self.starts[i]..self.starts[i + 1];
            all.map(|k| self.blocks[k] * x[self.columns[k] as usize]).sum()
        };
        par::map(x.len(), MIN_ROWS_PER_TASK, row)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::{CholeskyFactor, Cliques, SparsityPattern, SymbolicFactor};

    /// Positions, anchored flags and matrix of a chain of springs with different masses.
    fn chain(n: usize) -> (Vec<Vector<3>>, Vec<bool>, BlockMatrix<3>) {
        let positions: Vec<Vector<3>> =
            (0..n).map(|i| Vector::<3>::new(i as f64, (i % 7) as f64, (i % 3) as f64)).collect();
        let mut springs = Cliques::default();
        (0..n as u32 - 5).for_each(|i| [1, 2, 5].into_iter().for_each(|k| springs.push([i, i + k])));
        let mut matrix = BlockMatrix::<3>::new(Arc::new(SparsityPattern::new(n, [&springs])));
        for pair in springs.iter() {
            let (i, j) = (pair[0], pair[1]);
            let along = (positions[i as usize] - positions[j as usize]).normalize();
            let block = (along * along.transpose() + Matrix::identity() * 0.1) * 20.0;
            assert!(matrix.add(i, i, &block) && matrix.add(j, j, &block) && matrix.add(i, j, &-block));
        }
        (0..n).for_each(|i| matrix.add_diagonal(i, 1.0 + (i % 4) as f64));
        (positions, (0..n).map(|i| i % 50 == 3).collect(), matrix)
    }

    /// Iterative inverse of the chain's matrix.
    fn iterated(n: usize, tolerance: f64) -> Option<IterativeInverse<3>> {
        let (positions, held, matrix) = chain(n);
        let lattice = CoarseLattice::new(&positions, &matrix.pattern, &held)?;
        IterativeInverse::new(&matrix, &held, &Arc::new(lattice), tolerance)
    }

    #[test]
    fn iterations_give_what_factors_give() {
        let n = 300;
        let (positions, held, matrix) = chain(n);
        let symbolic =
            SymbolicFactor::new(&positions, &matrix.pattern, &held).map(Arc::new).ok_or("no memory");
        let factor = symbolic.map(|s| CholeskyFactor::new(s, &matrix, &held));
        let mut exact: Vec<f64> = (0..6 * n).map(|k| (k as f64 * 0.37).sin()).collect();
        let mut found = exact.clone();
        let iterated = iterated(n, 1e-12);
        assert!(iterated.is_some() && matches!(factor, Ok(Some(_))));
        factor.iter().flatten().for_each(|f| f.solve::<3>(None, &mut exact, 2));
        iterated.iter().for_each(|i| i.solve(&mut found));
        let size = exact.iter().fold(0.0, |s: f64, x| s.max(x.abs()));
        let off = exact.iter().zip(&found).fold(0.0, |s: f64, (a, b)| s.max((a - b).abs()));
        assert!(off < 1e-11 * size, "{off} of {size}");
        assert!(held.iter().enumerate().all(|(v, held)| !held || found[3 * v] == 0.0));
    }

    /// A tolerance below rounding, and a right-hand side of NaN.
    #[test]
    fn what_is_not_solved_is_not_a_number() {
        let n = 100;
        for (tolerance, right) in [(0.0, 1.0), (1e-9, f64::NAN)] {
            let mut b = vec![right; 3 * n];
            iterated(n, tolerance).iter().for_each(|i| i.solve(&mut b));
            assert!(b.iter().all(|b| b.is_nan()));
        }
    }
}
