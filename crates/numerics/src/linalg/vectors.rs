//! Loops over whole vectors; sums are taken in an order that does not depend on the number of threads.

use rayon::prelude::*;

/// Entries per task.
const CHUNK: usize = 1 << 14;
/// Partial sums of a dot product.
const PARTIAL_SUMS: usize = 16;

/// `a · b` on one thread.
pub(super) fn dot_serial(a: &[f64], b: &[f64]) -> f64 {
    let (a_blocks, a_rest) = a.as_chunks::<PARTIAL_SUMS>();
    let (b_blocks, b_rest) = b.as_chunks::<PARTIAL_SUMS>();
    let mut sums = [0.0; PARTIAL_SUMS];
    for (a, b) in a_blocks.iter().zip(b_blocks) {
        for i in 0..PARTIAL_SUMS {
            sums[i] += a[i] * b[i];
        }
    }
    sums.iter().sum::<f64>() + a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum::<f64>()
}

/// Adds the products of the entries of `a` and `b`, whose length is a multiple of `N`, to sums by lane.
#[inline(always)]
pub(super) fn dot_lanes<const N: usize>(a: &[f64], b: &[f64], sums: &mut [f64; N]) {
    for (a, b) in a.as_chunks::<N>().0.iter().zip(b.as_chunks::<N>().0) {
        for l in 0..N {
            sums[l] += a[l] * b[l];
        }
    }
}

/// `a · b`.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    if a.len() <= CHUNK {
        return dot_serial(a, b);
    }
    let parts: Vec<f64> =
        a.par_chunks(CHUNK).zip(b.par_chunks(CHUNK)).map(|(a, b)| dot_serial(a, b)).collect();
    parts.iter().sum()
}

/// `r = scale (b − q)`; returns `r · r`.
pub(super) fn scaled_residual(scale: f64, b: &[f64], q: &[f64], r: &mut [f64]) -> f64 {
    let parts: Vec<f64> = r
        .par_chunks_mut(CHUNK)
        .zip(b.par_chunks(CHUNK).zip(q.par_chunks(CHUNK)))
        .map(|(r, (b, q))| {
            for ((r, b), q) in r.iter_mut().zip(b).zip(q) {
                *r = scale * (b - q);
            }
            dot_serial(r, r)
        })
        .collect();
    parts.iter().sum()
}

/// `r −= α q`; returns `r · r`.
pub(super) fn subtract_scaled(alpha: f64, q: &[f64], r: &mut [f64]) -> f64 {
    let parts: Vec<f64> = r
        .par_chunks_mut(CHUNK)
        .zip(q.par_chunks(CHUNK))
        .map(|(r, q)| {
            r.iter_mut().zip(q).for_each(|(r, q)| *r -= alpha * q);
            dot_serial(r, r)
        })
        .collect();
    parts.iter().sum()
}

/// `p = z`.
pub(super) fn copy(z: &[f64], p: &mut [f64]) {
    p.par_chunks_mut(CHUNK).zip(z.par_chunks(CHUNK)).for_each(|(p, z)| p.copy_from_slice(z));
}

/// `x += α p`, then `p = z + β p`.
pub(super) fn update_iterate_and_direction(alpha: f64, beta: f64, z: &[f64], x: &mut [f64], p: &mut [f64]) {
    x.par_chunks_mut(CHUNK).zip(p.par_chunks_mut(CHUNK).zip(z.par_chunks(CHUNK))).for_each(|(x, (p, z))| {
        for ((x, p), z) in x.iter_mut().zip(p.iter_mut()).zip(z) {
            *x += alpha * *p;
            *p = z + beta * *p;
        }
    });
}

/// `x += α p`.
pub(super) fn axpy(alpha: f64, p: &[f64], x: &mut [f64]) {
    x.par_chunks_mut(CHUNK)
        .zip(p.par_chunks(CHUNK))
        .for_each(|(x, p)| x.iter_mut().zip(p).for_each(|(x, p)| *x += alpha * p));
}

/// `p ← factor p`, and `v ← factor v`.
pub(super) fn scale(factor: f64, p: &mut [f64], v: &mut [f64]) {
    p.par_chunks_mut(CHUNK).zip(v.par_chunks_mut(CHUNK)).for_each(|(p, v)| {
        p.iter_mut().chain(v).for_each(|value| *value *= factor);
    });
}

/// `q −= α p + β p_last`.
pub(super) fn orthogonalise(alpha: f64, p: &[f64], beta: f64, p_last: &[f64], q: &mut [f64]) {
    let others = p.par_chunks(CHUNK).zip(p_last.par_chunks(CHUNK));
    q.par_chunks_mut(CHUNK).zip(others).for_each(|(q, (p, last))| {
        for ((q, p), last) in q.iter_mut().zip(p).zip(last) {
            *q -= alpha * p + beta * last;
        }
    });
}

/// `w_last ← factor (v − δ w − ε w_last)`.
pub(super) fn next_direction(
    factor: f64,
    v: &[f64],
    delta: f64,
    w: &[f64],
    epsilon: f64,
    w_last: &mut [f64],
) {
    let others = v.par_chunks(CHUNK).zip(w.par_chunks(CHUNK));
    w_last.par_chunks_mut(CHUNK).zip(others).for_each(|(last, (v, w))| {
        for ((last, v), w) in last.iter_mut().zip(v).zip(w) {
            *last = factor * (v - delta * w - epsilon * *last);
        }
    });
}

/// `r ← a r + b q`; returns `r · r`.
pub(super) fn combine(a: f64, b: f64, q: &[f64], r: &mut [f64]) -> f64 {
    let parts: Vec<f64> = r
        .par_chunks_mut(CHUNK)
        .zip(q.par_chunks(CHUNK))
        .map(|(r, q)| {
            r.iter_mut().zip(q).for_each(|(r, q)| *r = a * *r + b * q);
            dot_serial(r, r)
        })
        .collect();
    parts.iter().sum()
}
