//! Connected components of a set of cells.

use super::{Grid, Run, Runs};

impl Runs {
    /// Labels every run with its connected component (cells that share a face). Components are numbered in the order of
    /// their first cells.
    pub fn label<const D: usize>(mut self, grid: &Grid<D>) -> Self {
        let rows = self.row_starts(grid);
        let mut parent: Vec<u32> = (0..self.runs.len() as u32).collect();
        let lattice = grid.lattice();
        let mut row_stride = 1;
        for axis in 1..D {
            for (i, run) in self.runs.iter().enumerate() {
                let row = run.row as usize;
                if (row / row_stride).is_multiple_of(lattice.extent[axis]) {
                    continue;
                }
                let below = row - row_stride;
                for j in rows[below]..rows[below + 1] {
                    let other = &self.runs[j];
                    if other.start < run.end && run.start < other.end {
                        unite(&mut parent, i as u32, j as u32);
                    }
                }
            }
            row_stride *= lattice.extent[axis];
        }
        let mut label = vec![u32::MAX; self.runs.len()];
        let mut count = 0;
        for i in 0..self.runs.len() {
            let root = find(&mut parent, i as u32) as usize;
            if label[root] == u32::MAX {
                label[root] = count;
                count += 1;
            }
            self.runs[i].component = label[root];
        }
        self.components = count;
        self
    }

    /// Merges each pair of components and renumbers them in the order of their first cells.
    pub fn merge_components(&mut self, pairs: &[(u32, u32)]) {
        let mut parent: Vec<u32> = (0..self.components).collect();
        pairs.iter().for_each(|&(a, b)| unite(&mut parent, a, b));
        let mut label = vec![u32::MAX; parent.len()];
        let mut count = 0;
        for i in 0..self.components {
            let root = find(&mut parent, i) as usize;
            if label[root] == u32::MAX {
                label[root] = count;
                count += 1;
            }
            label[i as usize] = label[root];
        }
        self.runs.iter_mut().for_each(|run| run.component = label[run.component as usize]);
        self.components = count;
    }

    /// A function that returns the component of a cell, or `None` if the cell is not in the set.
    pub fn component_lookup<const D: usize>(
        &self,
        grid: &Grid<D>,
    ) -> impl Fn(usize) -> Option<u32> + Sync + use<'_, D> {
        let (rows, nx) = (self.row_starts(grid), grid.cells[0]);
        move |cell| {
            let (row, x) = (cell / nx, (cell % nx) as u32);
            let runs = &self.runs[rows[row]..rows[row + 1]];
            let k = runs.partition_point(|r| r.end <= x);
            runs.get(k).filter(|r| r.start <= x).map(|r| r.component)
        }
    }

    /// For every row of the grid, the number of runs in the rows before it.
    pub fn row_starts<const D: usize>(&self, grid: &Grid<D>) -> Vec<usize> {
        let rows = grid.lattice().rows();
        let mut starts = vec![0; rows + 1];
        for run in &self.runs {
            starts[run.row as usize + 1] += 1;
        }
        for row in 0..rows {
            starts[row + 1] += starts[row];
        }
        starts
    }

    /// Pairs of components of `self` and `other` that share a cell, with the number of shared cells, sorted.
    pub fn overlaps(&self, other: &Runs) -> Vec<(u32, u32, u64)> {
        let mut counts = std::collections::BTreeMap::new();
        let (mut i, mut j) = (0, 0);
        let end = |r: &Run| (r.row, r.end);
        while i < self.runs.len() && j < other.runs.len() {
            let (a, b) = (&self.runs[i], &other.runs[j]);
            if a.row == b.row && a.start < b.end && b.start < a.end {
                let shared = a.end.min(b.end) - a.start.max(b.start);
                *counts.entry((a.component, b.component)).or_insert(0u64) += shared as u64;
            }
            if end(a) <= end(b) { i += 1 } else { j += 1 }
        }
        counts.into_iter().map(|((a, b), n)| (a, b, n)).collect()
    }
}

fn find(parent: &mut [u32], mut i: u32) -> u32 {
    while parent[i as usize] != i {
        parent[i as usize] = parent[parent[i as usize] as usize];
        i = parent[i as usize];
    }
    i
}

fn unite(parent: &mut [u32], a: u32, b: u32) {
    let (a, b) = (find(parent, a), find(parent, b));
    parent[a.max(b) as usize] = a.min(b);
}

#[cfg(test)]
mod tests {
    use super::super::Tiles;
    use super::*;

    #[test]
    fn a_ring_is_one_component_and_its_core_another() {
        let grid = Grid::<2>::new([20, 20], 1.0);
        let lattice = grid.lattice();
        let data: Vec<f64> = (0..lattice.len())
            .map(|i| {
                let r = (grid.center(lattice.coordinates(i)) - crate::Vector::<2>::new(10.0, 10.0)).norm();
                if r < 3.0 || (r > 6.0 && r < 8.0) { -1.0 } else { 1.0 }
            })
            .collect();
        let runs = Tiles::all(grid).negative_runs(&data).label(&grid);
        assert_eq!(runs.components, 2);
        assert_eq!(runs.cell_count(), data.iter().filter(|v| **v < 0.0).count());
        assert_eq!(runs.overlaps(&runs).len(), 2);
        let mut one = runs.clone();
        one.merge_components(&[(1, 0)]);
        assert_eq!((one.components, one.overlaps(&runs).len()), (1, 2));
    }
}
