//! Compact storage of the unknowns: blocks of a row, split by colour.
//!
//! A *block* is [`BLOCK_CELLS`] consecutive cells of a row (aligned in absolute cell numbers). It is stored if it
//! contains an unknown. A vector over the unknowns consists of two halves, one per colour of the chessboard: cell `i` of
//! a row of parity `s` (sum of the other coordinates mod 2) has colour `(i + s) mod 2` and lies at entry `i / 2` of its
//! row in that half. The neighbours of a cell are therefore entries of the other half: the *same* entry of the
//! neighbouring rows, and the same and one adjacent entry of its own row. Every sweep over one colour runs at unit
//! stride. Consecutive blocks of a row are contiguous, followed by one entry that stays zero. Each half starts with zeros
//! that represent every row that is not stored.

use crate::grid::Runs;
use std::ops::Range;

/// Entries of one colour in a block.
pub const LANES: usize = 8;
/// Cells of a block.
pub const BLOCK_CELLS: usize = 2 * LANES;
/// Maximum number of blocks in a span.
pub const MAX_SPAN_BLOCKS: usize = 64;
/// Entry of the zeros that represent rows that are not stored.
pub const ZERO_ENTRY: u32 = 1;
/// First entry that belongs to a block.
const FIRST_BLOCK_ENTRY: usize = MAX_SPAN_BLOCKS * LANES + 2;

/// A maximal run of stored blocks of one row.
#[derive(Clone, Copy, Debug)]
pub struct BlockRun {
    /// Row number.
    pub row: u32,
    /// First block.
    pub block: u32,
    /// Number of blocks.
    pub blocks: u32,
    /// Entry of its first cell pair in either half of a vector.
    pub entry: u32,
    /// Position of its first block in the list of all stored blocks.
    pub first_index: u32,
}

/// Which blocks are stored, and where.
#[derive(Debug)]
pub struct Layout<const D: usize> {
    /// Cells along each axis.
    pub extent: [usize; D],
    /// The stored block runs, by row.
    pub block_runs: Vec<BlockRun>,
    /// For each row its first block run (one more entry than rows).
    row_starts: Vec<u32>,
    /// For each stored block, the bit mask of its unknowns.
    pub masks: Vec<u16>,
    /// Entries of half a vector.
    pub half_length: usize,
}

impl<const D: usize> Layout<D> {
    /// Stores the given cells of a grid with `extent` cells.
    pub fn new(extent: [usize; D], unknowns: &Runs) -> Self {
        let mut layout = Self::empty(extent);
        let mut scratch = vec![0_u16; extent[0].div_ceil(BLOCK_CELLS)];
        let mut next = 0;
        for row in 0..layout.row_count() {
            let from = next;
            while unknowns.runs.get(next).is_some_and(|run| run.row as usize == row) {
                mark_cells(
                    &mut scratch,
                    unknowns.runs[next].start as usize,
                    unknowns.runs[next].end as usize,
                );
                next += 1;
            }
            layout.close_row(row, &mut scratch, from < next);
        }
        layout
    }

    /// The cells of the grid of half the resolution that hold at least one unknown.
    pub fn coarsened(&self) -> Self {
        let extent = self.extent.map(|n| n.div_ceil(2));
        let mut layout = Self::empty(extent);
        let mut scratch = vec![0_u16; extent[0].div_ceil(BLOCK_CELLS)];
        for row in 0..layout.row_count() {
            let mut any = false;
            for child in 0..1 << (D - 1) {
                for stretch in self
                    .child_row(layout.row_coordinates(row), child)
                    .map_or(&[][..], |r| self.runs_of_row(r))
                {
                    any = true;
                    for b in 0..stretch.blocks {
                        let half = coarsened_mask(self.masks[(stretch.first_index + b) as usize]);
                        let block = (stretch.block + b) as usize;
                        scratch[block / 2] |= half << (LANES * (block % 2));
                    }
                }
            }
            layout.close_row(row, &mut scratch, any);
        }
        layout
    }

    fn empty(extent: [usize; D]) -> Self {
        let row_starts = Vec::with_capacity(extent[1..].iter().product::<usize>() + 1);
        let mut layout = Self {
            extent,
            block_runs: Vec::new(),
            row_starts,
            masks: Vec::new(),
            half_length: FIRST_BLOCK_ENTRY,
        };
        layout.row_starts.push(0);
        layout
    }

    /// Appends a row and clears the scratch.
    fn close_row(&mut self, row: usize, scratch: &mut [u16], any: bool) {
        let mut inside = false;
        for (block, mask) in scratch.iter_mut().enumerate().take_while(|_| any) {
            if *mask != 0 {
                if !inside {
                    let (entry, first_index) = (self.half_length as u32, self.masks.len() as u32);
                    self.block_runs.push(BlockRun {
                        row: row as u32,
                        block: block as u32,
                        blocks: 0,
                        entry,
                        first_index,
                    });
                }
                if let Some(last) = self.block_runs.last_mut() {
                    last.blocks += 1;
                }
                self.masks.push(*mask);
                self.half_length += LANES;
            } else if inside {
                self.half_length += 1;
            }
            inside = *mask != 0;
            *mask = 0;
        }
        self.half_length += usize::from(inside);
        self.row_starts.push(self.block_runs.len() as u32);
    }

    /// Number of rows of the grid.
    pub fn row_count(&self) -> usize {
        self.extent[1..].iter().product()
    }

    /// Coordinates of a row (the first is 0).
    pub fn row_coordinates(&self, mut row: usize) -> [usize; D] {
        let mut at = [0; D];
        for (at, extent) in at.iter_mut().zip(&self.extent).skip(1) {
            *at = row % extent;
            row /= extent;
        }
        at
    }

    /// Number of the row at given coordinates (the first is ignored).
    pub fn row(&self, at: [usize; D]) -> usize {
        (1..D).rev().fold(0, |row, a| row * self.extent[a] + at[a])
    }

    /// The block runs of a row.
    pub fn runs_of_row(&self, row: usize) -> &[BlockRun] {
        &self.block_runs[self.row_starts[row] as usize..self.row_starts[row + 1] as usize]
    }

    /// Row of this layout that is child number `child` of a row of the coarsened one.
    pub fn child_row(&self, parent: [usize; D], child: usize) -> Option<usize> {
        let mut at = [0; D];
        for a in 1..D {
            at[a] = 2 * parent[a] + (child >> (a - 1) & 1);
            if at[a] >= self.extent[a] {
                return None;
            }
        }
        Some(self.row(at))
    }

    /// Entry and list position of a stored block.
    pub fn find(&self, row: usize, block: usize) -> Option<(u32, usize)> {
        let stretch = self.runs_of_row(row).iter().find(|s| block < (s.block + s.blocks) as usize)?;
        let b = block.checked_sub(stretch.block as usize)?;
        Some((stretch.entry + (b * LANES) as u32, stretch.first_index as usize + b))
    }

    /// Colour of the even cells of a row.
    pub fn parity(at: [usize; D]) -> usize {
        at[1..].iter().sum::<usize>() % 2
    }

    /// Prepares a used buffer for a vector of `halves` halves: sets its length, and zeros wherever there is no block. The
    /// contents of blocks are left as they were.
    pub fn prepare<T: Copy + Default>(&self, buffer: &mut Vec<T>, halves: usize) {
        let length = halves * self.half_length;
        if buffer.capacity() < length {
            *buffer = vec![T::default(); length];
            return;
        }
        buffer.resize(length, T::default());
        for half in buffer.chunks_mut(self.half_length) {
            half[..FIRST_BLOCK_ENTRY].fill(T::default());
            for stretch in &self.block_runs {
                half[stretch.entry as usize + stretch.blocks as usize * LANES] = T::default();
            }
        }
    }

    /// Ranges of block runs for parallel work: whole rows, about equal in size, the same for any number of threads.
    pub fn chunks(&self) -> Vec<Range<usize>> {
        let size = (self.masks.len() / 32).max(1024);
        let (mut ranges, mut start, mut blocks) = (Vec::new(), 0, 0);
        for (i, stretch) in self.block_runs.iter().enumerate() {
            blocks += stretch.blocks as usize;
            let ends_row = self.block_runs.get(i + 1).is_none_or(|next| next.row != stretch.row);
            if (blocks >= size && ends_row) || i + 1 == self.block_runs.len() {
                ranges.push(start..i + 1);
                (start, blocks) = (i + 1, 0);
            }
        }
        ranges
    }
}

/// Marks the cells `start..end` of a row in the masks of its blocks.
fn mark_cells(masks: &mut [u16], start: usize, end: usize) {
    for (block, mask) in
        masks.iter_mut().enumerate().take(end.div_ceil(BLOCK_CELLS)).skip(start / BLOCK_CELLS)
    {
        let low = start.saturating_sub(block * BLOCK_CELLS).min(BLOCK_CELLS);
        let high = (end - block * BLOCK_CELLS).min(BLOCK_CELLS);
        *mask |= (((1_u32 << high) - 1) & !((1_u32 << low) - 1)) as u16;
    }
}

/// Reduces each of the eight pairs of a mask to one bit.
fn coarsened_mask(mask: u16) -> u16 {
    (0..LANES).fold(0, |half, l| half | (u16::from(mask >> (2 * l) & 3 != 0) << l))
}
