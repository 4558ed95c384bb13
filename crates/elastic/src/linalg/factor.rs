//! Cholesky factors of block matrices, without the rows and columns of vertices that are held.
//!
//! `faer` finds factors, on one thread: they are then the same bits however many there are. [`Subtrees`] solves with them.

use super::blocks::{BlockMatrix, Pattern};
use super::dissection;
use super::subtrees::Subtrees;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::perm::PermRef;
use faer::sparse::linalg::cholesky::supernodal::SupernodalLltRef;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, Mat, MatMut, Par, Side};
use meniscus_numerics::Vector;
use std::sync::Arc;

/// What all factors of matrices with one pattern share.
#[derive(Debug)]
pub struct Symbolic {
    /// The vertices that are not held, rising.
    free: Vec<u32>,
    columns: Vec<usize>,
    rows: Vec<usize>,
    cholesky: SymbolicCholesky<usize>,
    /// None of a factor so sparse that it has no supernodes.
    pub(super) subtrees: Option<Subtrees>,
}

impl Symbolic {
    /// For matrices of this pattern; `held` vertices are left out. Nothing where memory does not suffice.
    pub fn new<const D: usize>(positions: &[Vector<D>], pattern: &Pattern, held: &[bool]) -> Option<Self> {
        let free: Vec<u32> = (0..held.len() as u32).filter(|v| !held[*v as usize]).collect();
        let mut number = vec![usize::MAX; held.len()];
        free.iter().enumerate().for_each(|(k, v)| number[*v as usize] = k);
        let (mut columns, mut rows) = (vec![0], Vec::new());
        for j in &free {
            for b in 0..D {
                for (k, i) in pattern.column(*j as usize).iter().enumerate() {
                    let at = number[*i as usize];
                    if at != usize::MAX {
                        rows.extend((if k == 0 { b } else { 0 }..D).map(|a| at * D + a));
                    }
                }
                columns.push(rows.len());
            }
        }
        let order = dissection::order(positions, pattern, free.clone());
        let forward: Vec<usize> =
            order.iter().flat_map(|v| (0..D).map(|a| number[*v as usize] * D + a)).collect();
        let mut inverse = vec![0; forward.len()];
        forward.iter().enumerate().for_each(|(k, v)| inverse[*v] = k);
        let n = forward.len();
        let cholesky = factorize_symbolic_cholesky(
            SymbolicSparseColMatRef::new_checked(n, n, &columns, None, &rows),
            Side::Lower,
            SymmetricOrdering::Custom(PermRef::new_checked(&forward, &inverse, n)),
            CholeskySymbolicParams::default(),
        )
        .ok()?;
        let subtrees = match cholesky.raw() {
            SymbolicCholeskyRaw::Supernodal(symbolic) => Some(Subtrees::new(symbolic)),
            SymbolicCholeskyRaw::Simplicial(_) => None,
        };
        Some(Self { free, columns, rows, cholesky, subtrees })
    }

    /// Entries of a factor.
    pub fn entries(&self) -> usize {
        self.cholesky.len_val()
    }

    /// The values of a matrix in the order of `rows`.
    fn values<const D: usize>(&self, matrix: &BlockMatrix<D>, held: impl Fn(u32) -> bool) -> Vec<f64> {
        let mut values = Vec::with_capacity(self.rows.len());
        for j in &self.free {
            let start = matrix.pattern.starts[*j as usize];
            for b in 0..D {
                for (k, i) in matrix.pattern.column(*j as usize).iter().enumerate() {
                    if !held(*i) {
                        let block = &matrix.blocks[start + k];
                        values.extend((if k == 0 { b } else { 0 }..D).map(|a| block[(a, b)]));
                    }
                }
            }
        }
        values
    }
}

/// The Cholesky factor of a matrix.
#[derive(Clone, Debug)]
pub struct Factor {
    symbolic: Arc<Symbolic>,
    values: Vec<f64>,
}

impl Factor {
    /// Nothing where the matrix is not positive definite, to rounding.
    pub fn new<const D: usize>(
        symbolic: Arc<Symbolic>,
        matrix: &BlockMatrix<D>,
        held: &[bool],
    ) -> Option<Self> {
        let entries = symbolic.values(matrix, |v| held[v as usize]);
        let n = symbolic.free.len() * D;
        let mut values = vec![0.0; symbolic.cholesky.len_val()];
        let params = Default::default();
        let scratch = symbolic.cholesky.factorize_numeric_llt_scratch::<f64>(Par::Seq, params);
        let mut memory = MemBuffer::try_new(scratch).ok()?;
        symbolic
            .cholesky
            .factorize_numeric_llt(
                &mut values,
                SparseColMatRef::new(
                    SymbolicSparseColMatRef::new_checked(n, n, &symbolic.columns, None, &symbolic.rows),
                    &entries,
                ),
                Side::Lower,
                LltRegularization::default(),
                Par::Seq,
                MemStack::new(&mut memory),
                params,
            )
            .ok()?;
        Some(Self { symbolic, values })
    }

    /// `b ← A⁻¹ b` for `count` right-hand sides of all vertices' components, one after another. What belongs to held
    /// vertices becomes 0.
    pub fn solve<const D: usize>(&self, b: &mut [f64], count: usize) {
        let n = self.symbolic.free.len() * D;
        let Some(length) = b.len().checked_div(count) else { return };
        let mut packed = vec![0.0; n * count];
        for (all, free) in b.chunks_exact_mut(length).zip(packed.chunks_exact_mut(n)) {
            for (k, v) in self.symbolic.free.iter().enumerate() {
                free[k * D..(k + 1) * D].copy_from_slice(&all[*v as usize * D..(*v as usize + 1) * D]);
            }
        }
        self.solve_packed(MatMut::from_column_major_slice_mut(&mut packed, n, count));
        for (all, free) in b.chunks_exact_mut(length).zip(packed.chunks_exact(n)) {
            all.fill(0.0);
            for (k, v) in self.symbolic.free.iter().enumerate() {
                all[*v as usize * D..(*v as usize + 1) * D].copy_from_slice(&free[k * D..(k + 1) * D]);
            }
        }
    }

    /// The same for the components of vertices that are not held.
    fn solve_packed(&self, mut b: MatMut<'_, f64>) {
        let cholesky = &self.symbolic.cholesky;
        let (Some(subtrees), SymbolicCholeskyRaw::Supernodal(symbolic), Some(order)) =
            (&self.symbolic.subtrees, cholesky.raw(), cholesky.perm())
        else {
            let scratch = cholesky.solve_in_place_scratch::<f64>(b.ncols(), Par::Seq);
            let mut memory = MemBuffer::new(scratch);
            let factor = LltRef::new(cholesky, &self.values);
            return factor.solve_in_place_with_conj(Conj::No, b, Par::Seq, MemStack::new(&mut memory));
        };
        let (order, _) = order.arrays();
        let mut x = Mat::from_fn(b.nrows(), b.ncols(), |i, j| b[(order[i], j)]);
        subtrees.solve(SupernodalLltRef::new(symbolic, &self.values), &mut x);
        for j in 0..b.ncols() {
            order.iter().enumerate().for_each(|(i, to)| b[(*to, j)] = x[(i, j)]);
        }
    }
}
