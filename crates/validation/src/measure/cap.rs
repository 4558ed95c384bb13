//! Drops on solids: the circle or sphere that their surface is part of.

use super::dense::least_squares;
use super::surface::SurfacePoint;
use meniscus_numerics::Vector;

/// A circle or sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cap<const D: usize> {
    /// Centre, m.
    pub center: Vector<D>,
    /// Radius, m.
    pub radius: f64,
}

impl<const D: usize> Cap<D> {
    /// The one that points of a surface are nearest to (least squares of `|x|² = 2 c·x + k`), if there is one.
    pub fn fit(points: &[SurfacePoint<D>]) -> Option<Self> {
        let origin = points.first()?.at;
        let place = |p: &SurfacePoint<D>| p.at - origin;
        let coefficients: Vec<f64> = if D == 2 {
            let row = |p: &SurfacePoint<D>| {
                let x = place(p);
                (p.area, [2.0 * x[0], 2.0 * x[1], 1.0], x.norm_squared())
            };
            least_squares(points.iter().map(row))?.to_vec()
        } else {
            let row = |p: &SurfacePoint<D>| {
                let x = place(p);
                (p.area, [2.0 * x[0], 2.0 * x[1], 2.0 * x[2], 1.0], x.norm_squared())
            };
            least_squares(points.iter().map(row))?.to_vec()
        };
        let center = Vector::from_fn(|a, _| coefficients[a]);
        Some(Self { center: center + origin, radius: (coefficients[D] + center.norm_squared()).sqrt() })
    }

    /// Angle, in degrees and through the liquid, at which it meets a plane.
    pub fn angle_on_plane(&self, point: &Vector<D>, normal: &Vector<D>) -> f64 {
        (-(self.center - point).dot(normal) / self.radius).clamp(-1.0, 1.0).acos().to_degrees()
    }

    /// The same on a ball.
    pub fn angle_on_ball(&self, center: &Vector<D>, radius: f64) -> f64 {
        let gap = (self.center - center).norm_squared();
        let cosine = (self.radius.powi(2) + radius.powi(2) - gap) / (2.0 * self.radius * radius);
        cosine.clamp(-1.0, 1.0).acos().to_degrees()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sphere_is_found_and_meets_what_it_meets() {
        let (center, radius) = (Vector::<3>::new(0.3, -0.2, 0.5), 0.7);
        let points: Vec<SurfacePoint<3>> = (0..60)
            .map(|i| {
                let (s, t) = (0.1 * f64::from(i), 0.37 * f64::from(i));
                let normal = Vector::<3>::new(s.cos() * t.sin(), s.sin() * t.sin(), t.cos());
                SurfacePoint { at: center + normal * radius, normal, area: 1.0 }
            })
            .collect();
        let cap = Cap::fit(&points).unwrap_or(Cap { center: Vector::zeros(), radius: 0.0 });
        assert!((cap.center - center).norm() < 1e-10 && (cap.radius - radius).abs() < 1e-10, "{cap:?}");
        let up = Vector::<3>::new(0.0, 0.0, 1.0);
        let below = center - up * (0.5 * radius);
        assert!((cap.angle_on_plane(&below, &up) - 120.0).abs() < 1e-6);
        // A ball that meets it at right angles.
        let other = center - up * (radius * 2.0f64.sqrt());
        assert!((cap.angle_on_ball(&other, radius) - 90.0).abs() < 1e-6);
    }
}
