//! Components of two times that became one another, and the rigid motion of what they are together.

use meniscus_numerics::{Matrix, Vector, rotation_planes};

/// Components of two times that became one another: which old ones, which new ones.
#[derive(Clone, Debug)]
pub struct ComponentGroup<const D: usize> {
    /// Old components.
    pub old: Vec<usize>,
    /// New components.
    pub new: Vec<usize>,
    /// What the new ones must be together at the end of the step, if they touch nothing that holds them.
    pub target_motion: Option<RigidMotion<D>>,
    /// What they must be once they are carried along and before any force acts, if solids hold them.
    pub advected_motion: Option<RigidMotion<D>>,
    /// The part of a vector in directions in which nothing but momentum tells their place: all of it where they touch
    /// nothing, what is along an even wall for drops on it.
    pub unconstrained_projector: Matrix<D>,
    /// Whether their angular momentum is told well enough to be kept.
    pub keeps_angular_momentum: bool,
}

impl<const D: usize> ComponentGroup<D> {
    /// These old components became these new ones.
    pub fn new(old: Vec<usize>, new: Vec<usize>) -> Self {
        Self {
            old,
            new,
            target_motion: None,
            advected_motion: None,
            unconstrained_projector: Matrix::zeros(),
            keeps_angular_momentum: true,
        }
    }
}

/// Bodies seen as one: mass over density, centre of mass, its velocity, and the angular momentum about it over density.
#[derive(Clone, Debug, PartialEq)]
pub struct RigidMotion<const D: usize> {
    /// Mass over density, m³ (2D: m²).
    pub volume: f64,
    /// Centre of mass, m.
    pub center: Vector<D>,
    /// Its velocity, m/s.
    pub velocity: Vector<D>,
    /// Angular momentum about it over density.
    pub angular_momentum_per_density: [f64; 3],
}

impl<const D: usize> RigidMotion<D> {
    /// The same body found elsewhere: its momentum and its angular momentum about any point stay.
    pub(super) fn moved_to(self, center: Vector<D>) -> Self {
        Self { angular_momentum_per_density: self.angular_momentum_about(&center), center, ..self }
    }

    /// Angular momentum over density about the point `from`.
    pub fn angular_momentum_about(&self, from: &Vector<D>) -> [f64; 3] {
        let (arm, mut sum) = (self.center - from, self.angular_momentum_per_density);
        for &(a, b, place) in rotation_planes::<D>() {
            sum[place] += self.volume * (arm[a] * self.velocity[b] - arm[b] * self.velocity[a]);
        }
        sum
    }
}
