//! Parallel loops whose results do not depend on the number of threads.

use rayon::prelude::*;

/// Values summed one after another within a chunk.
const CHUNK: usize = 4096;

/// The sum of `f(i)` for `i` in `0..n`, in an order that does not depend on the number of threads.
pub fn sum(n: usize, f: impl Fn(usize) -> f64 + Sync) -> f64 {
    let chunks: Vec<f64> = (0..n.div_ceil(CHUNK))
        .into_par_iter()
        .map(|c| (c * CHUNK..((c + 1) * CHUNK).min(n)).map(&f).sum())
        .collect();
    chunks.iter().sum()
}
