//! Sparse matrices in rows; products and sums are in an order that does not depend on the number of threads.

use meniscus_numerics::linalg::LinearOperator;
use meniscus_numerics::par;

/// Least number of rows of a task.
const ROWS_PER_TASK: usize = 256;

/// An entry of a row: its column and its value.
pub type Entry = (u32, f64);

/// A sparse matrix: for each row its entries, sorted by column.
#[derive(Clone, Debug, PartialEq)]
pub struct SparseMatrix {
    columns: usize,
    /// Row `i` is `entries[starts[i]..starts[i + 1]]`.
    starts: Vec<usize>,
    entries: Vec<Entry>,
}

impl SparseMatrix {
    /// A matrix of rows. Entries of the same place are added in their order.
    pub fn new(columns: usize, rows: impl IntoIterator<Item = Vec<Entry>>) -> Self {
        let (mut starts, mut entries) = (vec![0], Vec::<Entry>::new());
        for mut row in rows {
            row.sort_by_key(|entry| entry.0);
            let first = entries.len();
            for (column, value) in row {
                match entries[first..].last_mut() {
                    Some(last) if last.0 == column => last.1 += value,
                    _ => entries.push((column, value)),
                }
            }
            starts.push(entries.len());
        }
        Self { columns, starts, entries }
    }

    /// A matrix of entries `(row, column, value)` in any order; those of the same place are added in their order.
    pub fn of_entries([rows, columns]: [usize; 2], all: impl IntoIterator<Item = (u32, u32, f64)>) -> Self {
        let mut lists = vec![Vec::new(); rows];
        all.into_iter().for_each(|(row, column, value)| lists[row as usize].push((column, value)));
        Self::new(columns, lists)
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.starts.len() - 1
    }

    /// Number of columns.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Entries of a row.
    pub fn row(&self, row: usize) -> &[Entry] {
        &self.entries[self.starts[row]..self.starts[row + 1]]
    }

    /// All entries `(row, column, value)`, row by row.
    pub fn entries(&self) -> impl Iterator<Item = (u32, u32, f64)> + '_ {
        (0..self.rows()).flat_map(|i| self.row(i).iter().map(move |(j, value)| (i as u32, *j, *value)))
    }

    /// `A x`.
    pub fn multiply(&self, x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; self.rows()];
        self.apply(x, &mut y);
        y
    }

    /// The transpose.
    pub fn transposed(&self) -> Self {
        Self::of_entries([self.columns, self.rows()], self.entries().map(|(i, j, value)| (j, i, value)))
    }

    /// `Aᵀ x`.
    pub fn multiply_transposed(&self, x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; self.columns];
        self.entries().for_each(|(i, j, value)| y[j as usize] += value * x[i as usize]);
        y
    }

    /// `A B`.
    pub fn product(&self, other: &Self) -> Self {
        let row = |i: usize| {
            let entries = self.row(i).iter();
            entries.flat_map(|(k, a)| other.row(*k as usize).iter().map(move |(j, b)| (*j, a * b))).collect()
        };
        Self::new(other.columns, (0..self.rows()).map(row))
    }

    /// Entries `(row, column, value)` of `Aᵀ diag(weights) A`.
    pub fn weighted_gram<'a>(&'a self, weights: &'a [f64]) -> impl Iterator<Item = (u32, u32, f64)> + 'a {
        (0..self.rows()).flat_map(move |i| {
            let row = self.row(i);
            row.iter().flat_map(move |(j, a)| row.iter().map(move |(k, b)| (*j, *k, a * weights[i] * b)))
        })
    }

    /// Some of the rows, in the given order.
    pub fn select(&self, rows: &[usize]) -> Self {
        Self::new(self.columns, rows.iter().map(|i| self.row(*i).to_vec()))
    }

    /// Entries on the diagonal.
    pub fn diagonal(&self) -> Vec<f64> {
        let of = |i: usize| self.row(i).iter().find(|e| e.0 as usize == i).map_or(0.0, |e| e.1);
        (0..self.rows()).map(of).collect()
    }
}

impl LinearOperator for SparseMatrix {
    fn size(&self) -> usize {
        self.rows()
    }

    fn apply(&self, x: &[f64], y: &mut [f64]) {
        par::for_each_mut(y, ROWS_PER_TASK, |i, y| {
            *y = self.row(i).iter().map(|(j, value)| value * x[*j as usize]).sum();
        });
    }
}
