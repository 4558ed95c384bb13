//! Scales of a scene: volume and radius of its liquid, speeds, the longest step.

use crate::file::{Bounds, Scene, ShapeSpec};

/// Norm of a vector.
pub(crate) fn norm(v: &[f64]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Radius of a ball (2D: a disc) of the given volume, m.
pub(crate) fn ball_radius(volume: f64, dimension: usize) -> f64 {
    let pi = std::f64::consts::PI;
    if dimension == 2 { (volume / pi).sqrt() } else { (0.75 * volume / pi).cbrt() }
}

/// The largest difference of initial velocities between liquid bodies, m/s; for a single body its speed.
pub(crate) fn typical_speed(scene: &Scene) -> f64 {
    let v: Vec<&[f64]> = scene.liquid.bodies.iter().map(|b| b.velocity.as_slice()).collect();
    if let [one] = v.as_slice() {
        return norm(one);
    }
    let mut most = 0.0_f64;
    for (i, a) in v.iter().enumerate() {
        for b in &v[..i] {
            most = most.max(a.iter().zip(*b).map(|(x, y)| (x - y).powi(2)).sum::<f64>().sqrt());
        }
    }
    most
}

/// The longest step that the limits of a scene allow, s.
pub(crate) fn longest_step(scene: &Scene) -> f64 {
    let (n, gamma) = (&scene.numerics, scene.tension.liquid_air);
    let capillary = n.capillary_step * 0.36 * (scene.liquid.density * scene.domain.dx.powi(3) / gamma).sqrt();
    n.fixed_step.unwrap_or_else(|| capillary.min(n.max_step)).min(scene.output.frame_interval())
}

/// The smallest radius of a liquid body, m; none for half-spaces.
pub(crate) fn smallest_radius(scene: &Scene) -> Option<f64> {
    scene.liquid.bodies.iter().filter_map(|body| radius(scene, &body.shape)).reduce(f64::min)
}

/// Radius of a liquid body, m; for an unrotated box half its smallest extent inside the domain.
pub(crate) fn radius(scene: &Scene, shape: &ShapeSpec) -> Option<f64> {
    match shape {
        ShapeSpec::Box { rotation, .. } if rotation.angle == 0.0 => half_min_extent_inside(scene, shape),
        shape => shape.radius(),
    }
}

/// Half the smallest extent of the part inside the domain, m.
fn half_min_extent_inside(scene: &Scene, shape: &ShapeSpec) -> Option<f64> {
    let Bounds { lower, upper } = shape.bounds(scene.domain.dimension)?;
    let extent = |((l, u), s): ((&f64, &f64), &f64)| 0.5 * (u.min(*s) - l.max(0.0));
    lower.iter().zip(&upper).zip(&scene.domain.size).map(extent).reduce(f64::min)
}

/// Volume of the liquid inside the domain, m³ (2D: m²), by sampling; none if a shape cannot be sampled.
pub fn liquid_volume(scene: &Scene) -> Option<f64> {
    let d = &scene.domain;
    let dim = d.dimension;
    let mut lower = d.size.clone();
    let mut upper = vec![0.0; dim];
    for body in &scene.liquid.bodies {
        let bounds = body.shape.bounds(dim)?;
        for i in 0..dim {
            lower[i] = lower[i].min(bounds.lower[i].max(0.0));
            upper[i] = f64::max(upper[i], bounds.upper[i].min(d.size[i]));
        }
    }
    let count: usize = if dim == 2 { 512 } else { 96 };
    let total = count.pow(dim as u32);
    let shapes: Vec<&ShapeSpec> = scene.liquid.bodies.iter().map(|b| &b.shape).collect();
    let mut point = vec![0.0; dim];
    let mut inside = 0_usize;
    for k in 0..total {
        let mut rest = k;
        for i in 0..dim {
            let t = ((rest % count) as f64 + 0.5) / count as f64;
            point[i] = lower[i] + t * (upper[i] - lower[i]);
            rest /= count;
        }
        let mut any = false;
        for s in &shapes {
            any |= s.contains(&point)?;
        }
        inside += usize::from(any);
    }
    let sampled: f64 = lower.iter().zip(&upper).map(|(l, u)| (u - l).max(0.0)).product();
    Some(sampled * inside as f64 / total as f64)
}
