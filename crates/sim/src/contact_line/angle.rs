//! Contact angle from the free surface a few cells away from the solid.
//!
//! Next to the solid the interpolant of φ reaches into it, where φ is only an extension. The surface is therefore traced from the
//! line up the solid's normal `n`: at a point with the normal `ν = ∇φ` a step follows the part of `n` in the tangent plane, and
//! then returns to the zero set. The points `MIN_FIT_HEIGHT_CELLS` to `MAX_FIT_HEIGHT_CELLS` cells above the solid give the angle
//! `arccos ν·n` as a function of the arc length. It is extrapolated to the solid as a linear function (exact for a circle and for
//! a sphere on a plane) plus the effect of gravity on the curvature (Young–Laplace: `κ = κ0 − w·x`, with `w` as in
//! [`Foot::bond_vector`]; without it the angle of a puddle with a capillary length of six cells is 8 degrees too small).

use meniscus_numerics::Vector;
use meniscus_numerics::grid::Sampler;

/// Heights above the solid, in cells, between which surface points are fitted.
const MIN_FIT_HEIGHT_CELLS: f64 = 1.5;
const MAX_FIT_HEIGHT_CELLS: f64 = 4.5;
/// Fraction of the height of a flat drop above which its surface points are fitted.
const FLAT_DROP_HEIGHT_FRACTION: f64 = 0.4;
/// Arc length of a tracing step, in cells.
const TRACE_STEP_CELLS: f64 = 0.5;
/// Maximum number of tracing steps.
const MAX_TRACE_STEPS: usize = 40;
/// Number of Newton iterations to the foot of an arc.
const FOOT_ITERATIONS: usize = 6;
/// Maximum arc length of the fit, in cells.
const MAX_FIT_ARC_CELLS: f64 = 6.0;
/// Smallest sine of the angle at which the surface still leads up.
const MIN_RISE_SINE: f64 = 0.1;
/// Fewest points for a fit.
const MIN_FIT_POINTS: usize = 3;
/// Gradient norm of φ below which it is no distance: a ridge between two surfaces.
const MIN_GRADIENT_NORM: f64 = 0.7;

/// A point of the traced surface.
struct TracePoint<const D: usize> {
    at: Vector<D>,
    normal: Vector<D>,
    /// Arc length from the start of the trace, in cells.
    arc_cells: f64,
    /// Height above the solid, in cells.
    height_cells: f64,
    /// Angle between the surface's normal and the solid's, rad.
    angle: f64,
    /// Part of it that gravity has added since the start of the trace, rad.
    gravity_turn: f64,
}

/// A point of a contact line on a solid.
pub struct Foot<'a, const D: usize> {
    /// Position, m.
    pub at: Vector<D>,
    /// The solid's normal there.
    pub normal: Vector<D>,
    /// Cell size, m.
    pub dx: f64,
    /// Decrease of the curvature along each axis, 1/cells²: `Model::cell_bond_vector`.
    pub bond_vector: Vector<D>,
    /// Distance to the solid, m.
    pub height: &'a dyn Fn(&Vector<D>) -> f64,
}

/// The contact angle through the liquid, rad. With too few points to fit, it is the angle at the surface point closest to a point
/// above the line. `None` where there is no surface.
pub fn contact_angle<const D: usize>(phi: &Sampler<'_, D>, foot: &Foot<'_, D>) -> Option<f64> {
    let trace = trace_interface(phi, foot)?;
    // On a flat drop only the upper part is used.
    let top = trace.iter().map(|t| t.height_cells).fold(0.0, f64::max);
    let from = MIN_FIT_HEIGHT_CELLS.min(FLAT_DROP_HEIGHT_FRACTION * top);
    let first = trace.iter().position(|t| t.height_cells >= from).unwrap_or(0);
    let used: Vec<&TracePoint<D>> = trace
        .get(first..)?
        .iter()
        .take_while(|t| t.arc_cells - trace[first].arc_cells <= MAX_FIT_ARC_CELLS)
        .collect();
    if used.len() < MIN_FIT_POINTS {
        return Some(trace[0].angle);
    }
    let count = used.len() as f64;
    let mean = |f: &dyn Fn(&TracePoint<D>) -> f64| used.iter().map(|t| f(t)).sum::<f64>() / count;
    let (arc, angle) = (mean(&|t| t.arc_cells), mean(&|t| t.angle - t.gravity_turn));
    let spread = mean(&|t| (t.arc_cells - arc).powi(2));
    let curvature = mean(&|t| (t.arc_cells - arc) * (t.angle - t.gravity_turn - angle)) / spread;
    let first = angle + curvature * (used[0].arc_cells - arc) + used[0].gravity_turn;
    let curvature = curvature + foot.bond_vector.dot(&(used[0].at - trace[0].at)) / foot.dx;
    Some(extrapolated_angle(foot, used[0], first, curvature))
}

/// Traces the surface upwards from the line.
fn trace_interface<const D: usize>(phi: &Sampler<'_, D>, foot: &Foot<'_, D>) -> Option<Vec<TracePoint<D>>> {
    let (dx, n) = (foot.dx, foot.normal);
    let mut trace: Vec<TracePoint<D>> = Vec::new();
    let (mut target, mut arc_cells, mut gravity_turn) = (foot.at + n * (MIN_FIT_HEIGHT_CELLS * dx), 0.0, 0.0);
    for _ in 0..MAX_TRACE_STEPS {
        let (at, slope) = closest_on_interface(phi, &target, dx);
        let normal = slope.try_normalize(MIN_GRADIENT_NORM)?;
        let height_cells = (foot.height)(&at) / dx;
        let angle = normal.dot(&n).clamp(-1.0, 1.0).acos();
        if let Some(last) = trace.last() {
            let step = (at - last.at).norm() / dx;
            arc_cells += step;
            gravity_turn += step * foot.bond_vector.dot(&(0.5 * (at + last.at) - trace[0].at)) / dx;
            // Past the top, or the surface does not lead up.
            if height_cells <= last.height_cells {
                break;
            }
        }
        trace.push(TracePoint { at, normal, arc_cells, height_cells, angle, gravity_turn });
        if height_cells > MAX_FIT_HEIGHT_CELLS || angle.sin() < MIN_RISE_SINE {
            break;
        }
        target = at + (n - normal * normal.dot(&n)).normalize() * (TRACE_STEP_CELLS * dx);
    }
    Some(trace)
}

/// Closest point of the interface to `x`, and the gradient of φ there.
fn closest_on_interface<const D: usize>(
    phi: &Sampler<'_, D>,
    x: &Vector<D>,
    dx: f64,
) -> (Vector<D>, Vector<D>) {
    let mut at = *x;
    let mut slope = Vector::zeros();
    for _ in 0..3 {
        let (value, gradient) = phi.distance_with_gradient(&at);
        slope = gradient;
        at -= gradient * (value.clamp(-dx, dx) / gradient.norm_squared().max(0.25));
    }
    (at, slope)
}

/// The angle at which the arc with `angle` and `curvature` (rad per cell) at `point` reaches the solid.
fn extrapolated_angle<const D: usize>(
    foot: &Foot<'_, D>,
    point: &TracePoint<D>,
    angle: f64,
    curvature: f64,
) -> f64 {
    let n = foot.normal;
    let outward = (point.normal - n * point.normal.dot(&n)).try_normalize(0.0).unwrap_or(Vector::zeros());
    // Growth of the curvature with the arc length.
    let curvature_rate = foot.bond_vector.dot(&(n * angle.sin() - outward * angle.cos()));
    let mut arc = 0.0;
    for _ in 0..FOOT_ITERATIONS {
        let curvature = curvature + 0.5 * curvature_rate * arc;
        let (middle, half) = (angle + 0.5 * curvature * arc, 0.5 * curvature * arc);
        let chord = arc * if half.abs() > 1e-6 { half.sin() / half } else { 1.0 };
        let at = point.at + (n * middle.sin() - outward * middle.cos()) * (chord * foot.dx);
        let steep = (angle + curvature * arc).sin().max(0.2);
        arc = (arc - (foot.height)(&at) / foot.dx / steep).clamp(-2.0 * MAX_FIT_ARC_CELLS, 0.0);
    }
    (angle + (curvature + 0.5 * curvature_rate * arc) * arc).clamp(0.0, std::f64::consts::PI)
}
