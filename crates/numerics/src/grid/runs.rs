//! Sets of cells as sorted lists of runs along the first axis, and parts of rows.

use super::Grid;

/// Consecutive cells of one row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Run {
    /// Row number: `index / cells[0]`.
    pub row: u32,
    /// First cell of the row that belongs to the run.
    pub start: u32,
    /// One past the last cell.
    pub end: u32,
    /// Its connected component.
    pub component: u32,
}

/// Part of a row: cells `start..end` of row `row`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Segment {
    /// Row number.
    pub row: usize,
    /// First cell, counted along the row.
    pub start: usize,
    /// One past the last cell.
    pub end: usize,
}

/// A set of cells as runs, sorted by row, then by start; runs of a row do not touch.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Runs {
    /// The runs.
    pub runs: Vec<Run>,
    /// Number of connected components (face neighbours).
    pub components: u32,
}

impl Runs {
    /// The faces normal to `axis` that bound these cells, as sorted segments of the rows of the face lattice.
    pub fn faces<const D: usize>(&self, grid: &Grid<D>, axis: usize) -> Vec<Segment> {
        let cells = self.segments();
        if axis == 0 {
            return cells.into_iter().map(|s| Segment { end: s.end + 1, ..s }).collect();
        }
        // The face lattice has one more row along `axis`, which shifts the rows beyond that axis.
        let below: usize = grid.cells[1..axis].iter().product();
        let block = below * grid.cells[axis];
        let lift = |s: Segment| Segment { row: s.row + s.row / block * below, ..s };
        let lower: Vec<Segment> = cells.into_iter().map(lift).collect();
        let upper = lower.iter().map(|s| Segment { row: s.row + below, ..*s });
        merge(&lower, &upper.collect::<Vec<_>>())
    }

    /// These cells and those that share a face with them, as sorted segments.
    pub fn with_neighbours<const D: usize>(&self, grid: &Grid<D>) -> Vec<Segment> {
        let cells = self.segments();
        let widened = cells.iter().map(|s| Segment {
            start: s.start.saturating_sub(1),
            end: (s.end + 1).min(grid.cells[0]),
            ..*s
        });
        let mut all = merge(&widened.collect::<Vec<_>>(), &[]);
        let mut below = 1;
        for a in 1..D {
            let place = |s: &Segment| s.row / below % grid.cells[a];
            let lower = cells.iter().filter(|s| place(s) > 0).map(|s| Segment { row: s.row - below, ..*s });
            all = merge(&all, &lower.collect::<Vec<_>>());
            let has_upper = |s: &&Segment| place(s) + 1 < grid.cells[a];
            let upper = cells.iter().filter(has_upper).map(|s| Segment { row: s.row + below, ..*s });
            all = merge(&all, &upper.collect::<Vec<_>>());
            below *= grid.cells[a];
        }
        all
    }

    /// The cells for which `keep` holds. Their components must be relabelled.
    pub fn filtered<const D: usize>(self, grid: &Grid<D>, keep: impl Fn(usize) -> bool) -> Self {
        let mut runs = Vec::with_capacity(self.runs.len());
        for run in self.runs {
            let row = run.row as usize * grid.cells[0];
            let mut start = run.start;
            for x in run.start..=run.end {
                if x == run.end || !keep(row + x as usize) {
                    if x > start {
                        runs.push(Run { start, end: x, ..run });
                    }
                    start = x + 1;
                }
            }
        }
        Self { runs, components: 0 }
    }

    /// The runs as segments.
    pub fn segments(&self) -> Vec<Segment> {
        let plain = |r: &Run| Segment { row: r.row as usize, start: r.start as usize, end: r.end as usize };
        self.runs.iter().map(plain).collect()
    }

    /// Number of cells.
    pub fn cell_count(&self) -> usize {
        self.runs.iter().map(|r| (r.end - r.start) as usize).sum()
    }
}

/// Union of two sorted lists of segments.
fn merge(a: &[Segment], b: &[Segment]) -> Vec<Segment> {
    let mut out: Vec<Segment> = Vec::with_capacity(a.len() + b.len());
    let (mut i, mut j) = (0, 0);
    while i < a.len() || j < b.len() {
        let first = j == b.len() || (i < a.len() && (a[i].row, a[i].start) <= (b[j].row, b[j].start));
        let next = if first { a[i] } else { b[j] };
        if first {
            i += 1
        } else {
            j += 1
        }
        match out.last_mut() {
            Some(last) if last.row == next.row && next.start <= last.end => last.end = last.end.max(next.end),
            _ => out.push(next),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Tiles;

    #[test]
    fn neighbours_are_the_cells_that_share_a_face() {
        let grid = Grid::<3>::new([6, 5, 4], 1.0);
        let lattice = grid.lattice();
        let inside = [[0, 0, 0], [2, 2, 1], [4, 2, 1], [5, 4, 3]].map(|at| lattice.index(at));
        let mut phi = vec![1.0; lattice.len()];
        inside.iter().for_each(|c| phi[*c] = -1.0);
        let cells = Tiles::all(grid).negative_runs(&phi);
        let found =
            cells.with_neighbours(&grid).into_iter().flat_map(|s| s.row * 6 + s.start..s.row * 6 + s.end);
        let mut all: Vec<usize> = inside.iter().flat_map(|c| lattice.neighbours(*c).chain([*c])).collect();
        all.sort_unstable();
        all.dedup();
        assert_eq!(found.collect::<Vec<_>>(), all);
    }
}
