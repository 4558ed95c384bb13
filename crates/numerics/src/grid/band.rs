//! The narrow band: the cells around the interface, in layers.

use super::{Grid, Runs, Segment};
use crate::par;
use rayon::slice::ParallelSliceMut as _;

/// Number of cells that a task looks around.
const CELLS_PER_TASK: usize = 1024;

/// The cells around the zero set of a level set as a compact list, layer by layer outward on both sides.
///
/// Layer 0 holds the cells with a face neighbour of the other sign; layer `l + 1` the cells that share a face with
/// layer `l`. Each layer is sorted by position in memory.
#[derive(Clone, Debug)]
pub struct Band<const D: usize> {
    grid: Grid<D>,
    /// The cells: positions in memory.
    pub cells: Vec<u32>,
    /// Layer `l` is `cells[layers[l]..layers[l + 1]]`.
    pub layers: Vec<usize>,
    /// The cells as sorted segments of rows.
    pub segments: Vec<Segment>,
    /// For every cell of the grid: 1 + its index in `cells`, or 0.
    slots: Vec<u32>,
}

impl<const D: usize> Band<D> {
    /// An empty band.
    pub fn new(grid: Grid<D>) -> Self {
        Self {
            grid,
            cells: Vec::new(),
            layers: vec![0],
            segments: Vec::new(),
            slots: vec![0; grid.lattice().len()],
        }
    }

    /// Index of a cell in `cells`.
    pub fn slot(&self, cell: usize) -> Option<usize> {
        (self.slots[cell] as usize).checked_sub(1)
    }

    /// Index range in `cells` of the layers `0..n`.
    pub fn first_layers(&self, n: usize) -> std::ops::Range<usize> {
        0..self.layers[n.min(self.layers.len() - 1)]
    }

    /// Builds the band of `layers` layers around the zero set of `phi`, whose negative cells are `inside`. Only the signs
    /// of `phi` are used.
    pub fn rebuild(&mut self, phi: &[f64], inside: &Runs, layers: usize) {
        for &cell in &self.cells {
            self.slots[cell as usize] = 0;
        }
        self.cells.clear();
        self.layers = vec![0];
        let nx = self.grid.cells[0];
        let lattice = self.grid.lattice();
        let inner_layer = par::flat_map(inside.runs.len(), 16, |r, inner_layer| {
            let run = &inside.runs[r];
            let row = run.row as usize * nx;
            let cells = row + run.start as usize..row + run.end as usize;
            inner_layer.extend(cells.filter(|&c| lattice.neighbours(c).any(|n| phi[n] >= 0.0)));
        });
        inner_layer.iter().for_each(|&c| self.push(c));
        for i in 0..self.cells.len() {
            for n in lattice.neighbours(self.cells[i] as usize) {
                if phi[n] >= 0.0 {
                    self.push(n);
                }
            }
        }
        self.close_layer();
        for l in 1..layers {
            let last = &self.cells[self.layers[l - 1]..self.layers[l]];
            let found = par::flat_map(last.len(), CELLS_PER_TASK, |i, found| {
                let beside = lattice.neighbours(last[i] as usize);
                found.extend(beside.filter(|n| self.slots[*n] == 0));
            });
            found.iter().for_each(|n| self.push(*n));
            self.close_layer();
        }
        self.segments = self.find_segments();
    }

    /// Collects the cells into segments, row by row between the first and the last cell of each row.
    fn find_segments(&self) -> Vec<Segment> {
        let row_length = self.grid.cells[0];
        let mut reach = vec![(u32::MAX, 0); self.grid.lattice().rows()];
        for &cell in &self.cells {
            let (row, x) = (cell as usize / row_length, cell % row_length as u32);
            reach[row] = (x.min(reach[row].0), (x + 1).max(reach[row].1));
        }
        par::flat_map(reach.len(), 256, |row, segments| {
            let (low, high) = (reach[row].0 as usize, reach[row].1 as usize);
            let mut start = low;
            for x in low..=high {
                if x == high || self.slots[row * row_length + x] == 0 {
                    if x > start {
                        segments.push(Segment { row, start, end: x });
                    }
                    start = x + 1;
                }
            }
        })
    }

    fn push(&mut self, cell: usize) {
        if self.slots[cell] == 0 {
            self.cells.push(cell as u32);
            self.slots[cell] = self.cells.len() as u32;
        }
    }

    fn close_layer(&mut self) {
        let start = self.layers[self.layers.len() - 1];
        self.cells[start..].par_sort_unstable();
        for i in start..self.cells.len() {
            self.slots[self.cells[i] as usize] = i as u32 + 1;
        }
        self.layers.push(self.cells.len());
    }
}
