//! One level of the pressure system: coefficients by spans of blocks, and the loops over them.

use super::layout::{BLOCK_CELLS, LANES, Layout, MAX_SPAN_BLOCKS, ZERO_ENTRY};
use crate::par;
use std::ops::Range;

/// Coefficients of the cells of one colour of a block: toward the lower and upper neighbour along each axis,
/// then at [`DIAGONAL`] their sum plus the Dirichlet coefficient (1 where the row is empty).
pub type CoefficientPack<T> = [[T; LANES]; 7];
/// Index of the diagonal in a [`CoefficientPack`].
pub const DIAGONAL: usize = 6;

/// The coefficients of a span.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SpanCoefficients {
    /// All cells and their neighbours are unknowns, all coefficients have this value, and Dirichlet ones are zero.
    Uniform(f64),
    /// Index of the first pack in the list of the chunk.
    General(u32),
}

/// Consecutive blocks of one row whose neighbours are also consecutive in memory.
#[derive(Clone, Copy, Debug)]
pub struct Span {
    pub entry: u32,
    pub blocks: u32,
    /// Entries of the lower and upper neighbours along axes 1.. .
    pub neighbours: [u32; 4],
    pub coefficients: SpanCoefficients,
    /// Entry of the parents on the coarser level.
    pub parent: u32,
    /// Colour of the even cells.
    pub parity: u8,
    /// Colour of the even parents.
    pub parent_parity: u8,
}

/// A part of a level that one task works on.
#[derive(Debug, Default)]
pub struct Chunk {
    /// Block runs it covers.
    pub block_runs: Range<usize>,
    /// Entries it covers.
    pub entries: Range<usize>,
    pub spans: Vec<Span>,
    /// Coefficients by colour in double precision (finest level; others only while the hierarchy is built).
    pub packs_f64: [Vec<CoefficientPack<f64>>; 2],
    /// Coefficients by colour, scaled, in single precision.
    pub packs_f32: [Vec<CoefficientPack<f32>>; 2],
    /// Dirichlet coefficients beside `packs_f64`, while the hierarchy is built.
    pub dirichlet: [Vec<[f64; LANES]>; 2],
    /// Coefficients of each block, while the hierarchy is built.
    pub block_coefficients: Vec<SpanCoefficients>,
    /// Entries of each block's children on the finer level: two blocks of up to four rows.
    pub children: Vec<[u32; 8]>,
}

/// A stored block while its coefficients are set up.
pub struct BlockSite<const D: usize> {
    /// Coordinates of its first cell.
    pub at: [usize; D],
    /// Its number within the row.
    pub block: usize,
    /// Its unknowns.
    pub mask: u16,
    /// Unknowns among the lower and upper neighbours along each axis.
    pub neighbour_masks: [[u16; 2]; D],
}

/// Coefficients of a block that is not uniform.
pub struct BlockCoefficients {
    pub packs: [CoefficientPack<f64>; 2],
    pub dirichlet: [[f64; LANES]; 2],
}

impl BlockCoefficients {
    pub fn new() -> Self {
        Self { packs: [[[0.0; LANES]; 7]; 2], dirichlet: [[0.0; LANES]; 2] }
    }

    /// Sets the diagonals from the other coefficients.
    pub fn set_diagonals(&mut self) {
        for colour in 0..2 {
            for l in 0..LANES {
                let pack = &mut self.packs[colour];
                let sum: f64 = (0..DIAGONAL).map(|c| pack[c][l]).sum();
                let diagonal = sum + self.dirichlet[colour][l];
                pack[DIAGONAL][l] = if diagonal > 0.0 { diagonal } else { 1.0 };
            }
        }
    }
}

/// Builds the chunks of a level. `coefficients` returns the value of a uniform block or sets the packs of another.
pub fn build_chunks<const D: usize>(
    layout: &Layout<D>,
    coarse: Option<&Layout<D>>,
    coefficients: impl Fn(&BlockSite<D>, &mut BlockCoefficients) -> Option<f64> + Sync,
) -> Vec<Chunk> {
    let ranges = layout.chunks();
    par::map_jobs(ranges, |range| build_chunk(layout, coarse, range, &coefficients))
}

fn build_chunk<const D: usize>(
    layout: &Layout<D>,
    coarse: Option<&Layout<D>>,
    range: Range<usize>,
    coefficients: &impl Fn(&BlockSite<D>, &mut BlockCoefficients) -> Option<f64>,
) -> Chunk {
    let stretches = &layout.block_runs[range.clone()];
    let first = stretches.first().map_or(0, |s| s.entry as usize);
    let last = stretches.last().map_or(0, |s| s.entry as usize + s.blocks as usize * LANES);
    let mut chunk = Chunk { block_runs: range, entries: first..last, ..Chunk::default() };
    for stretch in stretches {
        let row = stretch.row as usize;
        let at = layout.row_coordinates(row);
        let rows = neighbour_rows(layout, row, at);
        for b in 0..stretch.blocks as usize {
            let block = stretch.block as usize + b;
            let (neighbours, site) =
                find_neighbours(layout, row, at, block, stretch.first_index as usize + b, &rows);
            let mut general = BlockCoefficients::new();
            let kind = match coefficients(&site, &mut general) {
                Some(value) => SpanCoefficients::Uniform(value),
                None => {
                    general.set_diagonals();
                    for colour in 0..2 {
                        chunk.packs_f64[colour].push(general.packs[colour]);
                        chunk.dirichlet[colour].push(general.dirichlet[colour]);
                    }
                    SpanCoefficients::General(chunk.packs_f64[0].len() as u32 - 1)
                }
            };
            chunk.block_coefficients.push(kind);
            let parent_at = at.map(|c| c / 2);
            let parent = coarse
                .and_then(|c| c.find(c.row(parent_at), block / 2))
                .map_or(0, |(entry, _)| entry + (block % 2 * LANES / 2) as u32);
            let entry = stretch.entry + (b * LANES) as u32;
            let parity = Layout::<D>::parity(at) as u8;
            let parent_parity = Layout::<D>::parity(parent_at) as u8;
            push_block(
                &mut chunk.spans,
                Span { entry, blocks: 1, neighbours, coefficients: kind, parent, parity, parent_parity },
            );
        }
    }
    chunk
}

/// The rows below and above along axes 1.. .
fn neighbour_rows<const D: usize>(layout: &Layout<D>, row: usize, at: [usize; D]) -> [Option<usize>; 4] {
    let mut rows = [None; 4];
    let mut stride = 1;
    for a in 1..D {
        rows[2 * (a - 1)] = (at[a] > 0).then(|| row - stride);
        rows[2 * (a - 1) + 1] = (at[a] + 1 < layout.extent[a]).then(|| row + stride);
        stride *= layout.extent[a];
    }
    rows
}

/// The entries of a block's neighbours, and which of them are unknowns.
fn find_neighbours<const D: usize>(
    layout: &Layout<D>,
    row: usize,
    at: [usize; D],
    block: usize,
    number: usize,
    rows: &[Option<usize>; 4],
) -> ([u32; 4], BlockSite<D>) {
    let mut neighbours = [ZERO_ENTRY; 4];
    let mask = layout.masks[number];
    let mut masks = [[0; 2]; D];
    let bit = |block: Option<usize>, bit: u16| {
        block.and_then(|b| layout.find(row, b)).map_or(0, |(_, n)| layout.masks[n] >> bit & 1)
    };
    masks[0] = [mask << 1 | bit(block.checked_sub(1), 15), mask >> 1 | bit(Some(block + 1), 0) << 15];
    for (r, neighbour) in rows.iter().enumerate() {
        if let Some((entry, n)) = neighbour.and_then(|r| layout.find(r, block)) {
            neighbours[r] = entry;
            masks[1 + r / 2][r % 2] = layout.masks[n];
        }
    }
    let mut first = at;
    first[0] = block * BLOCK_CELLS;
    (neighbours, BlockSite { at: first, block, mask, neighbour_masks: masks })
}

/// Appends a block to the last span if it continues it, else starts a new one.
fn push_block(spans: &mut Vec<Span>, block: Span) {
    if let Some(last) = spans.last_mut() {
        let blocks = last.blocks;
        let follows = |a: u32, b: u32| a + blocks * LANES as u32 == b;
        let same_kind = match (last.coefficients, block.coefficients) {
            (SpanCoefficients::Uniform(a), SpanCoefficients::Uniform(b)) => a == b,
            (SpanCoefficients::General(a), SpanCoefficients::General(b)) => a + blocks == b,
            _ => false,
        };
        let neighbours = last.neighbours.iter().zip(&block.neighbours);
        let in_line = neighbours.fold(true, |ok, (a, b)| {
            ok && ((*a == ZERO_ENTRY && *b == ZERO_ENTRY) || (*a != ZERO_ENTRY && follows(*a, *b)))
        });
        if same_kind && in_line && follows(last.entry, block.entry) && (blocks as usize) < MAX_SPAN_BLOCKS {
            last.blocks += 1;
            return;
        }
    }
    spans.push(block);
}

/// Sums the coefficients of the finer level over the children of a block (Galerkin with piecewise constants). `chunks`
/// and `kinds` belong to the finer level.
pub fn aggregate<const D: usize>(
    fine: &Layout<D>,
    chunks: &[Chunk],
    kinds: &[(u32, SpanCoefficients)],
    site: &BlockSite<D>,
    general: &mut BlockCoefficients,
) -> Option<f64> {
    let parent = std::array::from_fn(|a| if a == 0 { 0 } else { site.at[a] });
    let found = |child: usize, half: usize| {
        let row = fine.child_row(parent, child)?;
        fine.find(row, 2 * site.block + half).map(|(_, number)| (row, kinds[number]))
    };
    let children: [Option<(usize, (u32, SpanCoefficients))>; 8] =
        std::array::from_fn(|c| if c < 1 << D { found(c / 2, c % 2) } else { None });
    if let Some((_, (_, SpanCoefficients::Uniform(value)))) = children[0]
        && children[..1 << D]
            .iter()
            .all(|c| matches!(c, Some((_, (_, SpanCoefficients::Uniform(v)))) if *v == value))
    {
        return Some(value * (1 << (D - 1)) as f64);
    }
    let coarse_parity = Layout::<D>::parity(site.at);
    for (c, child) in children.iter().enumerate() {
        let Some((row, (chunk, kind))) = child else { continue };
        let parity = Layout::<D>::parity(fine.row_coordinates(*row));
        for i in 0..BLOCK_CELLS {
            let (colour, lane) = ((i + parity) % 2, i / 2);
            let target = c % 2 * LANES + lane;
            let (to, to_lane) = ((target + coarse_parity) % 2, target / 2);
            let (value, dirichlet) = match kind {
                SpanCoefficients::Uniform(value) => ([*value; DIAGONAL], 0.0),
                SpanCoefficients::General(pack) => {
                    let source = &chunks[*chunk as usize];
                    let pack = *pack as usize;
                    (
                        std::array::from_fn(|k| source.packs_f64[colour][pack][k][lane]),
                        source.dirichlet[colour][pack][lane],
                    )
                }
            };
            let pack = &mut general.packs[to];
            pack[i % 2][to_lane] += value[i % 2];
            for a in 1..D {
                let side = 2 * a + (((c / 2) >> (a - 1)) & 1);
                pack[side][to_lane] += value[side];
            }
            general.dirichlet[to][to_lane] += dirichlet;
        }
    }
    None
}
