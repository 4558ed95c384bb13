//! Groups of components that became one another in a step, and their rigid motion.

use meniscus_numerics::{Matrix, Vector, rotation_planes};

/// Components of two times that became one another.
#[derive(Clone, Debug)]
pub struct ComponentGroup<const D: usize> {
    /// Old components.
    pub old: Vec<usize>,
    /// New components.
    pub new: Vec<usize>,
    /// Target motion of the new components at the end of the step, if they touch neither a side nor a constrained solid.
    pub target_motion: Option<RigidMotion<D>>,
    /// Target motion after advection and before the forces, if they touch constrained solids.
    pub advected_motion: Option<RigidMotion<D>>,
    /// Projector onto the directions in which momentum alone determines their position: all directions if they touch nothing, those
    /// along a plane wall for drops on it.
    pub unconstrained_projector: Matrix<D>,
    /// Whether their angular momentum is resolved well enough to be conserved.
    pub keeps_angular_momentum: bool,
}

impl<const D: usize> ComponentGroup<D> {
    /// A group of old components that became these new ones.
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

/// Rigid motion of a component, or of several as one.
#[derive(Clone, Debug, PartialEq)]
pub struct RigidMotion<const D: usize> {
    /// Mass over density, m³ (2D: m²).
    pub volume: f64,
    /// Centre of mass, m.
    pub center: Vector<D>,
    /// Velocity of the centre of mass, m/s.
    pub velocity: Vector<D>,
    /// Angular momentum about the centre of mass over density, m⁵/s (2D: m⁴/s, in the last entry).
    pub angular_momentum_per_density: [f64; 3],
}

impl<const D: usize> RigidMotion<D> {
    /// The same motion about another centre. The momentum and the angular momentum about any point are conserved.
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
