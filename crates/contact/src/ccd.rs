//! Continuous collision detection: step fractions without contact or inversion of elements.

use crate::distance::{ClosestPair, StencilKind};
use meniscus_numerics::{Matrix, Vector};

/// Fraction of the bound by which an iteration advances (Li et al. 2021, algorithm 1); 1 would be safe but for rounding. The iteration
/// ends when less than one minus this fraction of the distance that may be given up remains.
const ADVANCE_FRACTION: f64 = 0.9;
/// Largest number of iterations for a pair. Features that pass each other closely and fast take many.
const MAX_CCD_ITERATIONS: usize = 1000;
/// Bisections of the interval in which an element inverts.
const BISECTION_ITERATIONS: usize = 60;

/// Minimum separation of two features.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clearance {
    /// Distance, m, that counts as zero.
    pub thickness: f64,
    /// Fraction of the distance beyond the thickness that must remain.
    pub kept_fraction: f64,
}

/// Conservative fraction, at most 1, of the linear motion from `x` along `displacements` for which two features keep a clearance
/// (additive continuous collision detection: M. Li, D. M. Kaufman, C. Jiang, "Codimensional incremental potential contact", ACM Trans.
/// Graph. 40(4), 2021, §5). The distance decreases by no more than the relative motion.
pub fn collision_free_fraction<const D: usize>(
    kind: StencilKind,
    x: &[Vector<D>; 4],
    displacements: &[Vector<D>; 4],
    Clearance { thickness, kept_fraction }: Clearance,
) -> f64 {
    let count = kind.point_count();
    let mean: Vector<D> = displacements[..count].iter().sum::<Vector<D>>() / count as f64;
    let speed = kind.relative_motion(displacements);
    let distance = |part: f64| {
        let at = std::array::from_fn(|k| x[k] + (displacements[k] - mean) * part);
        ClosestPair::new(kind, &at).distance() - thickness
    };
    if ADVANCE_FRACTION * (1.0 - kept_fraction) * (kind.least_distance(x) - thickness) >= speed {
        return 1.0;
    }
    let start = distance(0.0);
    let (least, mut part) = (kept_fraction * start, 0.0);
    let mut far = start;
    // The result after the last iteration is safe but not the largest.
    for _ in 0..MAX_CCD_ITERATIONS {
        let next = part + ADVANCE_FRACTION * (far - least) / speed;
        // Without relative motion the quotient is infinite or NaN.
        if next >= 1.0 || next.is_nan() {
            return 1.0;
        }
        far = distance(next);
        if far <= least {
            return part;
        }
        part = next;
        if far - least < (1.0 - ADVANCE_FRACTION) * (start - least) {
            return part;
        }
    }
    part
}

/// Largest fraction, at most 1, of a linear motion for which an element keeps more than `kept_fraction` of its volume. The columns of
/// `edges` are the edges from one of its corners, those of `displacements` their changes.
pub fn inversion_free_fraction<const D: usize>(
    edges: &Matrix<D>,
    displacements: &Matrix<D>,
    kept_fraction: f64,
) -> f64 {
    let volume = |part: f64| determinant(&(edges + displacements * part));
    let start = volume(0.0);
    let short = |part: f64| volume(part) <= kept_fraction * start;
    // The volume is a polynomial of degree D, monotone between its extrema.
    let mut ends: Vec<f64> = extrema(volume, D).into_iter().filter(|t| *t > 0.0 && *t < 1.0).collect();
    ends.sort_unstable_by(f64::total_cmp);
    ends.push(1.0);
    let mut from = 0.0;
    for end in ends {
        if short(end) {
            let mut to = end;
            for _ in 0..BISECTION_ITERATIONS {
                let middle = 0.5 * (from + to);
                if short(middle) { to = middle } else { from = middle }
            }
            return from;
        }
        from = end;
    }
    1.0
}

pub(crate) fn determinant<const D: usize>(m: &Matrix<D>) -> f64 {
    if D == 2 {
        return m[(0, 0)] * m[(1, 1)] - m[(0, 1)] * m[(1, 0)];
    }
    (0..D)
        .map(|k| {
            let (a, b) = ((k + 1) % D, (k + 2) % D);
            m[(0, k)] * (m[(1, a)] * m[(2, b)] - m[(1, b)] * m[(2, a)])
        })
        .sum()
}

/// Extrema of a polynomial of degree 2 or 3, given by its values.
fn extrema(p: impl Fn(f64) -> f64, degree: usize) -> Vec<f64> {
    let (zero, plus, minus) = (p(0.0), p(1.0), p(-1.0));
    let second = 0.5 * (plus + minus) - zero;
    if degree == 2 {
        return vec![-0.25 * (plus - minus) / second];
    }
    // p(2) = zero + 2 first + 4 second + 8 third, and first + third = (plus − minus)/2.
    let odd = 0.5 * (plus - minus);
    let third = (p(2.0) - zero - 4.0 * second - 2.0 * odd) / 6.0;
    let first = odd - third;
    // 3 third t² + 2 second t + first = 0, solved without cancellation.
    let root = (second * second - 3.0 * third * first).max(0.0).sqrt();
    let q = -(second + root.copysign(second));
    vec![q / (3.0 * third), first / q]
}
