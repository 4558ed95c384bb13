//! Parallel loops whose results do not depend on the number of threads.

use crate::grid::Segment;
use rayon::prelude::*;

/// Number of values that are summed serially in a chunk.
const CHUNK: usize = 4096;

/// The sum of `f(i)` for `i` in `0..n`, in an order that does not depend on the number of threads.
pub fn sum(n: usize, f: impl Fn(usize) -> f64 + Sync) -> f64 {
    sums(n, |i| [f(i)])[0]
}

/// Computes `K` sums at once; see [`sum`].
pub fn sums<const K: usize>(n: usize, f: impl Fn(usize) -> [f64; K] + Sync) -> [f64; K] {
    let add = |mut a: [f64; K], b: [f64; K]| {
        (0..K).for_each(|k| a[k] += b[k]);
        a
    };
    let chunk = |c: usize| (c * CHUNK..((c + 1) * CHUNK).min(n)).map(&f).fold([0.0; K], add);
    if n <= CHUNK {
        return chunk(0);
    }
    let chunks: Vec<[f64; K]> = (0..n.div_ceil(CHUNK)).into_par_iter().map(chunk).collect();
    chunks.into_iter().fold([0.0; K], add)
}

/// Calls `f` in parallel with every segment and its part of `data`, whose rows have `row_length` values.
///
/// The segments must be sorted and disjoint, as those of [`crate::grid::Tiles`] and [`crate::grid::Runs`] are.
pub fn for_each_segment<T: Send>(
    data: &mut [T],
    row_length: usize,
    segments: &[Segment],
    f: impl Fn(&Segment, &mut [T]) + Sync,
) {
    let parts = segment_parts(data, row_length, segments);
    parts.into_par_iter().with_min_len(16).for_each(|(s, part)| f(s, part));
}

/// The same for `D` fields of `length` values one behind the other: `f` takes the number of the segment and the parts of all fields. Its
/// results are returned in the order of the segments, all of which are of row 0.
pub fn map_component_segments<T: Send, R: Send, const D: usize>(
    data: &mut [T],
    length: usize,
    segments: &[Segment],
    f: impl Fn(usize, &Segment, [&mut [T]; D]) -> R + Sync,
) -> Vec<R> {
    let mut fields =
        data.chunks_mut(length.max(1)).map(|field| segment_parts(field, 0, segments).into_iter());
    let mut fields: [_; D] = std::array::from_fn(|_| fields.next().into_iter().flatten());
    let mut part = || fields.each_mut().map(|field| field.next().map_or(&mut [][..], |(_, part)| part));
    let parts: Vec<_> = segments.iter().map(|s| (s, part())).collect();
    let parts = parts.into_par_iter().enumerate().with_min_len(16);
    parts.map(|(number, (s, parts))| f(number, s, parts)).collect()
}

/// The parts of `data` of sorted, disjoint segments.
fn segment_parts<'s, 'd, T>(
    data: &'d mut [T],
    row_length: usize,
    segments: &'s [Segment],
) -> Vec<(&'s Segment, &'d mut [T])> {
    let mut parts = Vec::with_capacity(segments.len());
    let (mut rest, mut at) = (data, 0);
    for s in segments {
        let start = s.row * row_length + s.start;
        let (_, tail) = rest.split_at_mut(start - at);
        let (part, tail) = tail.split_at_mut(s.end - s.start);
        parts.push((s, part));
        (rest, at) = (tail, s.row * row_length + s.end);
    }
    parts
}

/// Number of threads on which parallel loops run.
pub fn threads() -> usize {
    rayon::current_num_threads()
}
