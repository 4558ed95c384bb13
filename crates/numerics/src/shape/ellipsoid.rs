//! The closest point of an ellipsoid.
//!
//! The closest point $x$ to $y$ solves $x_a = r_a^2 y_a / (t + r_a^2)$ with the largest root $t$ of $F(t) = \sum_a (r_a y_a / (t +
//! r_a^2))^2 - 1$ (D. Eberly, "Distance from a point to an ellipse, an ellipsoid, or a hyperellipsoid", 2013). $F$ is convex and
//! decreasing on $t > -r_{min}^2$, so that Newton's iteration from the left converges to the root without a bracket.

use crate::Vector;

/// Maximum number of Newton iterations; seven are usual.
const MAX_NEWTON_ITERATIONS: usize = 60;

/// Distance from `y` (in the ellipsoid's own frame, m) to the ellipsoid of half axes `radii` (m), negative
/// inside.
pub(super) fn signed_distance<const D: usize>(y: &Vector<D>, radii: &Vector<D>) -> f64 {
    let inside = y.component_div(radii).norm_squared() < 1.0;
    let distance = (closest_point(y, radii) - y).norm();
    if inside { -distance } else { distance }
}

/// The closest point of the ellipsoid, m.
pub(super) fn closest_point<const D: usize>(y: &Vector<D>, radii: &Vector<D>) -> Vector<D> {
    // In units of the shortest half axis: s = t / r_min^2, q_a = (r_a / r_min)^2 >= 1.
    let shortest = radii.min();
    let r = radii / shortest;
    let q = r.component_mul(&r);
    let p = y.abs() / shortest;
    if let Some(x) = inside_the_focal_set(&p, &r, &q) {
        return x.zip_map(y, |x, y| shortest * x.copysign(y));
    }
    // u = s + 1 is measured from the pole of the shortest axis, which avoids cancellation near the focal set.
    let rest = q.add_scalar(-1.0);
    let mut u = (0..D).map(|a| r[a] * p[a] - rest[a]).fold(0.0, f64::max);
    for _ in 0..MAX_NEWTON_ITERATIONS {
        let (mut f, mut slope) = (-1.0, 0.0);
        for a in (0..D).filter(|&a| p[a] > 0.0) {
            let w = r[a] * p[a] / (u + rest[a]);
            f += w * w;
            slope += 2.0 * w * w / (u + rest[a]);
        }
        let step = f / slope;
        u += step;
        if step.is_nan() || step <= 1e-16 * u {
            break;
        }
    }
    Vector::from_fn(
        |a, _| {
            if p[a] == 0.0 { 0.0 } else { shortest * (q[a] * p[a] / (u + rest[a])).copysign(y[a]) }
        },
    )
}

/// The closest point of a point on the focal set: the point has no component along any shortest axis, but its closest
/// point has. `None` for other points. Lengths are in units of the shortest half axis, components not negative.
fn inside_the_focal_set<const D: usize>(p: &Vector<D>, r: &Vector<D>, q: &Vector<D>) -> Option<Vector<D>> {
    let first = (0..D).find(|&a| q[a] == 1.0)?;
    if (0..D).any(|a| q[a] == 1.0 && p[a] > 0.0) {
        return None;
    }
    let mut x = Vector::<D>::from_fn(|a, _| if q[a] == 1.0 { 0.0 } else { q[a] * p[a] / (q[a] - 1.0) });
    let left: f64 = 1.0 - x.component_div(r).norm_squared();
    x[first] = left.max(0.0).sqrt();
    (left >= 0.0).then_some(x)
}
