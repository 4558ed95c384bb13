//! The loops over a level.

use super::layout::LANES;
use super::level::{Chunk, CoefficientPack, DIAGONAL, Span, SpanCoefficients};
use crate::linalg::Real;
use crate::par;

/// Runs `work` on every chunk together with the entries of `out` that belong to it; returns the results in
/// order.
pub fn over_chunks<T: Send, R: Send>(
    chunks: &[Chunk],
    out: &mut [T],
    work: impl Fn(&Chunk, &mut [T]) -> R + Sync,
) -> Vec<R> {
    let (mut rest, mut start) = (out, 0);
    let mut jobs = Vec::with_capacity(chunks.len());
    for chunk in chunks {
        let (part, tail) = rest.split_at_mut(chunk.entries.end - start);
        jobs.push((chunk, &mut part[chunk.entries.start - start..]));
        (rest, start) = (tail, chunk.entries.end);
    }
    par::map_jobs(jobs, |(chunk, part)| work(chunk, part))
}

/// The same with two arrays.
pub fn over_chunks_pair<T: Send, R: Send>(
    chunks: &[Chunk],
    out: [&mut [T]; 2],
    work: impl Fn(&Chunk, [&mut [T]; 2]) -> R + Sync,
) -> Vec<R> {
    let ([mut rest0, mut rest1], mut start) = (out, 0);
    let mut jobs = Vec::with_capacity(chunks.len());
    for chunk in chunks {
        let (part0, tail0) = rest0.split_at_mut(chunk.entries.end - start);
        let (part1, tail1) = rest1.split_at_mut(chunk.entries.end - start);
        let skip = chunk.entries.start - start;
        jobs.push((chunk, [&mut part0[skip..], &mut part1[skip..]]));
        (rest0, rest1, start) = (tail0, tail1, chunk.entries.end);
    }
    par::map_jobs(jobs, |(chunk, parts)| work(chunk, parts))
}

/// Inputs of one entry of a sweep.
#[derive(Clone, Copy)]
pub struct StencilRow<T> {
    /// Entry of the first array passed in.
    pub a: T,
    /// Entry of the second one.
    pub b: T,
    /// Sum of coefficient times neighbour.
    pub sum: T,
    /// Diagonal.
    pub diagonal: T,
    /// Its inverse.
    pub inverse: T,
}

/// Inputs of a sweep over the cells of one colour.
pub struct Operands<'a, T> {
    pub colour: usize,
    /// The coefficients.
    pub packs: &'a [CoefficientPack<T>],
    /// Scale of the coefficients of uniform spans.
    pub scale: f64,
    /// Values at the cells of the other colour.
    pub other: &'a [T],
    /// Two arrays over the cells of this colour.
    pub own: [&'a [T]; 2],
}

/// Writes `f` of every cell of one colour of a chunk into `out`, the entries of the chunk.
#[inline(always)]
pub fn sweep<T: Real, const D: usize>(
    chunk: &Chunk,
    operands: &Operands<T>,
    out: &mut [T],
    f: impl Fn(StencilRow<T>) -> T + Copy,
) {
    for span in &chunk.spans {
        let start = span.entry as usize - chunk.entries.start;
        sweep_span::<T, D>(span, operands, &mut out[start..start + span.blocks as usize * LANES], f);
    }
}

/// The same for one span.
#[inline(always)]
pub fn sweep_span<T: Real, const D: usize>(
    span: &Span,
    operands: &Operands<T>,
    out: &mut [T],
    f: impl Fn(StencilRow<T>) -> T + Copy,
) {
    match span.coefficients {
        SpanCoefficients::Uniform(value) => {
            sweep_uniform::<T, D>(span, operands, value * operands.scale, out, f)
        }
        SpanCoefficients::General(pack) => sweep_general::<T, D>(span, operands, pack as usize, out, f),
    }
}

/// The neighbours of a span: along its row, then along the other axes.
#[inline(always)]
fn neighbour_slices<'a, T, const D: usize>(span: &Span, operands: &Operands<'a, T>) -> [&'a [T]; 6] {
    let n = span.blocks as usize * LANES;
    let odd = operands.colour ^ span.parity as usize;
    let left = span.entry as usize + odd - 1;
    std::array::from_fn(|k| match k {
        0 => &operands.other[left..left + n],
        1 => &operands.other[left + 1..left + 1 + n],
        k if k < 2 * D => &operands.other[span.neighbours[k - 2] as usize..][..n],
        _ => &operands.other[left..left + n],
    })
}

#[inline(always)]
fn sweep_uniform<T: Real, const D: usize>(
    span: &Span,
    operands: &Operands<T>,
    value: f64,
    out: &mut [T],
    f: impl Fn(StencilRow<T>) -> T,
) {
    let blocks = out.len() / LANES;
    let [x0, x1, y0, y1, z0, z1] =
        neighbour_slices::<T, D>(span, operands).map(|s| &s.as_chunks::<LANES>().0[..blocks]);
    let at = span.entry as usize;
    let [a, b] = operands.own.map(|own| &own[at..].as_chunks::<LANES>().0[..blocks]);
    let out = &mut out.as_chunks_mut::<LANES>().0[..blocks];
    let c = T::from_f64(value);
    let diagonal = T::from_f64(value * (2 * D) as f64);
    let inverse = T::from_f64(1.0 / (value * (2 * D) as f64));
    for j in 0..blocks {
        // Keeps the compiler from vectorising across blocks with gathers, at no cost.
        std::hint::black_box(());
        let mut values = [T::default(); LANES];
        for l in 0..LANES {
            let mut sum = (x0[j][l] + x1[j][l]) + (y0[j][l] + y1[j][l]);
            if D == 3 {
                sum = sum + (z0[j][l] + z1[j][l]);
            }
            values[l] = f(StencilRow { a: a[j][l], b: b[j][l], sum: c * sum, diagonal, inverse });
        }
        out[j] = values;
    }
}

#[inline(always)]
fn sweep_general<T: Real, const D: usize>(
    span: &Span,
    operands: &Operands<T>,
    pack: usize,
    out: &mut [T],
    f: impl Fn(StencilRow<T>) -> T,
) {
    let n = out.len();
    let blocks = n / LANES;
    let [x0, x1, y0, y1, z0, z1] =
        neighbour_slices::<T, D>(span, operands).map(|s| &s.as_chunks::<LANES>().0[..blocks]);
    let at = span.entry as usize;
    let [a, b] = operands.own.map(|own| &own[at..].as_chunks::<LANES>().0[..blocks]);
    let packs = &operands.packs[pack..pack + blocks];
    let out = &mut out.as_chunks_mut::<LANES>().0[..blocks];
    for j in 0..blocks {
        // Keeps the compiler from vectorising across blocks with gathers, at no cost.
        std::hint::black_box(());
        let c = &packs[j];
        let mut values = [T::default(); LANES];
        for l in 0..LANES {
            let mut sum =
                (c[0][l] * x0[j][l] + c[1][l] * x1[j][l]) + (c[2][l] * y0[j][l] + c[3][l] * y1[j][l]);
            if D == 3 {
                sum = sum + (c[4][l] * z0[j][l] + c[5][l] * z1[j][l]);
            }
            let diagonal = c[DIAGONAL][l];
            let inverse = T::from_f64(1.0) / diagonal;
            values[l] = f(StencilRow { a: a[j][l], b: b[j][l], sum, diagonal, inverse });
        }
        out[j] = values;
    }
}

/// Sets the two halves of a coarse right-hand side to the sums of the residual over the children. The residual of colour 1 is zero.
pub fn restrict<const D: usize>(chunk: &Chunk, fine: &[f32], out: [&mut [f32]; 2]) {
    let [even_out, odd_out] = out;
    let mut block = 0;
    for span in &chunk.spans {
        let start = span.entry as usize - chunk.entries.start;
        for b in 0..span.blocks as usize {
            let children = &chunk.children[block];
            block += 1;
            let mut sums = [[0.0_f32; LANES]; 2];
            for (c, child) in children[..1 << D].iter().enumerate() {
                let values = &fine[*child as usize..*child as usize + LANES];
                for l in 0..LANES {
                    sums[c % 2][l] += values[l];
                }
            }
            let flat = sums.as_flattened();
            let at = start + b * LANES;
            let (even, odd) = (&mut even_out[at..at + LANES], &mut odd_out[at..at + LANES]);
            let (first, second) = if span.parity == 0 { (even, odd) } else { (odd, even) };
            for l in 0..LANES {
                first[l] = flat[2 * l];
                second[l] = flat[2 * l + 1];
            }
        }
    }
}

/// Adds `factor` times the coarse values to those of colour 0.
pub fn prolong(chunk: &Chunk, coarse: [&[f32]; 2], factor: f32, out: &mut [f32]) {
    for span in &chunk.spans {
        let n = span.blocks as usize * LANES;
        let start = span.entry as usize - chunk.entries.start;
        let parent = span.parent as usize..span.parent as usize + n / 2;
        let colour = span.parent_parity as usize;
        let (even, odd) = (&coarse[colour][parent.clone()], &coarse[1 - colour][parent]);
        for ((out, even), odd) in out[start..start + n].as_chunks_mut::<2>().0.iter_mut().zip(even).zip(odd) {
            out[0] += factor * even;
            out[1] += factor * odd;
        }
    }
}
