//! Active tiles: the parts of the dense fields that sweeps visit.
//!
//! Fields are stored densely. Sweeps run only over the tiles of 8 cells a side that contain liquid, and their neighbours.
//! Their cost therefore scales with the liquid and not with the domain.

use super::{Grid, Lattice, Run, Runs, lattice_points};
use crate::grid::Segment;
use crate::par;

/// Cells along the side of a tile.
pub const TILE_CELLS: usize = 8;

/// The tiles that contain liquid, and their neighbours.
#[derive(Clone, Debug)]
pub struct Tiles<const D: usize> {
    grid: Grid<D>,
    lattice: Lattice<D>,
    active: Vec<bool>,
}

impl<const D: usize> Tiles<D> {
    /// All tiles.
    pub fn all(grid: Grid<D>) -> Self {
        let lattice = Lattice::new(grid.cells.map(|n| n.div_ceil(TILE_CELLS)));
        Self { grid, lattice, active: vec![true; lattice.len()] }
    }

    /// No tile.
    pub fn none(grid: Grid<D>) -> Self {
        let mut tiles = Self::all(grid);
        tiles.active.fill(false);
        tiles
    }

    /// Those of these tiles with a cell in a box (lower corner, and one past the upper corner).
    pub fn within(&self, boxes: &[[[usize; D]; 2]]) -> Self {
        let mut active = vec![false; self.lattice.len()];
        for [low, high] in boxes.iter().filter(|[low, high]| (0..D).all(|a| low[a] < high[a])) {
            let last: [usize; D] = std::array::from_fn(|a| {
                let last = (high[a] - 1) / TILE_CELLS + 1;
                last.min(self.lattice.extent[a])
            });
            for tile in lattice_points([low.map(|i| i / TILE_CELLS), last]) {
                let tile = self.lattice.index(tile);
                active[tile] = self.active[tile];
            }
        }
        Self { grid: self.grid, lattice: self.lattice, active }
    }

    /// Adds tiles, and returns the boxes of cells of those that are new.
    pub fn add(&mut self, more: &Self) -> Vec<[[usize; D]; 2]> {
        let mut new = Vec::new();
        for tile in (0..self.lattice.len()).filter(|t| more.active[*t]) {
            if !std::mem::replace(&mut self.active[tile], true) {
                let low = self.lattice.coordinates(tile).map(|i| i * TILE_CELLS);
                new.push([low, std::array::from_fn(|a| (low[a] + TILE_CELLS).min(self.grid.cells[a]))]);
            }
        }
        new
    }

    /// Those of these tiles that contain a negative value, and all their neighbours.
    pub fn around_negative(&self, data: &[f64]) -> Self {
        let nx = self.grid.cells[0];
        let mut marked = vec![false; self.lattice.len()];
        let segments = self.segments();
        let hits = par::flat_map(segments.len(), 16, |i, hits| {
            let s = &segments[i];
            let row = self.tile_row(s.row);
            let values = &data[s.row * nx + s.start..s.row * nx + s.end];
            let tiles = values.chunks(TILE_CELLS).enumerate();
            let hit = tiles.filter(|(_, v)| v.iter().any(|&v| v < 0.0));
            hits.extend(hit.map(|(t, _)| row + s.start / TILE_CELLS + t));
        });
        hits.iter().for_each(|&t| marked[t] = true);
        let mut active = vec![false; self.lattice.len()];
        for (tile, _) in marked.iter().enumerate().filter(|(_, m)| **m) {
            self.for_each_neighbour(tile, |n| active[n] = true);
        }
        Self { grid: self.grid, lattice: self.lattice, active }
    }

    /// These tiles and their neighbours.
    pub fn dilated(&self) -> Self {
        let mut active = vec![false; self.lattice.len()];
        for (tile, _) in self.active.iter().enumerate().filter(|(_, a)| **a) {
            self.for_each_neighbour(tile, |n| active[n] = true);
        }
        Self { grid: self.grid, lattice: self.lattice, active }
    }

    /// Whether a cell is in an active tile.
    pub fn is_active(&self, cell: [usize; D]) -> bool {
        self.active[self.lattice.index(cell.map(|i| i / TILE_CELLS))]
    }

    /// Whether a corner of the cell lattice belongs to a cell in an active tile.
    pub fn is_active_corner(&self, at: [usize; D]) -> bool {
        (0..1usize << D).any(|k| self.is_active_below(at, std::array::from_fn(|a| k >> a & 1)))
    }

    /// Whether a face normal to `axis` belongs to a cell in an active tile.
    pub fn is_active_face(&self, axis: usize, at: [usize; D]) -> bool {
        self.is_active_below(at, [0; D])
            || self.is_active_below(at, std::array::from_fn(|a| usize::from(a == axis)))
    }

    /// Whether `at − by` is a cell in an active tile.
    fn is_active_below(&self, at: [usize; D], by: [usize; D]) -> bool {
        let within = (0..D).all(|a| (by[a]..self.grid.cells[a] + by[a]).contains(&at[a]));
        within && self.is_active(std::array::from_fn(|a| at[a] - by[a]))
    }

    /// The rows of the active tiles as maximal segments, in memory order.
    pub fn segments(&self) -> Vec<Segment> {
        let mut out = Vec::new();
        for row in 0..self.grid.lattice().rows() {
            let base = self.tile_row(row);
            let tiles = &self.active[base..base + self.lattice.extent[0]];
            let mut t = 0;
            while t < tiles.len() {
                if !tiles[t] {
                    t += 1;
                    continue;
                }
                let start = t;
                while t < tiles.len() && tiles[t] {
                    t += 1;
                }
                out.push(Segment {
                    row,
                    start: start * TILE_CELLS,
                    end: (t * TILE_CELLS).min(self.grid.cells[0]),
                });
            }
        }
        out
    }

    /// The cells of the active tiles with a negative value, as runs (components not yet labelled).
    pub fn negative_runs(&self, data: &[f64]) -> Runs {
        let nx = self.grid.cells[0];
        let segments = self.segments();
        let runs = par::flat_map(segments.len(), 16, |number, runs| {
            let s = &segments[number];
            let values = &data[s.row * nx..(s.row + 1) * nx];
            let mut i = s.start;
            while i < s.end {
                let start = i;
                while i < s.end && values[i] < 0.0 {
                    i += 1;
                }
                if start < i {
                    runs.push(Run { row: s.row as u32, start: start as u32, end: i as u32, component: 0 });
                }
                i += 1;
            }
        });
        Runs { runs, components: 0 }
    }

    /// Position in the tile lattice of the first tile that a row of cells crosses.
    fn tile_row(&self, row: usize) -> usize {
        let cells = self.grid.lattice();
        let at = cells.coordinates(row * cells.extent[0]);
        self.lattice.index(at.map(|i| i / TILE_CELLS))
    }

    fn for_each_neighbour(&self, tile: usize, mut f: impl FnMut(usize)) {
        let at = self.lattice.coordinates(tile);
        for n in 0..3usize.pow(D as u32) {
            let mut rest = n;
            let to: [usize; D] = std::array::from_fn(|a| {
                let step = rest % 3;
                rest /= 3;
                (at[a] + step).wrapping_sub(1)
            });
            if (0..D).all(|a| to[a] < self.lattice.extent[a]) {
                f(self.lattice.index(to));
            }
        }
    }
}
