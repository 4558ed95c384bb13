//! Parallel loops whose results do not depend on the number of threads.
//!
//! A loop is cut into tasks, which `run` distributes over the threads of the current pool. It calls them through a pointer, so that the
//! distribution is compiled once; iterators of rayon are compiled anew for each loop (book, E49).

use crate::grid::Segment;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

/// Number of values that are summed serially in a chunk.
const CHUNK: usize = 4096;
/// Largest number of tasks of a loop whose results do not depend on its division: enough for threads that finish at different times.
const MAX_TASKS: usize = 256;
/// Least number of segments of a task.
const SEGMENTS_PER_TASK: usize = 16;

/// Calls `task(k)` for `k` in `0..count`.
fn run(count: usize, task: &(dyn Fn(usize) + Sync)) {
    if count < 2 || threads() < 2 {
        (0..count).for_each(task);
    } else {
        (0..count).into_par_iter().with_max_len(1).for_each(task);
    }
}

/// `task(k)` for `k` in `0..count`.
fn results<R: Send>(count: usize, task: impl Fn(usize) -> R + Sync) -> Vec<R> {
    let slots: Vec<Mutex<Option<R>>> = (0..count).map(|_| Mutex::new(None)).collect();
    run(count, &|k| {
        let result = task(k);
        *slots[k].lock().unwrap_or_else(PoisonError::into_inner) = Some(result);
    });
    slots.into_iter().filter_map(|slot| slot.into_inner().unwrap_or_else(PoisonError::into_inner)).collect()
}

/// Number of indices of a task: at least `min_length`.
fn task_length(n: usize, min_length: usize) -> usize {
    let most = if threads() < 2 { 1 } else { MAX_TASKS };
    min_length.max(n.div_ceil(most)).max(1)
}

/// `f` of every chunk of `length` indices below `n`.
fn map_chunks<R: Send>(n: usize, length: usize, f: impl Fn(Range<usize>) -> R + Sync) -> Vec<R> {
    results(n.div_ceil(length), |c| f(c * length..((c + 1) * length).min(n)))
}

/// Joins lists.
fn joined<R>(mut lists: Vec<Vec<R>>) -> Vec<R> {
    if lists.len() == 1 {
        return lists.remove(0);
    }
    let mut all = Vec::with_capacity(lists.iter().map(Vec::len).sum());
    lists.iter_mut().for_each(|list| all.append(list));
    all
}

/// `f(i)` for `i` in `0..n`; a task takes at least `min_length` of them.
pub fn map<R: Send>(n: usize, min_length: usize, f: impl Fn(usize) -> R + Sync) -> Vec<R> {
    joined(map_chunks(n, task_length(n, min_length), |range| range.map(&f).collect()))
}

/// `f` of each item; see [`map`].
pub fn map_slice<T: Sync, R: Send>(items: &[T], min_length: usize, f: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let tasks = map_chunks(items.len(), task_length(items.len(), min_length), |range| {
        items[range].iter().map(&f).collect()
    });
    joined(tasks)
}

/// What `f(i, ·)` appends for `i` in `0..n`, in this order; a task takes at least `min_length` of them.
pub fn flat_map<R: Send>(n: usize, min_length: usize, f: impl Fn(usize, &mut Vec<R>) + Sync) -> Vec<R> {
    let tasks = map_chunks(n, task_length(n, min_length), |range| {
        let mut out = Vec::new();
        range.for_each(|i| f(i, &mut out));
        out
    });
    joined(tasks)
}

/// The values that `f(i)` has for `i` in `0..n`; see [`flat_map`].
pub fn filter_map<R: Send>(n: usize, min_length: usize, f: impl Fn(usize) -> Option<R> + Sync) -> Vec<R> {
    flat_map(n, min_length, |i, out| out.extend(f(i)))
}

/// Calls `f` with the index and the item for every item of `data`; a task takes at least `min_length` items.
pub fn for_each_mut<T: Send>(data: &mut [T], min_length: usize, f: impl Fn(usize, &mut T) + Sync) {
    let length = task_length(data.len(), min_length);
    map_chunks_mut([data], length, |range, [chunk]| range.zip(chunk).for_each(|(i, item)| f(i, item)));
}

/// What `f` returns for every chunk of `length` entries of `N` arrays of the same length, in order; it takes the range of indices and
/// the entries.
pub fn map_chunks_mut<T: Send, R: Send, const N: usize>(
    arrays: [&mut [T]; N],
    length: usize,
    f: impl Fn(Range<usize>, [&mut [T]; N]) -> R + Sync,
) -> Vec<R> {
    let n = arrays.first().map_or(0, |array| array.len());
    if n <= length {
        return if n == 0 { Vec::new() } else { vec![f(0..n, arrays)] };
    }
    let mut chunks = arrays.map(|array| array.chunks_mut(length));
    let range = |c: usize| c * length..((c + 1) * length).min(n);
    let mut job = |c| (range(c), chunks.each_mut().map(|chunks| chunks.next().unwrap_or_default()));
    let jobs: Vec<_> = (0..n.div_ceil(length)).map(&mut job).collect();
    map_jobs(jobs, |(range, chunks)| f(range, chunks))
}

/// What `f` makes of each job, in their order; every job is a task.
pub fn map_jobs<J: Send, R: Send>(jobs: Vec<J>, f: impl Fn(J) -> R + Sync) -> Vec<R> {
    if jobs.len() < 2 || threads() < 2 {
        return jobs.into_iter().map(f).collect();
    }
    let jobs: Vec<Mutex<Option<J>>> = jobs.into_iter().map(|job| Mutex::new(Some(job))).collect();
    let take = |k: usize| jobs[k].lock().unwrap_or_else(PoisonError::into_inner).take();
    results(jobs.len(), |k| take(k).map(&f)).into_iter().flatten().collect()
}

/// `f(i)` for `i` in `0..n` combined with `combine`, which must be associative and commutative to the last bit, as minimum and
/// maximum are; `start` where `n` is 0.
pub fn reduce(
    n: usize,
    min_length: usize,
    start: f64,
    f: impl Fn(usize) -> f64 + Sync,
    combine: fn(f64, f64) -> f64,
) -> f64 {
    let tasks = map_chunks(n, task_length(n, min_length), |range| range.map(&f).fold(start, combine));
    tasks.into_iter().fold(start, combine)
}

/// Whether `f(i)` holds for all `i` in `0..n`; a task takes at least `min_length` of them.
pub fn all(n: usize, min_length: usize, f: impl Fn(usize) -> bool + Sync) -> bool {
    map_chunks(n, task_length(n, min_length), |mut range| range.all(&f)).into_iter().all(|all| all)
}

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
    let chunk = |range: Range<usize>| range.map(&f).fold([0.0; K], add);
    if n <= CHUNK {
        return chunk(0..n);
    }
    map_chunks(n, CHUNK, chunk).into_iter().fold([0.0; K], add)
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
    let mut parts = segment_parts(data, row_length, segments);
    for_each_mut(&mut parts, SEGMENTS_PER_TASK, |_, (s, part)| f(s, part));
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
    let mut parts: Vec<_> = segments.iter().map(|s| (s, part())).collect();
    let length = task_length(parts.len(), SEGMENTS_PER_TASK);
    let chunks = map_chunks_mut([&mut parts], length, |numbers, [parts]| {
        let each = numbers.zip(parts);
        let results = each.map(|(number, (s, parts))| f(number, s, parts.each_mut().map(|part| &mut **part)));
        results.collect::<Vec<R>>()
    });
    chunks.into_iter().flatten().collect()
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Every loop gives what a serial one gives, for numbers below, at and above the size of tasks.
    #[test]
    fn loops_give_the_serial_result_on_any_number_of_threads() {
        let check = || {
            for n in [0, 1, 2, 15, 16, 17, 1000, 3 * CHUNK + 5] {
                let square = |i: usize| (i * i) as f64;
                let squares: Vec<f64> = (0..n).map(square).collect();
                assert_eq!(map(n, 16, square), squares);
                assert_eq!(map_slice(&squares, 1, |x| x.sqrt() as usize), (0..n).collect::<Vec<_>>());
                let odd = |i: usize| (i % 2 == 1).then_some(i);
                assert_eq!(filter_map(n, 16, odd), (0..n).filter_map(odd).collect::<Vec<_>>());
                let twice = flat_map(n, 1, |i, out| out.extend([i, i]));
                assert_eq!(twice, (0..2 * n).map(|i| i / 2).collect::<Vec<_>>());
                let mut data = squares.clone();
                for_each_mut(&mut data, 16, |i, x| *x -= square(i));
                assert!(data.iter().all(|x| *x == 0.0));
                let lengths =
                    map_chunks_mut([&mut data, &mut squares.clone()], 16, |range, [data, squares]| {
                        data.copy_from_slice(squares);
                        range.len()
                    });
                assert_eq!((data, lengths.iter().sum::<usize>()), (squares.clone(), n));
                let jobs: Vec<String> = (0..n).map(|i| i.to_string()).collect();
                assert_eq!(map_jobs(jobs.clone(), |job| job), jobs);
                assert_eq!(reduce(n, 16, 0.0, square, f64::max), squares.iter().copied().fold(0.0, f64::max));
                assert!(all(n, 16, |i| squares[i] >= 0.0));
                assert_eq!(all(n, 16, |i| i + 1 < n), n == 0);
                assert_eq!(sum(n, square), squares.chunks(CHUNK).map(|c| c.iter().sum::<f64>()).sum::<f64>());
            }
        };
        for threads in [1, 3] {
            rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(check);
        }
    }
}
