//! Aggregation multigrid: the preconditioner of the pressure solve.
//!
//! Aggregates have `2^D` cells, and the prolongation is piecewise constant. Galerkin coarse operators have sums of fine coefficients, so
//! no cell has to be classified again on a coarse level. The coarse-grid correction is over-corrected (Braess, Computing 55 (1995) 379;
//! Stüben, J. Comput. Appl. Math. 128 (2001) 281). Red-black Gauss-Seidel runs in one order before and in the reverse order after the
//! correction, which keeps the V-cycle symmetric. The cycle runs in single precision.

use super::layout::{Layout, ZERO_ENTRY};
use super::level::{
    BlockCoefficients, Chunk, CoefficientPack, DIAGONAL, SpanCoefficients, aggregate, build_chunks,
};
use super::sweep::{Operands, over_chunks, over_chunks_pair, prolong, restrict, sweep};
use crate::linalg::operator::Preconditioner;
use crate::par;
use std::sync::{Mutex, PoisonError};

/// Red-black sweeps before and after the coarse-grid correction.
const SMOOTHING_SWEEPS: usize = 2;
/// Over-correction: factor on the coarse-grid correction.
const OVERCORRECTION: f32 = 2.0;
/// Sweeps before and after on the coarsest level.
const COARSEST_SWEEPS: usize = 20;
/// The coarsest level has at most this many cells along each axis.
const COARSEST_MAX_CELLS: usize = 8;

/// One level of the hierarchy.
#[derive(Debug)]
pub struct Level<const D: usize> {
    pub layout: Layout<D>,
    pub chunks: Vec<Chunk>,
}

/// Work vectors of a level, by colour.
#[derive(Debug, Default)]
pub struct Workspace {
    x: [Vec<f32>; 2],
    b: [Vec<f32>; 2],
    residual: Vec<f32>,
}

/// The hierarchy.
#[derive(Debug)]
pub struct Hierarchy<const D: usize> {
    pub levels: Vec<Level<D>>,
    /// Factor from the coefficients to those in single precision.
    scale: f64,
    work: Mutex<Vec<Workspace>>,
}

impl<const D: usize> Hierarchy<D> {
    /// Builds the coarse levels below `finest`, whose chunks were built with `coarse` as its coarser layout.
    ///
    /// `work` may hold the memory of an earlier hierarchy.
    pub fn new(finest: Level<D>, coarse: Option<Layout<D>>, mut work: Vec<Workspace>) -> Self {
        let mut levels = vec![finest];
        let mut next = coarse;
        while let (Some(layout), Some(fine)) = (next.take(), levels.last()) {
            let coarser = coarsened(&layout);
            let mut chunks = {
                let kinds = block_coefficients(&fine.chunks);
                build_chunks(&layout, coarser.as_ref(), |site, general: &mut BlockCoefficients| {
                    aggregate(&fine.layout, &fine.chunks, &kinds, site, general)
                })
            };
            par::for_each_mut(&mut chunks, 1, |_, chunk| set_children(chunk, &layout, &fine.layout));
            levels.push(Level { layout, chunks });
            next = coarser;
        }
        let scale = 1.0 / max_coefficient(&levels[0].chunks);
        for (l, level) in levels.iter_mut().enumerate() {
            par::for_each_mut(&mut level.chunks, 1, |_, chunk| round_to_single(chunk, scale, l > 0));
        }
        work.resize_with(levels.len(), Workspace::default);
        work.iter_mut().zip(&levels).for_each(|(work, level)| work.prepare(&level.layout));
        Self { levels, scale, work: Mutex::new(work) }
    }

    /// The work memory, for the next hierarchy.
    pub fn into_work(self) -> Vec<Workspace> {
        self.work.into_inner().unwrap_or_else(PoisonError::into_inner)
    }

    fn v_cycle(&self, depth: usize, work: &mut [Workspace]) {
        let Some((own, coarser)) = work.split_first_mut() else { return };
        let chunks = &self.levels[depth].chunks;
        let smooth = |own: &mut Workspace, colour: usize| {
            let (first, second) = own.x.split_at_mut(1);
            let (out, other) =
                if colour == 0 { (&mut first[0], &second[0]) } else { (&mut second[0], &first[0]) };
            let b = &own.b[colour];
            over_chunks(chunks, out, |chunk, out| {
                let packs = &chunk.packs_f32[colour];
                let operands = Operands { colour, packs, scale: self.scale, other, own: [b, b] };
                sweep::<f32, D>(chunk, &operands, out, |row| (row.a + row.sum) * row.inverse);
            });
        };
        self.smooth_from_zero(own, chunks);
        let sweeps = if coarser.is_empty() { COARSEST_SWEEPS } else { SMOOTHING_SWEEPS };
        smooth(own, 1);
        for _ in 1..sweeps {
            smooth(own, 0);
            smooth(own, 1);
        }
        if let Some(next) = coarser.first_mut() {
            self.residual(own, chunks);
            let [even, odd] = &mut next.b;
            over_chunks_pair(&self.levels[depth + 1].chunks, [even, odd], |chunk, out| {
                restrict::<D>(chunk, &own.residual, out);
            });
            self.v_cycle(depth + 1, coarser);
            let coarse = &coarser[0].x;
            over_chunks(chunks, &mut own.x[0], |chunk, out| {
                prolong(chunk, [&coarse[0], &coarse[1]], OVERCORRECTION, out);
            });
        }
        for _ in 0..sweeps {
            smooth(own, 1);
            smooth(own, 0);
        }
    }

    /// First half of the first sweep, from zero.
    fn smooth_from_zero(&self, own: &mut Workspace, chunks: &[Chunk]) {
        let b = &own.b[0];
        over_chunks(chunks, &mut own.x[0], |chunk, out| {
            let packs = &chunk.packs_f32[0];
            let operands = Operands { colour: 0, packs, scale: self.scale, other: b, own: [b, b] };
            sweep::<f32, D>(chunk, &operands, out, |row| row.a * row.inverse);
        });
    }

    /// Residual of colour 0 (that of colour 1 is zero after a sweep).
    fn residual(&self, own: &mut Workspace, chunks: &[Chunk]) {
        let (x, b) = (&own.x, &own.b);
        over_chunks(chunks, &mut own.residual, |chunk, out| {
            let packs = &chunk.packs_f32[0];
            let operands =
                Operands { colour: 0, packs, scale: self.scale, other: &x[1], own: [&b[0], &x[0]] };
            sweep::<f32, D>(chunk, &operands, out, |row| row.a + row.sum - row.diagonal * row.b);
        });
    }
}

impl<const D: usize> Preconditioner for Hierarchy<D> {
    fn apply(&self, r: &[f64], z: &mut [f64]) -> f64 {
        let mut work = self.work.lock().unwrap_or_else(PoisonError::into_inner);
        let half = self.levels[0].layout.half_length;
        let Some(own) = work.first_mut() else { return 0.0 };
        for (b, r) in own.b.iter_mut().zip(r.chunks(half)) {
            over_chunks(&self.levels[0].chunks, b, |chunk, b| {
                b.iter_mut().zip(&r[chunk.entries.clone()]).for_each(|(b, r)| *b = *r as f32);
            });
        }
        self.v_cycle(0, &mut work);
        let mut dot = 0.0;
        for (colour, z) in z.chunks_mut(half).enumerate() {
            let x = &work[0].x[colour];
            let r = &r[colour * half..];
            let sums = over_chunks(&self.levels[0].chunks, z, |chunk, z| {
                let x = &x[chunk.entries.clone()];
                z.iter_mut().zip(x).for_each(|(z, x)| *z = f64::from(*x) * self.scale);
                crate::linalg::vectors::dot_serial(z, &r[chunk.entries.clone()])
            });
            dot += sums.iter().sum::<f64>();
        }
        dot
    }
}

impl Workspace {
    fn prepare<const D: usize>(&mut self, layout: &Layout<D>) {
        self.x.iter_mut().chain(&mut self.b).for_each(|half| layout.prepare(half, 1));
        layout.prepare(&mut self.residual, 1);
    }
}

/// The next layout, unless the given one is the coarsest.
pub fn coarsened<const D: usize>(layout: &Layout<D>) -> Option<Layout<D>> {
    layout.extent.iter().any(|n| *n > COARSEST_MAX_CELLS).then(|| layout.coarsened())
}

/// For each block its chunk and its coefficients.
fn block_coefficients(chunks: &[Chunk]) -> Vec<(u32, SpanCoefficients)> {
    chunks
        .iter()
        .zip(0..)
        .flat_map(|(chunk, c)| chunk.block_coefficients.iter().map(move |kind| (c, *kind)))
        .collect()
}

/// Stores where the children of each block are.
fn set_children<const D: usize>(chunk: &mut Chunk, layout: &Layout<D>, fine: &Layout<D>) {
    for stretch in &layout.block_runs[chunk.block_runs.clone()] {
        let at = layout.row_coordinates(stretch.row as usize);
        for block in stretch.block..stretch.block + stretch.blocks {
            chunk.children.push(std::array::from_fn(|c| {
                let row = if c < 1 << D { fine.child_row(at, c / 2) } else { None };
                row.and_then(|row| fine.find(row, 2 * block as usize + c % 2))
                    .map_or(ZERO_ENTRY, |(entry, _)| entry)
            }));
        }
    }
}

/// The largest coefficient of a level (1 if there is none).
fn max_coefficient(chunks: &[Chunk]) -> f64 {
    let of_chunk = |chunk: &Chunk| {
        let packs = chunk.packs_f64.iter().flatten().zip(chunk.dirichlet.iter().flatten());
        let general = packs.flat_map(|(pack, _)| pack[..DIAGONAL].iter().flatten());
        let uniform = chunk.spans.iter().map(|span| match span.coefficients {
            SpanCoefficients::Uniform(value) => value,
            SpanCoefficients::General(_) => 0.0,
        });
        let dirichlet = chunk.dirichlet.iter().flatten().flatten();
        general.chain(dirichlet).copied().chain(uniform).fold(0.0, f64::max)
    };
    let largest = par::reduce(chunks.len(), 1, 0.0, |c| of_chunk(&chunks[c]), f64::max);
    if largest > 0.0 { largest } else { 1.0 }
}

/// Rounds the coefficients to single precision and drops data that only building the hierarchy needs.
fn round_to_single(chunk: &mut Chunk, scale: f64, coarse: bool) {
    for colour in 0..2 {
        let rounded = chunk.packs_f64[colour].iter().map(|pack| {
            let mut out: CoefficientPack<f32> = [[0.0; super::layout::LANES]; 7];
            for (out, wide) in out.as_flattened_mut().iter_mut().zip(pack.as_flattened()) {
                *out = (wide * scale) as f32;
            }
            for (out, wide) in out[DIAGONAL].iter_mut().zip(&pack[DIAGONAL]) {
                // The diagonal of an empty row is 1 before scaling; any positive value is valid.
                *out = ((wide * scale) as f32).max(f32::MIN_POSITIVE);
            }
            out
        });
        chunk.packs_f32[colour] = rounded.collect();
        chunk.dirichlet[colour] = Vec::new();
        if coarse {
            chunk.packs_f64[colour] = Vec::new();
        }
    }
    chunk.block_coefficients = Vec::new();
}
