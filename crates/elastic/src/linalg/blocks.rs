//! Symmetric matrices of `D × D` blocks, one for each pair of vertices that pull at each other.

use super::{Cliques, Inverse, Reach, Solver};
use meniscus_numerics::{Matrix, Vector};
use std::sync::Arc;

/// Error of a solve where there are no factors, over the whole.
const TOLERANCE: f64 = 1e-9;

/// Which blocks there are: columns of the lower triangle, rows rising, the diagonal first.
#[derive(Debug, PartialEq)]
pub struct Pattern {
    /// Where each column starts among the blocks; one more than columns.
    pub starts: Vec<usize>,
    /// The row of each block.
    pub rows: Vec<u32>,
}

impl Pattern {
    /// Of `n` vertices in these groups.
    pub fn new<'a>(n: usize, groups: impl IntoIterator<Item = &'a Cliques>) -> Self {
        let mut below: Vec<Vec<u32>> = (0..n).map(|i| vec![i as u32]).collect();
        for group in groups {
            for list in group.iter() {
                for i in list {
                    below[*i as usize].extend(list.iter().filter(|j| *j > i));
                }
            }
        }
        let mut starts = vec![0];
        let mut rows = Vec::new();
        for mut column in below {
            column.sort_unstable();
            column.dedup();
            rows.extend(column);
            starts.push(rows.len());
        }
        Self { starts, rows }
    }

    /// The rows of a column.
    pub fn column(&self, j: usize) -> &[u32] {
        &self.rows[self.starts[j]..self.starts[j + 1]]
    }

    /// Where block `(i, j)`, `i ≥ j`, lies.
    pub(crate) fn slot(&self, i: u32, j: u32) -> Option<usize> {
        let k = self.column(j as usize).binary_search(&i).ok()?;
        Some(self.starts[j as usize] + k)
    }
}

/// A symmetric matrix of `D × D` blocks.
#[derive(Clone, Debug)]
pub struct BlockMatrix<const D: usize> {
    pub(crate) pattern: Arc<Pattern>,
    pub(crate) blocks: Vec<Matrix<D>>,
}

impl<const D: usize> BlockMatrix<D> {
    /// Zero.
    pub(crate) fn new(pattern: Arc<Pattern>) -> Self {
        let blocks = vec![Matrix::zeros(); pattern.rows.len()];
        Self { pattern, blocks }
    }

    /// Adds to block `(i, j)` and its transpose to `(j, i)`; on the diagonal the block must be symmetric. Returns `false`,
    /// and adds nothing, where the two vertices are in no common element or spring.
    #[must_use]
    pub fn add(&mut self, i: u32, j: u32, block: &Matrix<D>) -> bool {
        let Some(slot) = self.pattern.slot(i.max(j), i.min(j)) else { return false };
        if i >= j {
            self.blocks[slot] += block;
        } else {
            self.blocks[slot] += block.transpose();
        }
        true
    }

    /// Adds to a block of the diagonal.
    pub(crate) fn add_diagonal(&mut self, i: usize, value: f64) {
        self.blocks[self.pattern.starts[i]] += Matrix::identity() * value;
    }

    /// `y ← y + A x`.
    pub fn add_product(&self, x: &[Vector<D>], y: &mut [Vector<D>]) {
        for j in 0..x.len() {
            let start = self.pattern.starts[j];
            y[j] += self.blocks[start] * x[j];
            for slot in start + 1..self.pattern.starts[j + 1] {
                let i = self.pattern.rows[slot] as usize;
                y[i] += self.blocks[slot] * x[j];
                y[j] += self.blocks[slot].tr_mul(&x[i]);
            }
        }
    }

    /// The sum of the diagonal.
    pub(crate) fn trace(&self) -> f64 {
        (0..self.pattern.starts.len() - 1).map(|j| self.blocks[self.pattern.starts[j]].trace()).sum()
    }
}

/// Matrices put together.
impl<const D: usize> BlockMatrix<D> {
    /// Of `count` vertices: matrices of some of them, each with the number of its first vertex, on the diagonal, and zero blocks
    /// between all vertices of each group.
    pub fn assembled(count: usize, parts: &[(usize, &Self)], groups: &Cliques) -> Self {
        let mut below: Vec<Vec<u32>> = (0..count).map(|i| vec![i as u32]).collect();
        for (first, part) in parts {
            for j in 0..part.pattern.starts.len() - 1 {
                let rows = part.pattern.column(j).iter().map(|i| i + *first as u32);
                below[first + j].extend(rows);
            }
        }
        for list in groups.iter() {
            for i in list {
                below[*i as usize].extend(list.iter().filter(|j| *j > i));
            }
        }
        let (mut starts, mut rows) = (vec![0], Vec::new());
        for mut column in below {
            column.sort_unstable();
            column.dedup();
            rows.extend(column);
            starts.push(rows.len());
        }
        let mut whole = Self::new(Arc::new(Pattern { starts, rows }));
        for (first, part) in parts {
            for j in 0..part.pattern.starts.len() - 1 {
                for slot in part.pattern.starts[j]..part.pattern.starts[j + 1] {
                    let row = part.pattern.rows[slot] + *first as u32;
                    if let Some(to) = whole.pattern.slot(row, (first + j) as u32) {
                        whole.blocks[to] = part.blocks[slot];
                    }
                }
            }
        }
        whole
    }

    /// Its inverse, applied; `positions` are where vertices are, which tells in what order they are best eliminated. Nothing where
    /// the matrix is not positive definite, to rounding.
    pub fn invert(&self, positions: &[Vector<D>], held: &[bool]) -> Option<Solution<D>> {
        let solver = Solver::new(positions, &self.pattern, held)?;
        Some(Solution(solver.invert(self, held, TOLERANCE)?))
    }
}

/// The inverse of a matrix, applied.
#[derive(Clone, Debug)]
pub struct Solution<const D: usize>(Inverse<D>);

impl<const D: usize> Solution<D> {
    /// `b ← A⁻¹ b`; what belongs to held vertices becomes 0.
    pub fn solve(&self, b: &mut [Vector<D>]) {
        let mut flat: Vec<f64> = b.iter().flat_map(|v| v.iter().copied()).collect();
        self.0.solve(None, &mut flat, 1);
        b.iter_mut().zip(flat.chunks_exact(D)).for_each(|(b, x)| b.copy_from_slice(x));
    }

    /// What right-hand sides that act on some vertices only need for the solution at these.
    pub fn reach(&self, vertices: impl Iterator<Item = u32>) -> Reach {
        self.0.reach(vertices)
    }

    /// `b ← A⁻¹ b` at the vertices of a reach, for `count` right-hand sides one after another that are 0 at all others.
    pub fn solve_within(&self, reach: &Reach, b: &mut [f64], count: usize) {
        self.0.solve(Some(reach), b, count);
    }
}
