//! Shapes for the initial state of a run, and exact volume fractions of cut cells.
//!
//! Each shape has a signed distance, negative inside. It is exact for ball, box, half space, cylinder, capsule, ellipsoid, perturbed ball
//! and mesh. Unions and differences take the minimum or maximum of their parts' distances, which is correct on the surface and a bound
//! away from it. A smooth union returns less than the distance at its fillets.

mod clip;
mod distance_field;
mod ellipsoid;
mod fraction;
mod mesh_shape;
mod perturbed;
mod smooth_union;
mod surface_samples;

pub use clip::{ClipSimplex, ClippedMeasures};
pub use fraction::plane_box_fraction;
pub use mesh_shape::MeshShape;
pub use smooth_union::SmoothUnion;
pub use surface_samples::SurfaceSample;

use crate::mesh::volume::Outline;
use crate::{Aabb, Matrix, Vector};
use std::f64::consts::PI;
use std::sync::Arc;

/// A region of space, filled with liquid or solid. Lengths in m.
#[derive(Clone, Debug)]
pub enum Shape<const D: usize> {
    /// A ball (2D: a disc).
    Ball {
        /// Its centre, m.
        center: Vector<D>,
        /// Its radius, m.
        radius: f64,
    },
    /// A box.
    Box {
        /// Its centre, m.
        center: Vector<D>,
        /// Half its extent along each of its own axes, m.
        half_size: Vector<D>,
        /// A rotation whose columns are the box's own axes.
        rotation: Matrix<D>,
    },
    /// The half space that the normal points away from.
    HalfSpace {
        /// A point of the plane, m.
        point: Vector<D>,
        /// The outward normal, of any length.
        normal: Vector<D>,
    },
    /// A cylinder (2D: a rectangle of width `2 radius`).
    Cylinder {
        /// The middle of its axis, m.
        center: Vector<D>,
        /// The direction of its axis, of any length.
        axis: Vector<D>,
        /// Its radius, m.
        radius: f64,
        /// Its length along the axis, m.
        height: f64,
    },
    /// All points within a radius of a segment.
    Capsule {
        /// One end of the segment, m.
        a: Vector<D>,
        /// The other end, m.
        b: Vector<D>,
        /// The radius, m.
        radius: f64,
    },
    /// An ellipsoid (2D: an ellipse).
    Ellipsoid {
        /// Its centre, m.
        center: Vector<D>,
        /// Half axes, m.
        radii: Vector<D>,
        /// A rotation whose columns are the ellipsoid's own axes.
        rotation: Matrix<D>,
    },
    /// A ball with one surface mode: `r = R (1 + ε cos nθ)` in 2D, θ from the first axis, and `r = R (1 + ε P_n(cos ϑ))`
    /// in 3D, ϑ from the last (vertical) axis.
    PerturbedBall {
        /// Its centre, m.
        center: Vector<D>,
        /// The radius R of the unperturbed ball, m.
        radius: f64,
        /// The mode n.
        mode: u32,
        /// The relative amplitude ε, between -1 and 1.
        amplitude: f64,
    },
    /// All points in any of the shapes.
    Union(Vec<Shape<D>>),
    /// A union with fillets.
    SmoothUnion(SmoothUnion<D>),
    /// All points of one shape that are not in another.
    Difference {
        /// The shape cut into.
        of: Box<Shape<D>>,
        /// The shape cut away.
        minus: Box<Shape<D>>,
    },
    /// A flat outline extruded along the last axis (2D: the outline).
    Extrusion {
        /// The outline, its origin at the shape's centre, m.
        outline: Arc<MeshShape<2>>,
        /// Position of the outline's origin, at mid-thickness, m.
        center: Vector<D>,
        /// The thickness, m; ignored in 2D.
        thickness: f64,
        /// A rotation whose columns are the axes of the outline's frame.
        rotation: Matrix<D>,
    },
    /// The interior of a closed surface mesh.
    Mesh(Arc<MeshShape<D>>),
}

impl<const D: usize> Shape<D> {
    /// Extrudes an outline by `thickness` (m) along the last axis (2D: its interior). The signed distance of the outline's polygon is
    /// exact. Its origin is placed at `center` (m), at mid-thickness; the columns of `rotation` are its axes.
    pub fn extrusion(outline: &Outline, center: &Vector<D>, thickness: f64, rotation: &Matrix<D>) -> Self {
        let outline = Arc::new(MeshShape::new(outline.surface()));
        Self::Extrusion { outline, center: *center, thickness, rotation: *rotation }
    }

    /// Distance to the shape's surface, negative inside, m.
    pub fn signed_distance(&self, x: &Vector<D>) -> f64 {
        match self {
            Self::Ball { center, radius } => (x - center).norm() - radius,
            Self::Box { center, half_size, rotation } => {
                box_distance(&(rotation.tr_mul(&(x - center)).abs() - half_size))
            }
            Self::HalfSpace { point, normal } => (x - point).dot(&unit(normal)),
            Self::Cylinder { center, axis, radius, height } => {
                let axis = unit(axis);
                let along = (x - center).dot(&axis);
                let across = (x - center - axis * along).norm();
                box_distance(&Vector::from([across - radius, along.abs() - 0.5 * height]))
            }
            Self::Capsule { a, b, radius } => {
                let (e, d) = (b - a, x - a);
                let t = (d.dot(&e) / e.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
                (d - e * t).norm() - radius
            }
            Self::Ellipsoid { center, radii, rotation } => {
                ellipsoid::signed_distance(&rotation.tr_mul(&(x - center)), radii)
            }
            Self::PerturbedBall { center, radius, mode, amplitude } => {
                let d = x - center;
                perturbed::PolarCurve::new::<D>(*radius, *mode, *amplitude).signed_distance(&d)
            }
            Self::Union(parts) => parts.iter().map(|s| s.signed_distance(x)).fold(f64::INFINITY, f64::min),
            Self::SmoothUnion(union) => union.signed_distance(x),
            Self::Difference { of, minus } => of.signed_distance(x).max(-minus.signed_distance(x)),
            Self::Extrusion { outline, center, thickness, rotation } => {
                let y = rotation.tr_mul(&(x - center));
                let flat = outline.signed_distance(&Vector::from([y[0], y[1]]));
                let across = if D == 3 { y[D - 1].abs() - 0.5 * thickness } else { f64::NEG_INFINITY };
                box_distance(&Vector::from([flat, across]))
            }
            Self::Mesh(mesh) => mesh.signed_distance(x),
        }
    }

    /// Whether a point is inside.
    pub fn contains(&self, x: &Vector<D>) -> bool {
        self.signed_distance(x) < 0.0
    }

    /// Lower and upper corner of an axis-aligned box that contains the shape, m. A half space is unbounded; an empty
    /// union has an inverted, infinite box. The box is tight except for a difference (the box of the shape cut into), a
    /// perturbed ball (the box of its largest radius) and a smooth union (with room for fillets).
    pub fn bounds(&self) -> (Vector<D>, Vector<D>) {
        let around = |center: &Vector<D>, reach: Vector<D>| (center - reach, center + reach);
        match self {
            Self::Ball { center, radius } => around(center, Vector::repeat(*radius)),
            Self::Box { center, half_size, rotation } => around(center, rotation.abs() * half_size),
            Self::HalfSpace { .. } => around(&Vector::zeros(), Vector::repeat(f64::INFINITY)),
            Self::Cylinder { center, axis, radius, height } => {
                let across = |c: f64| radius * (1.0 - c * c).max(0.0).sqrt();
                around(center, unit(axis).map(|c| 0.5 * height * c.abs() + across(c)))
            }
            Self::Capsule { a, b, radius } => (a.inf(b).add_scalar(-radius), a.sup(b).add_scalar(*radius)),
            Self::Ellipsoid { center, radii, rotation } => around(
                center,
                Vector::from_fn(|r, _| rotation.row(r).transpose().component_mul(radii).norm()),
            ),
            Self::PerturbedBall { center, radius, amplitude, .. } => {
                around(center, Vector::repeat(radius * (1.0 + amplitude.abs())))
            }
            Self::Union(parts) => {
                let start = (Vector::repeat(f64::INFINITY), Vector::repeat(f64::NEG_INFINITY));
                parts.iter().map(Self::bounds).fold(start, |s, b| (s.0.inf(&b.0), s.1.sup(&b.1)))
            }
            Self::SmoothUnion(union) => union.bounds(),
            Self::Difference { of, .. } => of.bounds(),
            Self::Extrusion { outline, center, thickness, rotation } => {
                let (lower, upper) = outline.surface().bounds();
                let pick = |v: Vector<2>, last| Vector::from_fn(|a, _| if a < 2 { v[a] } else { last });
                let middle = center + rotation * pick((lower + upper) * 0.5, 0.0);
                around(&middle, rotation.abs() * pick((upper - lower) * 0.5, 0.5 * thickness))
            }
            Self::Mesh(mesh) => mesh.surface().bounds(),
        }
    }

    /// Volume where it has a closed form, m³ (2D: m²). A union has one if the boxes of its parts do not
    /// overlap, a difference if the boxes of its two shapes do not.
    pub fn volume(&self) -> Option<f64> {
        let ball = if D == 2 { PI } else { 4.0 / 3.0 * PI };
        let power = |r: f64| r.powi(D as i32);
        match self {
            Self::Ball { radius, .. } => Some(ball * power(*radius)),
            Self::Box { half_size, .. } => Some(power(2.0) * half_size.product()),
            Self::HalfSpace { .. } | Self::SmoothUnion(_) => None,
            Self::Cylinder { radius, height, .. } => Some(height * cross_section::<D>(*radius)),
            Self::Capsule { a, b, radius } => {
                Some(ball * power(*radius) + cross_section::<D>(*radius) * (b - a).norm())
            }
            Self::Ellipsoid { radii, .. } => Some(ball * radii.product()),
            Self::PerturbedBall { radius, mode, amplitude, .. } => {
                Some(ball * power(*radius) * perturbed::relative_volume::<D>(*mode, *amplitude))
            }
            Self::Union(parts) => {
                let boxes: Vec<Aabb<D>> = parts.iter().map(|part| part.bounds().into()).collect();
                let apart = (0..boxes.len()).all(|i| (0..i).all(|j| disjoint(&boxes[i], &boxes[j])));
                if apart { parts.iter().map(Self::volume).sum() } else { None }
            }
            Self::Extrusion { outline, thickness, .. } => {
                Some(outline.surface().volume() * if D == 3 { *thickness } else { 1.0 })
            }
            Self::Mesh(mesh) => Some(mesh.surface().volume()),
            Self::Difference { of, minus } => {
                if disjoint(&of.bounds().into(), &minus.bounds().into()) {
                    of.volume()
                } else {
                    None
                }
            }
        }
    }
}

/// Measure of the cross-section of a cylinder: a disc in 3D, a width in 2D.
fn cross_section<const D: usize>(radius: f64) -> f64 {
    if D == 2 { 2.0 * radius } else { PI * radius * radius }
}

/// Whether two boxes share no inner point.
fn disjoint<const D: usize>(a: &Aabb<D>, b: &Aabb<D>) -> bool {
    (0..D).any(|k| a[1][k] <= b[0][k] || b[1][k] <= a[0][k])
}

/// The unit vector along `v`; the last axis if `v` is zero.
fn unit<const D: usize>(v: &Vector<D>) -> Vector<D> {
    v.try_normalize(0.0).unwrap_or_else(|| Vector::from_fn(|a, _| if a + 1 == D { 1.0 } else { 0.0 }))
}

/// Signed distance to a box from the excess of the point's coordinates over the half sizes.
fn box_distance<const N: usize>(excess: &Vector<N>) -> f64 {
    excess.map(|v| v.max(0.0)).norm() + excess.max().min(0.0)
}

#[cfg(test)]
mod tests;
