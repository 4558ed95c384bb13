//! Loops over whole vectors; sums are taken in an order that does not depend on the number of threads.

use super::Real;
use crate::par;

/// Entries per task.
const CHUNK: usize = 1 << 14;
/// Partial sums of a dot product.
const PARTIAL_SUMS: usize = 16;

/// `a · b` on one thread.
pub fn dot_serial<T: Real>(a: &[T], b: &[T]) -> f64 {
    let (a_blocks, a_rest) = a.as_chunks::<PARTIAL_SUMS>();
    let (b_blocks, b_rest) = b.as_chunks::<PARTIAL_SUMS>();
    let mut sums = [0.0; PARTIAL_SUMS];
    for (a, b) in a_blocks.iter().zip(b_blocks) {
        for i in 0..PARTIAL_SUMS {
            sums[i] += a[i].to_f64() * b[i].to_f64();
        }
    }
    sums.iter().sum::<f64>() + a_rest.iter().zip(b_rest).map(|(a, b)| a.to_f64() * b.to_f64()).sum::<f64>()
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
pub fn dot<T: Real>(a: &[T], b: &[T]) -> f64 {
    if a.len() <= CHUNK {
        return dot_serial(a, b);
    }
    let chunk = |c: usize| c * CHUNK..((c + 1) * CHUNK).min(a.len());
    let parts = par::map(a.len().div_ceil(CHUNK), 1, |c| dot_serial(&a[chunk(c)], &b[chunk(c)]));
    parts.iter().sum()
}

/// `r = scale (b − q)`; returns `r · r`.
pub(super) fn scaled_residual(scale: f64, b: &[f64], q: &[f64], r: &mut [f64]) -> f64 {
    let parts = par::map_chunks_mut([r], CHUNK, |range, [r]| {
        for ((r, b), q) in r.iter_mut().zip(&b[range.clone()]).zip(&q[range]) {
            *r = scale * (b - q);
        }
        dot_serial(r, r)
    });
    parts.iter().sum()
}

/// `r −= α q`; returns `r · r`.
pub(super) fn subtract_scaled<T: Real>(alpha: f64, q: &[T], r: &mut [T]) -> f64 {
    let alpha = T::from_f64(alpha);
    let parts = par::map_chunks_mut([r], CHUNK, |range, [r]| {
        r.iter_mut().zip(&q[range]).for_each(|(r, q)| *r = *r - alpha * *q);
        dot_serial(r, r)
    });
    parts.iter().sum()
}

/// `r −= α q`, then `q = d r`; returns `r · r` and `r · q`.
pub(super) fn subtract_scaled_and_multiply<T: Real>(
    alpha: f64,
    d: &[T],
    q: &mut [T],
    r: &mut [T],
) -> [f64; 2] {
    let alpha = T::from_f64(alpha);
    let parts = par::map_chunks_mut([r, q], CHUNK, |range, [r, q]| {
        let mut sums = [[0.0; PARTIAL_SUMS]; 2];
        let mut entry = |l: usize, r: &mut T, q: &mut T, d: T| {
            *r = *r - alpha * *q;
            *q = d * *r;
            sums[0][l] += r.to_f64() * r.to_f64();
            sums[1][l] += r.to_f64() * q.to_f64();
        };
        let (r_blocks, r_rest) = r.as_chunks_mut::<PARTIAL_SUMS>();
        let (q_blocks, q_rest) = q.as_chunks_mut::<PARTIAL_SUMS>();
        let (d_blocks, d_rest) = d[range].as_chunks::<PARTIAL_SUMS>();
        for ((r, q), d) in r_blocks.iter_mut().zip(q_blocks).zip(d_blocks) {
            for l in 0..PARTIAL_SUMS {
                entry(l, &mut r[l], &mut q[l], d[l]);
            }
        }
        for (l, ((r, q), d)) in r_rest.iter_mut().zip(q_rest).zip(d_rest).enumerate() {
            entry(l, r, q, *d);
        }
        sums.map(|lanes| lanes.iter().sum::<f64>())
    });
    parts.iter().fold([0.0; 2], |sums, part| [sums[0] + part[0], sums[1] + part[1]])
}

/// The entries of `v` in another precision.
pub(super) fn converted<T: Real, U: Real>(v: &[T]) -> Vec<U> {
    par::map_slice(v, CHUNK, |v| U::from_f64(v.to_f64()))
}

/// `p = z`.
pub(super) fn copy<T: Real>(z: &[T], p: &mut [T]) {
    par::map_chunks_mut([p], CHUNK, |range, [p]| p.copy_from_slice(&z[range]));
}

/// `x += α p`, then `p = z + β p`.
pub(super) fn update_iterate_and_direction<T: Real>(
    alpha: f64,
    beta: f64,
    z: &[T],
    x: &mut [T],
    p: &mut [T],
) {
    let [alpha, beta] = [alpha, beta].map(T::from_f64);
    par::map_chunks_mut([x, p], CHUNK, |range, [x, p]| {
        for ((x, p), z) in x.iter_mut().zip(p).zip(&z[range]) {
            *x = *x + alpha * *p;
            *p = *z + beta * *p;
        }
    });
}

/// `x += α p`.
pub(super) fn axpy<T: Real>(alpha: f64, p: &[T], x: &mut [T]) {
    let alpha = T::from_f64(alpha);
    par::map_chunks_mut([x], CHUNK, |range, [x]| {
        x.iter_mut().zip(&p[range]).for_each(|(x, p)| *x = *x + alpha * *p);
    });
}

/// `p = a p + b d r` with the `factors` `a` and `b`, then `x += p`.
pub(super) fn add_preconditioned_step<T: Real>(
    factors: [f64; 2],
    d: &[T],
    r: &[T],
    p: &mut [T],
    x: &mut [T],
) {
    let [a, b] = factors.map(T::from_f64);
    par::map_chunks_mut([x, p], CHUNK, |range, [x, p]| {
        for ((x, p), (r, d)) in x.iter_mut().zip(p).zip(r[range.clone()].iter().zip(&d[range])) {
            *p = a * *p + b * (*d * *r);
            *x = *x + *p;
        }
    });
}

/// `p ← factor p`, and `v ← factor v`.
pub(super) fn scale(factor: f64, p: &mut [f64], v: &mut [f64]) {
    par::map_chunks_mut([p, v], CHUNK, |_, [p, v]| {
        p.iter_mut().chain(v).for_each(|value| *value *= factor);
    });
}

/// `q −= α p + β p_last`.
pub(super) fn orthogonalise(alpha: f64, p: &[f64], beta: f64, p_last: &[f64], q: &mut [f64]) {
    par::map_chunks_mut([q], CHUNK, |range, [q]| {
        for ((q, p), last) in q.iter_mut().zip(&p[range.clone()]).zip(&p_last[range]) {
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
    par::map_chunks_mut([w_last], CHUNK, |range, [last]| {
        for ((last, v), w) in last.iter_mut().zip(&v[range.clone()]).zip(&w[range]) {
            *last = factor * (v - delta * w - epsilon * *last);
        }
    });
}

/// `r ← a r + b q`; returns `r · r`.
pub(super) fn combine(a: f64, b: f64, q: &[f64], r: &mut [f64]) -> f64 {
    let parts = par::map_chunks_mut([r], CHUNK, |range, [r]| {
        r.iter_mut().zip(&q[range]).for_each(|(r, q)| *r = a * *r + b * q);
        dot_serial(r, r)
    });
    parts.iter().sum()
}
