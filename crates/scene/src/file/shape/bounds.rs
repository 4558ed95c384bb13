//! Geometry of shapes: bounds, point containment, typical radius.

use super::rotation::Rotation;
use super::spec::ShapeSpec;
use crate::file::text::short;
use meniscus_numerics::shape::SmoothUnion;
use std::f64::consts::PI;

/// The box around a shape; infinite where the shape is unbounded.
#[derive(Clone, Debug, PartialEq)]
pub struct Bounds {
    /// Lower corner, m.
    pub lower: Vec<f64>,
    /// Upper corner, m.
    pub upper: Vec<f64>,
}

impl Bounds {
    /// The box that extends by `reach`, m, from its centre, m, to either side along each axis.
    fn around(center: &[f64], reach: &[f64]) -> Self {
        Self {
            lower: center.iter().zip(reach).map(|(c, r)| c - r).collect(),
            upper: center.iter().zip(reach).map(|(c, r)| c + r).collect(),
        }
    }

    /// The box around this one and another one.
    fn joined(self, other: &Self) -> Self {
        Self {
            lower: self.lower.iter().zip(&other.lower).map(|(a, b)| a.min(*b)).collect(),
            upper: self.upper.iter().zip(&other.upper).map(|(a, b)| a.max(*b)).collect(),
        }
    }

    /// Whether the shape is bounded along every axis.
    pub(crate) fn is_finite(&self) -> bool {
        self.lower.iter().chain(&self.upper).all(|x| x.is_finite())
    }

    /// Describes bounds that leave the domain: their extent and that of the domain. Unbounded directions may leave it.
    pub(crate) fn describe_outside(&self, size: &[f64], slack: f64) -> Option<(String, String)> {
        let Self { lower, upper } = self;
        let leaves = |i: &usize| {
            let low = lower[*i].is_finite() && lower[*i] < -slack;
            let high = upper[*i].is_finite() && upper[*i] > size[*i] + slack;
            low || high || upper[*i] <= 0.0 || lower[*i] >= size[*i]
        };
        let i = (0..size.len()).find(leaves)?;
        let (axis, [low, high, end]) = (["x", "y", "z"][i], [lower[i], upper[i], size[i]].map(short));
        let reach = format!("reaches from {axis} = {low} m to {high} m");
        Some((reach, format!("the domain reaches from {axis} = 0 m to {end} m")))
    }
}

impl ShapeSpec {
    /// A bounding box of the shape in `dim` dimensions; `None` for a mesh, whose file is not read here.
    pub fn bounds(&self, dim: usize) -> Option<Bounds> {
        Some(match self {
            Self::Ball { center, radius } => Bounds::around(center, &vec![*radius; dim]),
            Self::PerturbedBall { center, radius, amplitude, .. } => {
                Bounds::around(center, &vec![radius * (1.0 + amplitude.abs()); dim])
            }
            Self::Box { center, half_size, rotation } => {
                Bounds::around(center, &box_reach(half_size, rotation))
            }
            Self::Ellipsoid { center, radii, rotation } => {
                Bounds::around(center, &ellipsoid_reach(radii, rotation))
            }
            Self::Cylinder { center, axis, radius, height } => {
                let along = |a: &f64| 0.5 * height * a.abs() + radius * (1.0 - a * a).max(0.0).sqrt();
                Bounds::around(center, &axis.iter().map(along).collect::<Vec<f64>>())
            }
            Self::Capsule { a, b, radius } => {
                let reach = vec![*radius; dim];
                Bounds::around(a, &reach).joined(&Bounds::around(b, &reach))
            }
            Self::HalfSpace { point, normal } => half_space_bounds(point, normal),
            Self::Wave { level, amplitude, .. } => {
                let mut upper = vec![f64::INFINITY; dim];
                upper[dim - 1] = level + amplitude;
                Bounds { lower: vec![f64::NEG_INFINITY; dim], upper }
            }
            Self::Extrusion { outline, thickness, center, rotation } => {
                let (lower, upper) = super::geometry::outline(outline).ok()?.surface().bounds();
                let (middle, half) = ((lower + upper) * 0.5, (upper - lower) * 0.5);
                let half = [half[0], half[1], 0.5 * thickness];
                rotated_box_bounds(center, &[middle[0], middle[1], 0.0], &half, rotation)
            }
            Self::Cow { at, length, rotation } => match dim {
                2 => cow_bounds::<2>(at, *length, rotation),
                _ => cow_bounds::<3>(at, *length, rotation),
            },
            Self::Union(list) | Self::SmoothUnion { parts: list, .. } => {
                let mut parts = list.iter().map(|s| s.bounds(dim));
                let first = parts.next()??;
                parts.try_fold(first, |all, part| Some(all.joined(&part?)))?
            }
            Self::Difference { of, .. } => of.bounds(dim)?,
            Self::Mesh { .. } => return None,
        })
    }

    /// Whether a point is inside; `None` where this needs a numerical shape.
    pub fn contains(&self, p: &[f64]) -> Option<bool> {
        let distance2 = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| (x - y).powi(2)).sum::<f64>();
        Some(match self {
            Self::Ball { center, radius } => distance2(p, center) < radius * radius,
            Self::PerturbedBall { center, radius, mode, amplitude } => {
                let r = distance2(p, center).sqrt();
                r < radius * (1.0 + amplitude * mode_shape(p, center, *mode))
            }
            Self::Box { center, half_size, rotation } => {
                let q = to_local_frame(p, center, &rotation.matrix());
                q.iter().zip(half_size).all(|(x, h)| x.abs() < *h)
            }
            Self::Ellipsoid { center, radii, rotation } => {
                let q = to_local_frame(p, center, &rotation.matrix());
                q.iter().zip(radii).map(|(x, r)| (x / r).powi(2)).sum::<f64>() < 1.0
            }
            Self::HalfSpace { point, normal } => {
                p.iter().zip(point).zip(normal).map(|((x, c), n)| (x - c) * n).sum::<f64>() < 0.0
            }
            Self::Cylinder { center, axis, radius, height } => {
                let along: f64 = p.iter().zip(center).zip(axis).map(|((x, c), n)| (x - c) * n).sum();
                along.abs() < 0.5 * height && distance2(p, center) - along * along < radius * radius
            }
            Self::Capsule { a, b, radius } => {
                let length2 = distance2(a, b);
                let along: f64 = p.iter().zip(a).zip(b).map(|((x, a), b)| (x - a) * (b - a)).sum();
                let t = if length2 > 0.0 { (along / length2).clamp(0.0, 1.0) } else { 0.0 };
                let near: Vec<f64> = a.iter().zip(b).map(|(a, b)| a + t * (b - a)).collect();
                distance2(p, &near) < radius * radius
            }
            Self::Wave { level, amplitude, wavelength, phase } => {
                let up = p.last().copied().unwrap_or(0.0);
                up < level + amplitude * (2.0 * PI * p[0] / wavelength + phase).cos()
            }
            Self::Union(list) => {
                let mut any = false;
                for s in list {
                    any |= s.contains(p)?;
                }
                any
            }
            Self::Difference { of, minus } => of.contains(p)? && !minus.contains(p)?,
            Self::Extrusion { .. } | Self::SmoothUnion { .. } | Self::Cow { .. } | Self::Mesh { .. } => {
                return None;
            }
        })
    }

    /// The length that a grid has to resolve, m: a radius, or half the thickness. `None` for shapes without such a length.
    pub fn radius(&self) -> Option<f64> {
        let least = |v: &[f64]| v.iter().copied().fold(f64::INFINITY, f64::min);
        match self {
            Self::Ball { radius, .. } | Self::PerturbedBall { radius, .. } | Self::Capsule { radius, .. } => {
                Some(*radius)
            }
            Self::Cylinder { radius, height, .. } => Some(radius.min(0.5 * height)),
            Self::Box { half_size, .. } => Some(least(half_size)),
            Self::Ellipsoid { radii, .. } => Some(least(radii)),
            Self::Wave { wavelength, .. } => Some(wavelength / (2.0 * PI)),
            Self::Extrusion { thickness, .. } => Some(0.5 * thickness),
            Self::Union(list) | Self::SmoothUnion { parts: list, .. } => {
                list.iter().filter_map(Self::radius).reduce(f64::min)
            }
            // Half the thickness of its legs.
            Self::Cow { length, .. } => Some(0.045 * length),
            Self::Difference { of, .. } => of.radius(),
            Self::HalfSpace { .. } | Self::Mesh { .. } => None,
        }
    }
}

/// Half the extent, m, of a box of half sizes `half_size`, m, along each axis.
fn box_reach(half_size: &[f64], rotation: &Rotation) -> Vec<f64> {
    if rotation.angle == 0.0 {
        return half_size.to_vec();
    }
    let m = rotation.matrix();
    let along = |i: usize| (0..half_size.len()).map(|j| m[i][j].abs() * half_size[j]).sum();
    (0..half_size.len()).map(along).collect()
}

/// Half the extent, m, of an ellipsoid of half axes `radii`, m, along each axis.
fn ellipsoid_reach(radii: &[f64], rotation: &Rotation) -> Vec<f64> {
    if rotation.angle == 0.0 {
        return radii.to_vec();
    }
    let m = rotation.matrix();
    let along = |i: usize| (0..radii.len()).map(|j| (m[i][j] * radii[j]).powi(2)).sum::<f64>().sqrt();
    (0..radii.len()).map(along).collect()
}

/// Bounds of a box of half sizes `half` about `middle` (m, in its own frame) after rotation and translation to `center`, m.
fn rotated_box_bounds(center: &[f64], middle: &[f64; 3], half: &[f64; 3], rotation: &Rotation) -> Bounds {
    let m = rotation.matrix();
    let end = |i: usize, sign: f64| {
        let along = |j: usize| m[i][j] * middle[j] + sign * m[i][j].abs() * half[j];
        center[i] + (0..center.len()).map(along).sum::<f64>()
    };
    let side = |sign: f64| (0..center.len()).map(|i| end(i, sign)).collect();
    Bounds { lower: side(-1.0), upper: side(1.0) }
}

/// Bounds of the cow's parts, m.
fn cow_bounds<const D: usize>(at: &[f64], length: f64, rotation: &Rotation) -> Bounds {
    let cow =
        SmoothUnion::<D>::cow(length, &super::geometry::vector(at), &super::geometry::rotation(rotation));
    let (lower, upper) = cow.parts_bounds();
    Bounds { lower: lower.as_slice().to_vec(), upper: upper.as_slice().to_vec() }
}

/// Bounds of a half-space: finite along an axis only if its normal is parallel to that axis.
fn half_space_bounds(point: &[f64], normal: &[f64]) -> Bounds {
    let mut lower = vec![f64::NEG_INFINITY; point.len()];
    let mut upper = vec![f64::INFINITY; point.len()];
    for i in 0..point.len() {
        if normal[i] >= 1.0 - 1e-12 {
            upper[i] = point[i];
        } else if normal[i] <= -1.0 + 1e-12 {
            lower[i] = point[i];
        }
    }
    Bounds { lower, upper }
}

/// The point in the local frame of the shape.
fn to_local_frame(p: &[f64], center: &[f64], matrix: &[[f64; 3]; 3]) -> Vec<f64> {
    (0..p.len()).map(|j| (0..p.len()).map(|i| matrix[i][j] * (p[i] - center[i])).sum()).collect()
}

/// `P_n(cos θ)` from the last axis in 3D, `cos nθ` from x in 2D.
fn mode_shape(p: &[f64], center: &[f64], mode: u32) -> f64 {
    if p.len() == 2 {
        return (f64::from(mode) * (p[1] - center[1]).atan2(p[0] - center[0])).cos();
    }
    let r = p.iter().zip(center).map(|(x, c)| (x - c).powi(2)).sum::<f64>().sqrt();
    let x = if r > 0.0 { (p[2] - center[2]) / r } else { 1.0 };
    let (mut before, mut last) = (1.0, x);
    for n in 2..=mode {
        let n = f64::from(n);
        (before, last) = (last, ((2.0 * n - 1.0) * x * last - (n - 1.0) * before) / n);
    }
    last
}
