//! Sparse Cholesky factors of block matrices, without the rows and columns of anchored vertices.

use super::block_matrix::{BlockMatrix, SparsityPattern};
use super::subtrees::Subtrees;
use super::{dissection, multifrontal};
use faer::perm::PermRef;
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::supernodal::{SupernodalLltRef, SymbolicSupernodalCholesky};
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::{Mat, Side};
use meniscus_numerics::{Vector, par};
use std::sync::{Arc, Mutex, PoisonError};

/// Symbolic factorisation, shared by all matrices of one pattern.
#[derive(Debug)]
pub struct SymbolicFactor {
    /// Vertices that are not anchored, ascending.
    free: Vec<u32>,
    /// Row of the factor for each component of the free vertices.
    rows: Vec<usize>,
    /// Index among the values of a factor of each matrix entry, in the order of [`for_each_entry`].
    value_indices: Vec<usize>,
    cholesky: SymbolicCholesky<usize>,
    pub(super) subtrees: Subtrees,
    /// Memory of a dropped factor: threads that request memory from the system wait for each other.
    recycled_values: Mutex<Vec<f64>>,
}

impl SymbolicFactor {
    /// Symbolic factor of matrices of this pattern without `anchored` vertices. `None` where there is not enough memory.
    pub fn new<const D: usize>(
        positions: &[Vector<D>],
        pattern: &SparsityPattern,
        anchored: &[bool],
    ) -> Option<Self> {
        let free: Vec<u32> = (0..anchored.len() as u32).filter(|v| !anchored[*v as usize]).collect();
        let mut number = vec![usize::MAX; anchored.len()];
        free.iter().enumerate().for_each(|(k, v)| number[*v as usize] = k);
        let order: Vec<usize> = dissection::nested_dissection(positions, pattern, free.clone())
            .iter()
            .flat_map(|v| (0..D).map(|a| number[*v as usize] * D + a))
            .collect();
        let n = order.len();
        let mut rows = vec![0; n];
        order.iter().enumerate().for_each(|(row, k)| rows[*k] = row);
        let mut below: Vec<Vec<usize>> = vec![Vec::new(); n];
        let component = |vertex: u32, axis: usize| number[vertex as usize] * D + axis;
        for_each_entry::<D>(pattern, &free, anchored, |_, (i, a), (j, b)| {
            below[component(j, b)].push(component(i, a))
        });
        let columns: Vec<usize> = std::iter::once(0)
            .chain(below.iter().scan(0, |sum, column| {
                *sum += column.len();
                Some(*sum)
            }))
            .collect();
        let cholesky = factorize_symbolic_cholesky(
            SymbolicSparseColMatRef::new_checked(n, n, &columns, None, &below.concat()),
            Side::Lower,
            SymmetricOrdering::Custom(PermRef::new_checked(&order, &rows, n)),
            CholeskySymbolicParams {
                supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
                ..Default::default()
            },
        )
        .ok()?;
        let supernodes = supernodes(&cholesky)?;
        let mut value_indices = Vec::with_capacity(columns[n]);
        for_each_entry::<D>(pattern, &free, anchored, |_, (i, a), (j, b)| {
            value_indices.push(value_index(supernodes, rows[component(i, a)], rows[component(j, b)]));
        });
        let subtrees = Subtrees::new(supernodes);
        Some(Self { free, rows, value_indices, cholesky, subtrees, recycled_values: Mutex::default() })
    }

    /// Number of entries of a factor.
    pub fn entries(&self) -> usize {
        self.cholesky.len_val()
    }

    /// Zero values of a factor.
    fn zeros(&self) -> Vec<f64> {
        let mut values =
            std::mem::take(&mut *self.recycled_values.lock().unwrap_or_else(PoisonError::into_inner));
        par::map_chunks_mut([&mut values], 1 << 16, |_, [chunk]| chunk.fill(0.0));
        values.resize(self.entries(), 0.0);
        values
    }
}

/// Calls `f` with each entry of a symmetric matrix's lower triangle: its block, its row and its column, the latter two as vertex
/// and axis. Entries of `anchored` vertices are left out.
fn for_each_entry<const D: usize>(
    pattern: &SparsityPattern,
    free: &[u32],
    anchored: &[bool],
    mut f: impl FnMut(usize, (u32, usize), (u32, usize)),
) {
    for j in free {
        let start = pattern.starts[*j as usize];
        for (k, i) in pattern.column(*j as usize).iter().enumerate().filter(|(_, i)| !anchored[**i as usize])
        {
            for b in 0..D {
                (if k == 0 { b } else { 0 }..D).for_each(|a| f(start + k, (*i, a), (*j, b)));
            }
        }
    }
}

/// Supernodes of a factor.
fn supernodes(cholesky: &SymbolicCholesky<usize>) -> Option<&SymbolicSupernodalCholesky<usize>> {
    match cholesky.raw() {
        SymbolicCholeskyRaw::Supernodal(supernodes) => Some(supernodes),
        SymbolicCholeskyRaw::Simplicial(_) => None,
    }
}

/// Index of an entry among the values of a factor.
fn value_index(supernodes: &SymbolicSupernodalCholesky<usize>, i: usize, j: usize) -> usize {
    let (row, column) = (i.max(j), i.min(j));
    let node = supernodes.supernode_begin().partition_point(|begin| *begin <= column) - 1;
    let (begin, end) = (supernodes.supernode_begin()[node], supernodes.supernode_end()[node]);
    let pattern = supernodes.supernode(node).pattern();
    let down = if row < end { row - begin } else { end - begin + pattern.partition_point(|r| *r < row) };
    supernodes.col_ptr_for_val()[node] + (column - begin) * (end - begin + pattern.len()) + down
}

/// Cholesky factor of a matrix.
#[derive(Clone, Debug)]
pub struct CholeskyFactor {
    symbolic: Arc<SymbolicFactor>,
    values: Vec<f64>,
}

impl CholeskyFactor {
    /// Factorises a matrix. `None` where it is numerically not positive definite.
    pub fn new<const D: usize>(
        symbolic: Arc<SymbolicFactor>,
        matrix: &BlockMatrix<D>,
        anchored: &[bool],
    ) -> Option<Self> {
        let mut values = symbolic.zeros();
        let mut places = symbolic.value_indices.iter();
        for_each_entry::<D>(&matrix.pattern, &symbolic.free, anchored, |block, (_, a), (_, b)| {
            places.next().into_iter().for_each(|place| values[*place] = matrix.blocks[block][(a, b)]);
        });
        multifrontal::factorise(supernodes(&symbolic.cholesky)?, &symbolic.subtrees, &mut values)?;
        Some(Self { symbolic, values })
    }

    /// The parts of the factor that the solution at some vertices needs if right-hand sides are zero at all others.
    pub fn reach<const D: usize>(&self, vertices: impl Iterator<Item = u32>) -> Option<Subtrees> {
        let symbolic = &self.symbolic;
        let free = vertices.filter_map(|v| symbolic.free.binary_search(&v).ok());
        let rows = free.flat_map(|k| symbolic.rows[k * D..(k + 1) * D].iter().copied());
        Some(symbolic.subtrees.restricted_to_reach(supernodes(&symbolic.cholesky)?, rows))
    }

    /// `b ← A⁻¹ b` for `count` consecutive right-hand sides of the components of all vertices. Entries of anchored vertices become
    /// zero. With a `reach` the solution is valid at its vertices, if right-hand sides are zero at all others.
    pub fn solve<const D: usize>(&self, reach: Option<&Subtrees>, b: &mut [f64], count: usize) {
        let (symbolic, Some(supernodes)) = (&self.symbolic, supernodes(&self.symbolic.cholesky)) else {
            return;
        };
        let Some(length) = b.len().checked_div(count) else { return };
        let mut x = Mat::zeros(symbolic.rows.len(), count);
        let component = |k: usize| symbolic.free[k / D] as usize * D + k % D;
        for (j, all) in b.chunks_exact(length).enumerate() {
            symbolic.rows.iter().enumerate().for_each(|(k, row)| x[(*row, j)] = all[component(k)]);
        }
        let subtrees = reach.unwrap_or(&symbolic.subtrees);
        subtrees.solve(SupernodalLltRef::new(supernodes, &self.values), &mut x);
        for (j, all) in b.chunks_exact_mut(length).enumerate() {
            all.fill(0.0);
            symbolic.rows.iter().enumerate().for_each(|(k, row)| all[component(k)] = x[(*row, j)]);
        }
    }
}

impl Drop for CholeskyFactor {
    fn drop(&mut self) {
        *self.symbolic.recycled_values.lock().unwrap_or_else(PoisonError::into_inner) =
            std::mem::take(&mut self.values);
    }
}
