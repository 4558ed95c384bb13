//! Least-squares fit of ellipses and spheroids with a vertical axis.

use super::{Sphere, least_squares};
use crate::Vector;

/// Number of reweightings by the length of the gradient, which turn algebraic into geometric distances.
const REWEIGHTING_ITERATIONS: usize = 3;

/// An ellipse with horizontal and vertical axes (2D), a spheroid about a vertical axis (3D); the last axis is up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipsoid<const D: usize> {
    /// Centre, m.
    pub center: Vector<D>,
    /// Horizontal semi-axis, m.
    pub horizontal_semi_axis: f64,
    /// Vertical semi-axis, m.
    pub vertical_semi_axis: f64,
}

impl<const D: usize> Ellipsoid<D> {
    /// The ellipsoid equal to a circle or sphere.
    pub fn from_sphere(sphere: &Sphere<D>) -> Self {
        Self { center: sphere.center, horizontal_semi_axis: sphere.radius, vertical_semi_axis: sphere.radius }
    }

    /// Fits weighted points; `None` if they determine no ellipsoid.
    pub fn fit(points: &[(Vector<D>, f64)]) -> Option<Self> {
        let mut best = Self::algebraic_fit(points, |_| 1.0)?;
        for _ in 0..REWEIGHTING_ITERATIONS {
            let last = best;
            best = Self::algebraic_fit(points, |x| last.gradient_norm(x).powi(-2))?;
        }
        Some(best)
    }

    /// Least squares of `|x_horizontal|² = −k x_up² + 2 c·x + e`; the points' weights are multiplied by `by`.
    fn algebraic_fit(points: &[(Vector<D>, f64)], by: impl Fn(&Vector<D>) -> f64) -> Option<Self> {
        let origin = points.first()?.0;
        let scale = points.iter().map(|p| (p.0 - origin).norm()).fold(0.0, f64::max);
        if scale <= 0.0 {
            return None;
        }
        let up = D - 1;
        let row = |(at, weight): &(Vector<D>, f64)| {
            let x = (at - origin) / scale;
            let mut basis = [0.0, 0.0, 0.0, 1.0, -x[up] * x[up]];
            (0..D).for_each(|a| basis[a] = 2.0 * x[a]);
            (weight * by(at), basis, x.norm_squared() - x[up] * x[up])
        };
        // In 2D the third entry of the basis is unused: a weight pins its coefficient to zero.
        let pin = (if D == 2 { 1.0 } else { 0.0 }, [0.0, 0.0, 1.0, 0.0, 0.0], 0.0);
        let fit = least_squares(points.iter().map(row).chain([pin]))?;
        let k = fit[4];
        if k.is_nan() || k <= 0.0 {
            return None;
        }
        let mut center = Vector::<D>::from_fn(|a, _| fit[a]);
        let square = fit[3] + center.norm_squared() - center[up].powi(2) + center[up].powi(2) / k;
        center[up] /= k;
        let level = square.sqrt();
        let it = Self {
            center: origin + center * scale,
            horizontal_semi_axis: level * scale,
            vertical_semi_axis: level * scale / k.sqrt(),
        };
        (it.horizontal_semi_axis > 0.0
            && it.vertical_semi_axis > 0.0
            && it.horizontal_semi_axis.is_finite()
            && it.vertical_semi_axis.is_finite())
        .then_some(it)
    }

    /// Semi-axis along a coordinate, m.
    fn semi_axis(&self, a: usize) -> f64 {
        if a + 1 == D { self.vertical_semi_axis } else { self.horizontal_semi_axis }
    }

    /// Length of the gradient of `|x/axes|²`, up to a constant factor.
    fn gradient_norm(&self, x: &Vector<D>) -> f64 {
        let scale = self.horizontal_semi_axis * self.horizontal_semi_axis;
        Vector::<D>::from_fn(|a, _| (x[a] - self.center[a]) * scale / self.semi_axis(a).powi(2))
            .norm()
            .max(1e-12 * self.horizontal_semi_axis)
    }

    /// Signed distance, negative inside, m; exact for spheres, to first order near the surface otherwise.
    pub fn distance(&self, x: &Vector<D>) -> f64 {
        let u = Vector::<D>::from_fn(|a, _| (x[a] - self.center[a]) / self.semi_axis(a));
        let slope = Vector::<D>::from_fn(|a, _| u[a] / self.semi_axis(a)).norm();
        if slope > 0.0 {
            u.norm() * (u.norm() - 1.0) / slope
        } else {
            -self.horizontal_semi_axis.min(self.vertical_semi_axis)
        }
    }

    /// Outward unit normal of the concentric, similar ellipsoid that passes through a point.
    pub fn normal(&self, x: &Vector<D>) -> Vector<D> {
        let n = Vector::<D>::from_fn(|a, _| (x[a] - self.center[a]) / self.semi_axis(a).powi(2));
        n.try_normalize(0.0).unwrap_or_else(Vector::zeros)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found<const D: usize>(horizontal_semi_axis: f64, vertical_semi_axis: f64) {
        let center = Vector::<D>::from_fn(|a, _| 4.0 - 0.7 * a as f64);
        let it = Ellipsoid { center, horizontal_semi_axis, vertical_semi_axis };
        let points: Vec<(Vector<D>, f64)> = (0..200)
            .map(|i| {
                // Only the upper two thirds, as for a drop on a plate.
                let (s, t) = (0.71 * f64::from(i), 2.0 * f64::from(i) / 199.0);
                let side = if D == 2 {
                    [t.sin() * s.cos().signum(), 0.0]
                } else {
                    [t.sin() * s.cos(), t.sin() * s.sin()]
                };
                let x = Vector::from_fn(|a, _| {
                    if a + 1 == D { vertical_semi_axis * t.cos() } else { horizontal_semi_axis * side[a] }
                });
                (center + x, 1.0)
            })
            .collect();
        let fit = Ellipsoid::fit(&points).unwrap();
        assert!((fit.center - center).norm() < 1e-8 * horizontal_semi_axis, "{fit:?}");
        assert!(
            (fit.horizontal_semi_axis / horizontal_semi_axis - 1.0).abs() < 1e-8
                && (fit.vertical_semi_axis / vertical_semi_axis - 1.0).abs() < 1e-8,
            "{fit:?}"
        );
        assert!(points.iter().all(|(x, _)| it.distance(x).abs() < 1e-9 * horizontal_semi_axis));
    }

    #[test]
    fn ellipses_and_spheroids_are_found() {
        found::<2>(1.0, 0.7);
        found::<2>(1e-3, 1.3e-3);
        found::<3>(1.0, 0.6);
        found::<3>(1e-3, 1e-3);
        // A line determines no ellipse.
        let line: Vec<_> = (0..9).map(|i| (Vector::<2>::new(f64::from(i), 0.0), 1.0)).collect();
        assert_eq!(Ellipsoid::fit(&line), None);
    }

    #[test]
    fn distance_and_normal_of_a_sphere_are_exact() {
        let it = Ellipsoid::<3>::from_sphere(&Sphere { center: Vector::repeat(1.0), radius: 2.0 });
        let out = Vector::<3>::new(2.0, -1.0, 2.0) / 3.0;
        let x = Vector::repeat(1.0) + out * 2.7;
        assert!((it.distance(&x) - 0.7).abs() < 1e-12 && (it.normal(&x) - out).norm() < 1e-12);
    }
}
