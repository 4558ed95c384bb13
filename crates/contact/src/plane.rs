//! Fixed plane: a side of the domain.

use crate::ccd::Clearance;
use meniscus_numerics::Vector;

/// A plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane<const D: usize> {
    /// Point on the plane, m.
    pub point: Vector<D>,
    /// Unit normal towards the admissible side.
    pub normal: Vector<D>,
}

impl<const D: usize> Plane<D> {
    /// Signed distance of a point, m.
    pub fn distance(&self, x: &Vector<D>) -> f64 {
        (x - self.point).dot(&self.normal)
    }

    /// Largest fraction, at most 1, of a displacement for which a point keeps a clearance.
    pub fn collision_free_fraction(
        &self,
        x: &Vector<D>,
        displacement: &Vector<D>,
        Clearance { thickness, kept_fraction }: Clearance,
    ) -> f64 {
        let (far, nearer) = (self.distance(x) - thickness, -displacement.dot(&self.normal));
        if nearer <= (1.0 - kept_fraction) * far {
            1.0
        } else {
            ((1.0 - kept_fraction) * far / nearer).max(0.0)
        }
    }
}
