//! The angle at which the liquid's surface meets a solid, from the surface a few cells away.
//!
//! Next to the solid the interpolant of φ reaches into it, where φ is only a continuation. So the surface is followed from
//! the line up the solid's normal `n`: at `y` with the normal `ν = ∇φ` it goes on along the part of `n` in its tangent
//! plane, and each step ends on the zero set again. What is [`MIN_FIT_HEIGHT_CELLS`] to [`MAX_FIT_HEIGHT_CELLS`] cells above the solid tells the angle
//! `arccos ν·n` as a function of the arc length, which is continued to where the arc reaches the solid: a linear one (exact
//! for a circle and for a sphere on a plane), and what the liquid's weight adds to it, as it makes the curvature change with
//! the height (Young and Laplace: `κ = κ0 − w·x`, with `w` as in [`Foot::bond_vector`]; without it the angle of a puddle with a
//! capillary length of six cells is eight degrees too small).

use meniscus_numerics::Vector;
use meniscus_numerics::grid::Sampler;

/// Heights, in cells, between which the surface counts.
const MIN_FIT_HEIGHT_CELLS: f64 = 1.5;
const MAX_FIT_HEIGHT_CELLS: f64 = 4.5;
/// Part of the height of a flat drop from which on its surface counts.
const FLAT_DROP_HEIGHT_FRACTION: f64 = 0.4;
/// Arc length of a step, in cells.
const TRACE_STEP_CELLS: f64 = 0.5;
/// Most steps.
const MAX_TRACE_STEPS: usize = 40;
/// Steps of Newton's iteration to the foot of an arc.
const FOOT_ITERATIONS: usize = 6;
/// Arc length that is used, in cells.
const MAX_FIT_ARC_CELLS: f64 = 6.0;
/// Least sine of the angle at which the surface still leads up.
const MIN_RISE_SINE: f64 = 0.1;
/// Fewest points for a fit.
const MIN_FIT_POINTS: usize = 3;
/// Slope of φ below which it is no distance: a ridge between two surfaces.
const MIN_GRADIENT_NORM: f64 = 0.7;

/// A point of the surface.
struct TracePoint<const D: usize> {
    at: Vector<D>,
    normal: Vector<D>,
    /// Arc length from where the way began, in cells.
    arc_cells: f64,
    /// Height above the solid, in cells.
    height_cells: f64,
    /// Angle between the surface's normal and the solid's.
    angle: f64,
    /// Part of it that the weight has made since the way began.
    gravity_turn: f64,
}

/// A place on a solid where a line is.
pub struct Foot<'a, const D: usize> {
    /// The place, m.
    pub at: Vector<D>,
    /// The solid's normal there.
    pub normal: Vector<D>,
    /// Cell size, m.
    pub dx: f64,
    /// How fast the curvature falls along each axis, 1/cells²: [`crate::Model::bond_vector`].
    pub bond_vector: Vector<D>,
    /// Distance to the solid, m.
    pub height: &'a dyn Fn(&Vector<D>) -> f64,
}

/// The contact angle through the liquid, rad; without enough surface to fit it is that of the surface nearest to a point
/// above the line. `None` where there is no surface.
pub fn contact_angle<const D: usize>(phi: &Sampler<'_, D>, foot: &Foot<'_, D>) -> Option<f64> {
    let trace = trace_interface(phi, foot)?;
    // Of a flat drop the upper part must do.
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

/// The way up along the surface.
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
            // Past the top, or no way up.
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

/// The point of the surface nearest to `x`, and the slope there.
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

/// The angle where the arc that has the angle `angle` at `point` and turns there by `curvature` (rad per cell) reaches the solid.
fn extrapolated_angle<const D: usize>(
    foot: &Foot<'_, D>,
    point: &TracePoint<D>,
    angle: f64,
    curvature: f64,
) -> f64 {
    let n = foot.normal;
    let outward = (point.normal - n * point.normal.dot(&n)).try_normalize(0.0).unwrap_or(Vector::zeros());
    // How fast the bend grows with the arc.
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
