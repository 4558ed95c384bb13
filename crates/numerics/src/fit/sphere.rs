//! Least-squares fit of circles and spheres, and their angles with planes and balls.

use super::least_squares;
use crate::Vector;

/// A circle or sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere<const D: usize> {
    /// Centre, m.
    pub center: Vector<D>,
    /// Radius, m.
    pub radius: f64,
}

impl<const D: usize> Sphere<D> {
    /// Fits weighted points by least squares of `|x|² = 2 c·x + k`; `None` if they determine no sphere.
    pub fn fit(points: &[(Vector<D>, f64)]) -> Option<Self> {
        let origin = points.first()?.0;
        // In 2D the third entry of the basis is unused: a weight pins its coefficient to zero.
        let pin = (if D == 2 { 1.0 } else { 0.0 }, [0.0, 0.0, 1.0, 0.0], 0.0);
        let scale = points.iter().map(|p| (p.0 - origin).norm()).fold(0.0, f64::max);
        if scale <= 0.0 {
            return None;
        }
        let row = |(at, weight): &(Vector<D>, f64)| {
            let x = (at - origin) / scale;
            let mut basis = [0.0, 0.0, 0.0, 1.0];
            (0..D).for_each(|a| basis[a] = 2.0 * x[a]);
            (*weight, basis, x.norm_squared())
        };
        let fit = least_squares(points.iter().map(row).chain([pin]))?;
        let center = Vector::<D>::from_fn(|a, _| fit[a]);
        let radius = (fit[3] + center.norm_squared()).sqrt();
        radius.is_finite().then(|| Self { center: origin + center * scale, radius: radius * scale })
    }

    /// Angle, in degrees, measured through its inside, at which it meets a plane.
    pub fn angle_on_plane(&self, point: &Vector<D>, normal: &Vector<D>) -> f64 {
        (-(self.center - point).dot(normal) / self.radius).clamp(-1.0, 1.0).acos().to_degrees()
    }

    /// The same for a ball.
    pub fn angle_on_ball(&self, center: &Vector<D>, radius: f64) -> f64 {
        let gap = (self.center - center).norm_squared();
        let cosine = (self.radius.powi(2) + radius.powi(2) - gap) / (2.0 * self.radius * radius);
        cosine.clamp(-1.0, 1.0).acos().to_degrees()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found<const D: usize>() {
        let (center, radius) = (Vector::<D>::from_fn(|a, _| 0.3 - 0.25 * a as f64), 0.7);
        let up = Vector::<D>::from_fn(|a, _| f64::from(u8::from(a + 1 == D)));
        let points: Vec<(Vector<D>, f64)> = (0..60)
            .map(|i| {
                let (s, t) = (0.1 * f64::from(i), 0.37 * f64::from(i));
                let n = [s.cos() * t.sin(), t.cos(), s.sin() * t.sin()];
                let n = Vector::<D>::from_fn(|a, _| n[a]).normalize();
                (center + n * radius, 1.0 + 0.5 * s.sin())
            })
            .collect();
        let sphere = Sphere::fit(&points).unwrap();
        assert!((sphere.center - center).norm() < 1e-10 && (sphere.radius - radius).abs() < 1e-10);
        let below = center - up * (0.5 * radius);
        assert!((sphere.angle_on_plane(&below, &up) - 120.0).abs() < 1e-6);
        // A ball that meets it at right angles.
        let other = center - up * (radius * 2.0f64.sqrt());
        assert!((sphere.angle_on_ball(&other, radius) - 90.0).abs() < 1e-6);
    }

    #[test]
    fn circles_and_spheres_are_found_and_meet_what_they_meet() {
        found::<2>();
        found::<3>();
        assert_eq!(Sphere::<2>::fit(&[(Vector::zeros(), 1.0)]), None);
        assert_eq!(Sphere::<3>::fit(&[]), None);
    }
}
