//! Unions of shapes with fillets, and a cow made of them.

use super::Shape;
use crate::{Matrix, Vector};

/// A union of shapes with fillets where they meet.
///
/// Two distances `a` and `b` are joined by the quadratic smooth minimum `min(a, b) - h² / (4 k)`, `h = max(k - |a - b|, 0)` (I. Quilez,
/// "Smooth minimum", 2013), one part after another. The result is a distance where one part is nearer than the others by `k`. Elsewhere
/// it is less than the distance, but continuous with continuous slope wherever the parts' distances are.
#[derive(Clone, Debug)]
pub struct SmoothUnion<const D: usize> {
    /// The parts.
    pub parts: Vec<Shape<D>>,
    /// The width `k` of the fillets, m; 0 for a plain union.
    pub fillet_width: f64,
}

impl<const D: usize> SmoothUnion<D> {
    /// Approximate signed distance, m, negative inside; infinite without parts.
    pub fn signed_distance(&self, x: &Vector<D>) -> f64 {
        let join = |a: f64, b: f64| {
            let h = self.fillet_width - (a - b).abs();
            a.min(b) - if h > 0.0 { h * h / (4.0 * self.fillet_width) } else { 0.0 }
        };
        self.parts.iter().map(|s| s.signed_distance(x)).fold(f64::INFINITY, join)
    }

    /// Lower and upper corner of a box that contains it, m. It is not tight: fillets are assumed to stick out by half their width.
    pub fn bounds(&self) -> (Vector<D>, Vector<D>) {
        let (lower, upper) = self.parts_bounds();
        (lower.add_scalar(-0.5 * self.fillet_width), upper.add_scalar(0.5 * self.fillet_width))
    }

    /// Lower and upper corner of the box around its parts without their fillets, m.
    pub fn parts_bounds(&self) -> (Vector<D>, Vector<D>) {
        let start = (Vector::<D>::repeat(f64::INFINITY), Vector::<D>::repeat(f64::NEG_INFINITY));
        self.parts.iter().map(Shape::bounds).fold(start, |s, b| (s.0.inf(&b.0), s.1.sup(&b.1)))
    }

    /// A cow, about `length` (m) from rump to muzzle. The point `at` (m) is below its chest, at the height of its feet.
    /// The columns of `rotation` are its axes: the first points forward, the last up. In 2D it is seen from the side.
    /// Horns, ears and tail are a twentieth of the length thick: a mesh needs edges of a thirtieth or less.
    pub fn cow(length: f64, at: &Vector<D>, rotation: &Matrix<D>) -> Self {
        let mut parts = Vec::new();
        // Positions are forward, sideways, up, in lengths.
        let along = |p: [f64; 3]| Vector::<D>::from_fn(|a, _| length * if a + 1 == D { p[2] } else { p[a] });
        let place = |p: [f64; 3]| at + rotation * along(p);
        let capsule = |a: [f64; 3], b: [f64; 3], radius: f64| Shape::Capsule {
            a: place(a),
            b: place(b),
            radius: length * radius,
        };
        let ellipsoid = |center: [f64; 3], radii: [f64; 3]| Shape::Ellipsoid {
            center: place(center),
            radii: along(radii),
            rotation: *rotation,
        };
        parts.push(ellipsoid([-0.06, 0.0, 0.52], [0.34, 0.165, 0.185]));
        parts.push(ellipsoid([0.13, 0.0, 0.52], [0.18, 0.15, 0.205]));
        parts.push(ellipsoid([-0.26, 0.0, 0.56], [0.14, 0.145, 0.155]));
        parts.push(capsule([0.22, 0.0, 0.57], [0.38, 0.0, 0.68], 0.095));
        parts.push(capsule([0.39, 0.0, 0.69], [0.51, 0.0, 0.58], 0.066));
        parts.push(capsule([0.51, 0.0, 0.58], [0.53, 0.0, 0.56], 0.064));
        parts.push(capsule([-0.37, 0.0, 0.61], [-0.43, 0.0, 0.50], 0.025));
        parts.push(capsule([-0.43, 0.0, 0.50], [-0.44, 0.0, 0.30], 0.025));
        parts.push(ellipsoid([-0.445, 0.0, 0.26], [0.035, 0.035, 0.06]));
        parts.push(ellipsoid([-0.17, 0.0, 0.35], [0.07, 0.06, 0.05]));
        let sides: &[f64] = if D == 2 { &[1.0] } else { &[1.0, -1.0] };
        for &side in sides {
            // In 2D horn and ear are spread in the plane, where they are visible.
            let flat = if D == 2 { 1.0 } else { 0.0 };
            parts.push(capsule([0.18, 0.09 * side, 0.45], [0.19, 0.09 * side, 0.045], 0.045));
            parts.push(capsule([-0.28, 0.09 * side, 0.48], [-0.30, 0.09 * side, 0.24], 0.058));
            parts.push(capsule([-0.30, 0.09 * side, 0.24], [-0.28, 0.09 * side, 0.045], 0.045));
            parts.push(capsule([0.39, 0.04 * side, 0.74], [0.42 + 0.02 * flat, 0.11 * side, 0.83], 0.024));
            parts.push(capsule([0.35, 0.05 * side, 0.71], [0.33 - 0.06 * flat, 0.15 * side, 0.70], 0.026));
        }
        Self { parts, fillet_width: 0.06 * length }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::volume::stuffing::{StuffingError, stuff};

    fn joined<const D: usize>() {
        let ball = |at: f64| Shape::Ball { center: Vector::<D>::repeat(at), radius: 0.2 };
        let pair = SmoothUnion { parts: vec![ball(0.0), ball(0.25)], fillet_width: 0.1 };
        let sharp = Shape::Union(pair.parts.clone());
        let (lower, upper) = pair.bounds();
        for k in 0..2000 {
            let x = Vector::<D>::from_fn(|a, _| ((k * [7, 11, 13][a]) % 101) as f64 / 100.0 - 0.4);
            let (smooth, plain) = (pair.signed_distance(&x), sharp.signed_distance(&x));
            assert!(smooth <= plain && smooth >= plain - 0.025);
            assert!(smooth > 0.0 || (0..D).all(|a| x[a] > lower[a] && x[a] < upper[a]));
        }
        let far = Vector::repeat(-1.0);
        assert_eq!(pair.signed_distance(&far), sharp.signed_distance(&far));
        let none = SmoothUnion::<D> { parts: Vec::new(), fillet_width: 0.1 };
        assert_eq!(none.signed_distance(&far), f64::INFINITY);
    }

    #[test]
    fn parts_melt_into_each_other() {
        joined::<2>();
        joined::<3>();
    }

    fn animal<const D: usize>(edge: f64) {
        let cow = SmoothUnion::<D>::cow(1.0, &Vector::zeros(), &Matrix::identity());
        let (lower, upper) = cow.bounds();
        let mesh = stuff(&|x| cow.signed_distance(x), &lower, &upper, edge).unwrap();
        let quality = mesh.quality();
        println!("{D}D cow, edges of {edge}: {quality}");
        assert_eq!(mesh.check(), Ok(()));
        assert!(quality.smallest_angle.0.to_degrees() > if D == 2 { 16.0 } else { 10.7 });
        let (low, high) = mesh.surface().0.bounds();
        assert!(
            low[D - 1].abs() < 0.01 && high[D - 1] > 0.8 && (high[0] - low[0] - 1.07).abs() < 0.05,
            "{low} {high}"
        );
    }

    /// A moved and rotated cow has the same distances.
    fn turned<const D: usize>() {
        let (s, c) = 0.7f64.sin_cos();
        let mut rotation = Matrix::<D>::identity();
        (rotation[(0, 0)], rotation[(0, D - 1)], rotation[(D - 1, 0)], rotation[(D - 1, D - 1)]) =
            (c, -s, s, c);
        let at = Vector::from_fn(|a, _| 0.3 + a as f64);
        let cow = SmoothUnion::<D>::cow(0.02, &Vector::zeros(), &Matrix::identity());
        let other = SmoothUnion::<D>::cow(0.02, &at, &rotation);
        for k in 0..500 {
            let x = Vector::<D>::from_fn(|a, _| 0.02 * (((k * [7, 11, 13][a]) % 101) as f64 / 50.0 - 1.0));
            let there = other.signed_distance(&(at + rotation * x));
            assert!((cow.signed_distance(&x) - there).abs() < 1e-14, "{D}D at {x}");
        }
    }

    #[test]
    fn a_cow_turns() {
        turned::<2>();
        turned::<3>();
    }

    #[test]
    fn a_cow_is_filled() {
        animal::<2>(1.0 / 30.0);
        animal::<2>(1.0 / 60.0);
        animal::<3>(1.0 / 30.0);
        animal::<3>(1.0 / 45.0);
        // Too coarse for horns and tail: meshing fails, or parts are left over.
        for edge in [0.05, 0.08, 0.15] {
            let cow = SmoothUnion::<3>::cow(1.0, &Vector::zeros(), &Matrix::identity());
            let (lower, upper) = cow.bounds();
            match stuff(&|x| cow.signed_distance(x), &lower, &upper, edge) {
                Ok(mesh) => println!("edges of {edge}: {}", mesh.quality()),
                Err(error) => assert!(matches!(error, StuffingError::Defect { .. }), "{error}"),
            }
        }
    }
}
