//! How far points may go so that nothing meets and no element turns inside out.

use crate::distance::{ClosestPair, StencilKind};
use meniscus_numerics::{Matrix, Vector};

/// Part of the way to the bound that an iteration goes (Li et al. 2021, algorithm 1). All of it would be safe, but for rounding; the
/// iterations end where less than the rest, a tenth, of what may be given up is left.
const ADVANCE_FRACTION: f64 = 0.9;
/// Most looks at one pair. Features that pass each other closely, fast, take many.
const MAX_CCD_ITERATIONS: usize = 1000;
/// Halvings of the time in which an element is found to turn inside out.
const BISECTION_ITERATIONS: usize = 60;

/// How near two features may come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clearance {
    /// Distance, m, that counts as none.
    pub thickness: f64,
    /// Part of the distance beyond it that must remain.
    pub kept_fraction: f64,
}

/// The largest part of a way, up to all of it, on which two features keep a clearance: points go from `x` along `displacements`. It is never too
/// large: no point comes nearer by more than the ways relative to each other are long (additive continuous collision detection:
/// M. Li, D. M. Kaufman, C. Jiang, "Codimensional incremental potential contact", ACM Trans. Graph. 40(4), 2021, §5).
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
    // Ends after so many looks, where it says less than could be.
    for _ in 0..MAX_CCD_ITERATIONS {
        let next = part + ADVANCE_FRACTION * (far - least) / speed;
        // Without a way there is nothing to find.
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

/// The largest part of a way, up to all of it, on which an element keeps more than `kept_fraction` of its volume. `edges` are those from one
/// of its corners, as columns, `displacements` how they change.
pub fn inversion_free_fraction<const D: usize>(
    edges: &Matrix<D>,
    displacements: &Matrix<D>,
    kept_fraction: f64,
) -> f64 {
    let volume = |part: f64| determinant(&(edges + displacements * part));
    let start = volume(0.0);
    let short = |part: f64| volume(part) <= kept_fraction * start;
    // A polynomial of degree D: between its extremes it is monotone.
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

/// Where a polynomial of degree 2 or 3 has extremes.
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
    // 3 third t² + 2 second t + first = 0, without differences of what is nearly the same.
    let root = (second * second - 3.0 * third * first).max(0.0).sqrt();
    let q = -(second + root.copysign(second));
    vec![q / (3.0 * third), first / q]
}
