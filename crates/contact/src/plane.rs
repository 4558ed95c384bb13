//! A plane that nothing moves: a side of the domain.

use crate::ccd::Clearance;
use meniscus_numerics::Vector;

/// A plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane<const D: usize> {
    /// A point of it, m.
    pub point: Vector<D>,
    /// Unit vector to the side where things are.
    pub normal: Vector<D>,
}

impl<const D: usize> Plane<D> {
    /// Distance of a point from it, m.
    pub fn distance(&self, x: &Vector<D>) -> f64 {
        (x - self.point).dot(&self.normal)
    }

    /// The largest part of a way, up to all of it, on which a point keeps a clearance.
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
