//! Multifrontal Cholesky factorisation (J. Liu, SIAM Review 34 (1992) 82): each supernode adds the update matrices of its children
//! to its front, eliminates its columns, and passes an update matrix to its parent.
//!
//! The independent parts of [`Subtrees`] are factorised in parallel; above them the work on large fronts is divided. Updates are
//! added part by part, within each in the order of the supernodes, and the division depends on sizes only: results are bitwise
//! identical for any number of threads.

use super::subtrees::Subtrees;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{cholesky_in_place, cholesky_in_place_scratch};
use faer::linalg::matmul;
use faer::linalg::matmul::triangular::BlockStructure;
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::prelude::ReborrowMut;
use faer::sparse::linalg::cholesky::supernodal::SymbolicSupernodalCholesky;
use faer::{Accum, MatMut, MatRef, Par};
use meniscus_numerics::par;
use std::collections::BTreeMap;

/// Number of columns or rows that are not divided among threads.
const MAX_SERIAL_SIZE: usize = 256;

/// A supernode and its values in the factor.
type SupernodeValues<'a> = (usize, &'a mut [f64]);

/// Update matrices of the children of a supernode: the lower triangle on the rows of the child's pattern.
type UpdateMatrices = Vec<(usize, Vec<f64>)>;

/// Overwrites `values`, the lower triangle of `L Lᵀ`, with `L`. `None` where the matrix is numerically not positive definite.
pub fn factorise(
    supernodes: &SymbolicSupernodalCholesky<usize>,
    subtrees: &Subtrees,
    mut values: &mut [f64],
) -> Option<()> {
    let mut slabs = Vec::with_capacity(supernodes.n_supernodes());
    for ends in supernodes.col_ptr_for_val().windows(2) {
        let (slab, rest) = values.split_at_mut(ends[1] - ends[0]);
        slabs.push(Some(slab));
        values = rest;
    }
    let mut slabs_of = |nodes: &[usize]| -> Vec<SupernodeValues<'_>> {
        nodes.iter().filter_map(|s| slabs[*s].take().map(|slab| (*s, slab))).collect()
    };
    let parts: Vec<_> = subtrees.parts.iter().map(|nodes| slabs_of(nodes)).collect();
    let above = slabs_of(&subtrees.ancestors);
    let done = par::map_jobs(parts, |part| eliminate(supernodes, subtrees, part, BTreeMap::new()));
    let done: Option<Vec<_>> = done.into_iter().collect();
    let mut left: BTreeMap<usize, UpdateMatrices> = BTreeMap::new();
    done?.into_iter().flatten().for_each(|(node, rests)| left.entry(node).or_default().extend(rests));
    eliminate(supernodes, subtrees, above, left).map(drop)
}

/// Eliminates the columns of ascending supernodes with the updates in `left`; returns the updates for other supernodes.
fn eliminate(
    supernodes: &SymbolicSupernodalCholesky<usize>,
    subtrees: &Subtrees,
    nodes: Vec<SupernodeValues<'_>>,
    mut left: BTreeMap<usize, UpdateMatrices>,
) -> Option<BTreeMap<usize, UpdateMatrices>> {
    // Reused memory: the system is slow to provide large blocks.
    let mut spare: Vec<Vec<f64>> = Vec::new();
    for (node, slab) in nodes {
        let (own, rows) = (supernodes.supernode_end()[node], supernodes.supernode(node).pattern());
        let own = own - supernodes.supernode_begin()[node];
        let mut rest = spare.pop().unwrap_or_default();
        rest.clear();
        rest.resize(rows.len() * rows.len(), 0.0);
        let mut front = Front {
            pivot_columns: MatMut::from_column_major_slice_mut(slab, own + rows.len(), own),
            update_matrix: MatMut::from_column_major_slice_mut(&mut rest, rows.len(), rows.len()),
        };
        for (child, update) in left.remove(&node).unwrap_or_default() {
            front.extend_add(&relative_indices(supernodes, child, node), &update)?;
            spare.push(update);
        }
        front.eliminate()?;
        if let Some(parent) = subtrees.parents[node] {
            left.entry(parent).or_default().push((node, rest));
        }
    }
    Some(left)
}

/// Positions of the rows of a child's pattern in the front of `node`.
fn relative_indices(supernodes: &SymbolicSupernodalCholesky<usize>, child: usize, node: usize) -> Vec<usize> {
    let (begin, end) = (supernodes.supernode_begin()[node], supernodes.supernode_end()[node]);
    let pattern = supernodes.supernode(node).pattern();
    let mut k = 0;
    let place = |row: &usize| {
        if *row < end {
            return row - begin;
        }
        k += pattern[k..].iter().take_while(|r| *r < row).count();
        end - begin + k
    };
    supernodes.supernode(child).pattern().iter().map(place).collect()
}

/// Front: the columns that are eliminated and the remaining lower triangle.
struct Front<'a> {
    pivot_columns: MatMut<'a, f64>,
    update_matrix: MatMut<'a, f64>,
}

impl Front<'_> {
    /// Adds the lower triangle of an update matrix whose rows have these ascending positions in the front.
    fn extend_add(&mut self, to: &[usize], update: &[f64]) -> Option<()> {
        let own = self.pivot_columns.ncols();
        let (now, later) = to.split_at(to.partition_point(|i| *i < own));
        let (first, second) = update.split_at(now.len() * to.len());
        let mut slab = || scatter_add(self.pivot_columns.rb_mut(), 0, to, now, first);
        let mut rest = || scatter_add(self.update_matrix.rb_mut(), own, later, later, second);
        let (slab, rest) =
            if to.len() > MAX_SERIAL_SIZE { rayon::join(slab, rest) } else { (slab(), rest()) };
        slab.and(rest)
    }

    /// Eliminates the pivot columns.
    fn eliminate(&mut self) -> Option<()> {
        let own = self.pivot_columns.ncols();
        let (mut diagonal, mut below) = self.pivot_columns.rb_mut().split_at_row_mut(own);
        cholesky(diagonal.rb_mut())?;
        solve_lower_transposed(diagonal.as_ref(), below.rb_mut());
        subtract_syrk(self.update_matrix.rb_mut(), below.as_ref());
        Some(())
    }
}

/// Adds a lower triangle to that of `a`; its rows and columns have the positions `rows` and `columns` there, minus `shift`.
fn scatter_add(
    mut a: MatMut<'_, f64>,
    shift: usize,
    rows: &[usize],
    columns: &[usize],
    update: &[f64],
) -> Option<()> {
    let height = update.len() / columns.len().max(1);
    for (j, to) in columns.iter().enumerate() {
        let into = a.rb_mut().col_mut(to - shift).try_as_col_major_mut()?;
        let (into, from) =
            (into.as_slice_mut(), &update[j * height + height - rows.len() + j..(j + 1) * height]);
        rows[j..].iter().zip(from).for_each(|(i, value)| into[i - shift] += value);
    }
    Some(())
}

/// `A ← L` with `L Lᵀ = A`, lower triangles.
fn cholesky(mut a: MatMut<'_, f64>) -> Option<()> {
    let n = a.nrows();
    if n <= 2 * MAX_SERIAL_SIZE {
        let scratch = cholesky_in_place_scratch::<f64>(n, Par::Seq, Default::default());
        let mut memory = MemBuffer::try_new(scratch).ok()?;
        let stack = MemStack::new(&mut memory);
        return cholesky_in_place(a, Default::default(), Par::Seq, stack, Default::default()).ok().map(drop);
    }
    let (mut first, _, mut below, mut second) = a.rb_mut().split_at_mut(n / 2, n / 2);
    cholesky(first.rb_mut())?;
    solve_lower_transposed(first.as_ref(), below.rb_mut());
    subtract_syrk(second.rb_mut(), below.as_ref());
    cholesky(second)
}

/// `B ← B L⁻ᵀ`.
fn solve_lower_transposed(lower: MatRef<'_, f64>, b: MatMut<'_, f64>) {
    if b.nrows() <= 2 * MAX_SERIAL_SIZE || lower.nrows() <= MAX_SERIAL_SIZE {
        return solve_lower_triangular_in_place(lower, b.transpose_mut(), Par::Seq);
    }
    let half = b.nrows() / 2;
    let (first, second) = b.split_at_row_mut(half);
    rayon::join(|| solve_lower_transposed(lower, first), || solve_lower_transposed(lower, second));
}

/// `C ← C − B Bᵀ`, lower triangle.
fn subtract_syrk(c: MatMut<'_, f64>, b: MatRef<'_, f64>) {
    let (lower, all) = (BlockStructure::TriangularLower, BlockStructure::Rectangular);
    let n = c.nrows();
    if n <= 2 * MAX_SERIAL_SIZE || b.ncols() <= MAX_SERIAL_SIZE {
        return matmul::triangular::matmul(c, lower, Accum::Add, b, all, b.transpose(), all, -1.0, Par::Seq);
    }
    let (above, below) = b.split_at_row(n / 2);
    let (first, _, between, second) = c.split_at_mut(n / 2, n / 2);
    let corners = || {
        subtract_syrk(first, above);
        subtract_syrk(second, below);
    };
    let product = || matmul::matmul(between, Accum::Add, below, above.transpose(), -1.0, Par::Seq);
    rayon::join(corners, product);
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::Mat;

    /// The matrix is large enough to be divided several times.
    #[test]
    fn divided_work_is_the_same_for_all_threads() {
        let n = 3 * MAX_SERIAL_SIZE + 40;
        let entry = |i: usize, j: usize| if i == j { n as f64 } else { ((i * j) as f64).cos() };
        let factor = |threads| {
            let mut a = Mat::from_fn(n, n, entry);
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let done = pool.map(|pool| pool.install(|| cholesky(a.as_mut())));
            assert!(matches!(done, Ok(Some(()))));
            Mat::from_fn(n, n, |i, j| if i >= j { a[(i, j)] } else { 0.0 })
        };
        let l = factor(1);
        assert!(l == factor(3));
        let product = &l * l.transpose();
        let off = |i: usize, j: usize| (product[(i, j)] - entry(i, j)).abs();
        let most = (0..n).flat_map(|j| (0..n).map(move |i| off(i, j))).fold(0.0, f64::max);
        assert!(most < 1e-11, "{most}");
    }
}
