//! Symmetric matrices of `D × D` blocks, one for each pair of coupled vertices.

use super::Cliques;
use meniscus_numerics::{Matrix, Vector};
use std::sync::Arc;

/// Blocks of the lower triangle in compressed columns: rows ascending, the diagonal first.
#[derive(Debug, PartialEq)]
pub struct SparsityPattern {
    /// Start of each column among the blocks; one more entry than columns.
    pub starts: Vec<usize>,
    /// Row of each block.
    pub rows: Vec<u32>,
}

impl SparsityPattern {
    /// Pattern of `n` vertices with blocks between all vertices of each group.
    pub fn new<'a>(n: usize, groups: impl IntoIterator<Item = &'a Cliques>) -> Self {
        let mut below: Vec<Vec<u32>> = (0..n).map(|i| vec![i as u32]).collect();
        groups.into_iter().for_each(|group| add_clique_pairs(&mut below, group));
        Self::of_columns(below)
    }

    /// Block-diagonal pattern on `n` vertices of several patterns, each given with the number of its first vertex.
    pub fn block_diagonal(n: usize, parts: &[(usize, &Self)]) -> Self {
        let mut below: Vec<Vec<u32>> = (0..n).map(|i| vec![i as u32]).collect();
        for (first, part) in parts {
            for j in 0..part.starts.len() - 1 {
                below[first + j].extend(part.column(j).iter().map(|i| i + *first as u32));
            }
        }
        Self::of_columns(below)
    }

    /// This pattern with blocks added between all vertices of each group.
    pub fn with(&self, groups: &Cliques) -> Self {
        let mut below: Vec<Vec<u32>> = (0..self.starts.len() - 1).map(|j| self.column(j).to_vec()).collect();
        add_clique_pairs(&mut below, groups);
        Self::of_columns(below)
    }

    fn of_columns(below: Vec<Vec<u32>>) -> Self {
        let (mut starts, mut rows) = (vec![0], Vec::new());
        for mut column in below {
            column.sort_unstable();
            column.dedup();
            rows.extend(column);
            starts.push(rows.len());
        }
        Self { starts, rows }
    }

    /// Whether the pattern has all blocks of each group.
    pub fn contains(&self, groups: &Cliques) -> bool {
        groups
            .iter()
            .all(|list| list.iter().all(|i| list.iter().all(|j| i < j || self.slot(*i, *j).is_some())))
    }

    /// Rows of a column.
    pub fn column(&self, j: usize) -> &[u32] {
        &self.rows[self.starts[j]..self.starts[j + 1]]
    }

    /// A block of a matrix of this pattern that stands at `(i, j)`, with its transpose at `(j, i)`. `None` where the pattern has no block
    /// of the two vertices.
    pub(crate) fn place<const D: usize>(&self, i: u32, j: u32, block: Matrix<D>) -> Option<PlacedBlock<D>> {
        let slot = self.slot(i.max(j), i.min(j))?;
        Some(PlacedBlock { slot, block: if i >= j { block } else { block.transpose() } })
    }

    /// Index of block `(i, j)`, `i ≥ j`.
    pub(crate) fn slot(&self, i: u32, j: u32) -> Option<usize> {
        let k = self.column(j as usize).binary_search(&i).ok()?;
        Some(self.starts[j as usize] + k)
    }
}

/// Adds the pairs of each group to the columns.
fn add_clique_pairs(below: &mut [Vec<u32>], groups: &Cliques) {
    for list in groups.iter() {
        for i in list {
            below[*i as usize].extend(list.iter().filter(|j| *j > i));
        }
    }
}

/// A block of the lower triangle and its place in a [`SparsityPattern`].
#[derive(Clone, Debug)]
pub struct PlacedBlock<const D: usize> {
    slot: usize,
    block: Matrix<D>,
}

/// A symmetric matrix of `D × D` blocks.
#[derive(Clone, Debug)]
pub struct BlockMatrix<const D: usize> {
    pub(crate) pattern: Arc<SparsityPattern>,
    pub(crate) blocks: Vec<Matrix<D>>,
}

impl<const D: usize> BlockMatrix<D> {
    /// The zero matrix.
    pub(crate) fn new(pattern: Arc<SparsityPattern>) -> Self {
        let blocks = vec![Matrix::zeros(); pattern.rows.len()];
        Self { pattern, blocks }
    }

    /// Adds a block to `(i, j)` and its transpose to `(j, i)`; a block on the diagonal must be symmetric. Returns `false`, and adds
    /// nothing, where the pattern has no block of the two vertices.
    #[must_use]
    pub fn add(&mut self, i: u32, j: u32, block: &Matrix<D>) -> bool {
        let placed = self.pattern.place(i, j, *block);
        placed.iter().for_each(|placed| self.add_placed(placed));
        placed.is_some()
    }

    /// Adds a block of this matrix's pattern.
    pub fn add_placed(&mut self, placed: &PlacedBlock<D>) {
        self.blocks[placed.slot] += placed.block;
    }

    /// Blocks of a column of the lower triangle.
    pub(crate) fn column(&self, j: usize) -> &[Matrix<D>] {
        &self.blocks[self.pattern.starts[j]..self.pattern.starts[j + 1]]
    }

    /// Adds a multiple of the identity to a block of the diagonal.
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

    /// The blocks of the lower triangle `(row, column, block)`, column by column.
    pub fn lower_blocks(&self) -> impl Iterator<Item = (usize, usize, &Matrix<D>)> {
        let columns = 0..self.pattern.starts.len() - 1;
        columns.flat_map(move |j| {
            let slots = self.pattern.starts[j]..self.pattern.starts[j + 1];
            slots.map(move |slot| (self.pattern.rows[slot] as usize, j, &self.blocks[slot]))
        })
    }

    /// Trace.
    pub(crate) fn trace(&self) -> f64 {
        (0..self.pattern.starts.len() - 1).map(|j| self.blocks[self.pattern.starts[j]].trace()).sum()
    }
}
