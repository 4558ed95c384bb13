//! Solids: what is constant about them, and how they advance.
//!
//! A rigid solid rotates about its centre of mass. Between impulses of the liquid its angular momentum `L = I ω` is constant, while `I`
//! rotates with it: the step uses the `ω` of `L` at the midpoint, which conserves `L` exactly and the energy to second order.

use super::kind::SolidKind;
use super::kinematics::{RigidKinematics, SolidState, angular_from_node};
use super::mass_properties::MassProperties;
use super::wettability::{Hysteresis, WettabilityLayer};
use meniscus_elastic::Elastic;
use meniscus_numerics::shape::Shape;
use meniscus_numerics::{Matrix, Vector};

/// A solid, rigid or deformable.
#[derive(Clone, Debug)]
pub struct Solid<const D: usize> {
    /// Shape and position at the start.
    pub shape: Shape<D>,
    /// Kind, which determines how it moves.
    pub kind: SolidKind<D>,
    /// Initial velocity, m/s.
    pub initial_velocity: Vector<D>,
    /// Mass, centre of mass and inertia.
    pub mass_properties: MassProperties<D>,
    /// Distance outside its own surface at which the liquid meets it, m ([`Self::padded`]).
    pub padding: f64,
    /// Cosine of Young's contact angle, `(γ_sa − γ_ls)/γ_la`; below −1 nothing is wetted, above 1 everything.
    pub young_cosine: f64,
    /// Layers over `young_cosine` where the cosine varies, the last on top; empty where it is uniform.
    pub pattern: Vec<WettabilityLayer<D>>,
    /// Friction of the contact line, Pa s: force per length over speed.
    pub line_friction: f64,
    /// Contact angle hysteresis; without it no contact line rests.
    pub hysteresis: Option<Hysteresis>,
    /// Coefficient of restitution, 0 to 1. For two solids the geometric mean applies, at a side of the domain that of the solid.
    pub restitution: f64,
    /// Coulomb friction coefficient, combined in the same way.
    pub friction: f64,
}

/// Thickness of a plate, in cells, from which on liquid on its two sides is resolved separately: contact angles of drops at rest are
/// then right within 0.4 degrees (1.4 with 2.25 cells, 1.9 with 2, up to 19 with 1.5).
pub const MIN_PLATE_THICKNESS_CELLS: f64 = 2.5;
/// Restitution of solids without a given value.
pub const DEFAULT_RESTITUTION: f64 = 0.3;
/// Friction of solids without a given value.
pub const DEFAULT_FRICTION: f64 = 0.3;

impl<const D: usize> Solid<D> {
    /// A homogeneous solid of a density, kg/m³, at rest and with a contact angle of 90 degrees, with [`DEFAULT_RESTITUTION`] and
    /// [`DEFAULT_FRICTION`]. An unbounded solid has no finite mass to move freely: it is fixed.
    pub fn new(shape: Shape<D>, kind: SolidKind<D>, density: f64) -> Self {
        let mut mass_properties = MassProperties::homogeneous(&shape, density);
        if let Some(elastic) = kind.elastic() {
            mass_properties.mass = elastic.masses().iter().sum();
        }
        let is_massless = kind.is_free_rigid() && !mass_properties.mass.is_finite();
        let kind = if is_massless { SolidKind::Fixed } else { kind };
        Self {
            shape,
            kind,
            initial_velocity: Vector::zeros(),
            mass_properties,
            padding: 0.0,
            young_cosine: 0.0,
            pattern: Vec::new(),
            line_friction: 0.0,
            hysteresis: None,
            restitution: DEFAULT_RESTITUTION,
            friction: DEFAULT_FRICTION,
        }
    }

    /// Pads a plate thinner than [`MIN_PLATE_THICKNESS_CELLS`] cells of size `dx` (m): its two sides would share cells, and liquid that
    /// wets one would wet the other. The liquid meets it farther out by half of the missing `thickness` (m); its mass and its own
    /// forces are unchanged.
    pub fn padded(self, thickness: f64, dx: f64) -> Self {
        Self { padding: 0.5 * (MIN_PLATE_THICKNESS_CELLS * dx - thickness).max(0.0), ..self }
    }

    /// State at the start.
    pub fn initial_state(&self) -> SolidState<D> {
        SolidState::new(self.kind.initial_kinematics(self.mass_properties.center, self.initial_velocity))
    }

    /// Its masses and elastic forces, if it deforms.
    pub fn elastic(&self) -> Option<&Elastic<D>> {
        self.kind.elastic()
    }

    /// Number of its nodes.
    pub fn node_count(&self) -> usize {
        self.elastic().map_or(2, |elastic| elastic.masses().len())
    }

    /// Masses of its nodes, kg; of an angular velocity the moment of inertia, kg m².
    pub fn node_masses(&self, now: &SolidState<D>) -> Vec<f64> {
        match self.elastic() {
            Some(elastic) => elastic.masses().to_vec(),
            None => vec![self.mass_properties.mass, self.inertia(&now.as_rigid()).trace() / 3.0],
        }
    }

    /// Whether the velocity of each of its nodes is prescribed.
    pub fn prescribed_nodes(&self) -> Vec<bool> {
        match self.elastic() {
            Some(elastic) => elastic.anchored().to_vec(),
            None => vec![self.kind.is_prescribed(); 2],
        }
    }

    /// Sets its velocity from those of its nodes, the first of `velocities` (m/s), unless it is prescribed.
    pub fn set_node_velocities(&self, now: &mut SolidState<D>, velocities: &[Vector<D>]) {
        if let (Some(elastic), Some(body)) = (self.elastic(), now.deformable_mut()) {
            let count = body.vertices.velocities.len();
            body.vertices.velocities.copy_from_slice(&velocities[..count]);
            body.update_center_of_mass(elastic);
        } else if let Some(rigid) = self.free_rigid_mut(now) {
            (rigid.velocity, rigid.angular_velocity) = (velocities[0], angular_from_node(&velocities[1]));
        }
    }

    /// Position and velocity of a solid that is rigid and moved by forces.
    pub fn free_rigid_mut<'a>(&self, now: &'a mut SolidState<D>) -> Option<&'a mut RigidKinematics<D>> {
        now.rigid_mut().filter(|_| self.kind.is_free_rigid())
    }

    /// Whether it moves freely as a whole.
    pub fn is_unconstrained(&self) -> bool {
        self.kind.is_free_rigid() || self.elastic().is_some_and(|elastic| !elastic.anchored().contains(&true))
    }

    /// Current position of the point of a rigid solid that was at `x` at the start, m.
    pub fn to_current(&self, rigid: &RigidKinematics<D>, x: &Vector<D>) -> Vector<D> {
        rigid.center + rigid.rotation * (x - self.mass_properties.center)
    }

    /// Initial position of the point of a rigid solid that is at `x` now, m.
    pub fn to_reference(&self, rigid: &RigidKinematics<D>, x: &Vector<D>) -> Vector<D> {
        self.mass_properties.center + rigid.rotation.tr_mul(&(x - rigid.center))
    }

    /// Bounding box of a rigid solid, m.
    pub fn rigid_bounds(&self, rigid: &RigidKinematics<D>) -> [Vector<D>; 2] {
        let (low, high) = self.shape.bounds();
        if !(high - low).iter().all(|s| s.is_finite()) {
            return [low, high];
        }
        let middle = self.to_current(rigid, &(0.5 * (low + high)));
        let reach = rigid.rotation.abs() * ((high - low) * 0.5);
        [middle - reach, middle + reach]
    }

    /// Largest speed of any point of a rigid solid, m/s.
    pub fn max_rigid_speed(&self, rigid: &RigidKinematics<D>) -> f64 {
        let [low, high] = self.rigid_bounds(rigid);
        let angular_speed = Vector::<3>::from(rigid.angular_velocity).norm();
        let reach = (low - rigid.center).abs().sup(&(high - rigid.center).abs()).norm();
        rigid.velocity.norm() + if angular_speed > 0.0 { angular_speed * reach } else { 0.0 }
    }

    /// Largest speed of any of its points, m/s.
    pub fn max_speed(&self, now: &SolidState<D>) -> f64 {
        match now.as_deformable() {
            Some(body) => body.vertices.velocities.iter().map(Vector::norm).fold(0.0, f64::max),
            None => self.max_rigid_speed(&now.as_rigid()),
        }
    }

    /// Current inertia matrix of a rigid solid, kg m².
    pub fn inertia(&self, rigid: &RigidKinematics<D>) -> Matrix<3> {
        let turn = embed_in_3d(&rigid.rotation);
        turn * self.mass_properties.inertia * turn.transpose()
    }

    /// Inverse of the current inertia matrix of a rigid solid, 1/(kg m²).
    pub fn inverse_inertia(&self, rigid: &RigidKinematics<D>) -> Matrix<3> {
        self.inertia(rigid).try_inverse().unwrap_or_else(Matrix::zeros)
    }

    /// Advances it from `time` by `dt` (s). The velocity of a prescribed motion is then that of the coming step, for which the liquid's
    /// is solved.
    pub fn advance(&self, now: &mut SolidState<D>, time: f64, dt: f64) {
        if let (Some(elastic), Some(body)) = (self.elastic(), now.deformable_mut()) {
            elastic.advance_positions(&mut body.vertices, dt);
            body.update_center_of_mass(elastic);
        } else if let (SolidKind::Prescribed(path), Some(rigid)) = (&self.kind, now.rigid_mut()) {
            rigid.center = self.mass_properties.center + path.displacement(time + dt);
            rigid.velocity = path.mean_velocity(time + dt, dt);
            rigid.angular_velocity = path.angular_velocity;
            rigid.rotate(&path.angular_velocity, dt);
        } else if let Some(rigid) = self.free_rigid_mut(now) {
            rigid.center += rigid.velocity * dt;
            let momentum = self.angular_momentum(rigid);
            let mut half = *rigid;
            half.rotate(&rigid.angular_velocity, 0.5 * dt);
            let spin: [f64; 3] = (self.inverse_inertia(&half) * momentum).into();
            rigid.rotate(&spin, dt);
            rigid.angular_velocity = (self.inverse_inertia(rigid) * momentum).into();
        }
    }

    /// Kinetic energy, J.
    pub fn kinetic_energy(&self, now: &SolidState<D>) -> f64 {
        match self.elastic().zip(now.as_deformable()) {
            Some((elastic, body)) => elastic.kinetic_energy(&body.vertices.velocities),
            None => {
                let rigid = now.as_rigid();
                let turning = self.angular_momentum(&rigid).dot(&Vector::<3>::from(rigid.angular_velocity));
                0.5 * (self.mass_properties.mass * rigid.velocity.norm_squared() + turning)
            }
        }
    }

    /// Angular momentum of a rigid solid about its centre of mass, kg m²/s.
    pub fn angular_momentum(&self, rigid: &RigidKinematics<D>) -> Vector<3> {
        let turn = embed_in_3d(&rigid.rotation);
        let spin = Vector::<3>::from(rigid.angular_velocity);
        turn * (self.mass_properties.inertia * (turn.transpose() * spin))
    }
}

/// A rotation in the plane as one in space.
fn embed_in_3d<const D: usize>(rotation: &Matrix<D>) -> Matrix<3> {
    let own = |r: usize, c: usize| f64::from(u8::from(r == c));
    Matrix::<3>::from_fn(|r, c| if r < D && c < D { rotation[(r, c)] } else { own(r, c) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solid::{Kinematics, PrescribedMotion};

    #[test]
    fn a_tumbling_box_keeps_momentum_and_energy() {
        let shape = Shape::Box {
            center: Vector::<3>::zeros(),
            half_size: Vector::<3>::new(0.5, 0.3, 0.1),
            rotation: Matrix::identity(),
        };
        let solid = Solid::new(shape, SolidKind::Rigid, 1.0);
        // Rotation about the middle axis is unstable: the box flips over and over.
        let spin = [0.01, 1.0, 0.02];
        let rigid = RigidKinematics { angular_velocity: spin, ..solid.initial_state().as_rigid() };
        let mut now = SolidState::new(Kinematics::Rigid(rigid));
        let energy = |now: &SolidState<3>| 2.0 * solid.kinetic_energy(now);
        let momentum = |now: &SolidState<3>| solid.angular_momentum(&now.as_rigid());
        let (start_momentum, start) = (momentum(&now), energy(&now));
        let mut lowest = 1.0f64;
        for step in 0..4000 {
            solid.advance(&mut now, step as f64 * 0.02, 0.02);
            lowest = lowest.min(now.as_rigid().rotation[(1, 1)]);
            assert!((momentum(&now) - start_momentum).norm() < 1e-11 * start_momentum.norm());
            assert!((energy(&now) / start - 1.0).abs() < 2e-3, "{}", energy(&now) / start);
        }
        let rotation = now.as_rigid().rotation;
        assert!(lowest < -0.9, "it never flipped: {lowest}");
        assert!((rotation.transpose() * rotation - Matrix::identity()).norm() < 1e-10);
    }

    #[test]
    fn keyframes_are_met() {
        let path = PrescribedMotion {
            velocity: Vector::<2>::zeros(),
            angular_velocity: [0.0; 3],
            keyframes: vec![(1.0, Vector::<2>::new(0.0, 0.0)), (3.0, Vector::<2>::new(0.4, -0.2))],
        };
        assert_eq!(path.displacement(0.0), Vector::<2>::zeros());
        assert!((path.displacement(2.0) - Vector::<2>::new(0.2, -0.1)).norm() < 1e-15);
        assert_eq!(path.displacement(9.0), Vector::<2>::new(0.4, -0.2));
        let shape = Shape::Ball { center: Vector::<2>::new(0.5, 0.5), radius: 0.1 };
        let solid = Solid::new(shape, SolidKind::Prescribed(path), 1.0);
        let mut now = solid.initial_state();
        solid.advance(&mut now, 2.5, 0.25);
        let center = now.center_of_mass();
        assert!((center - Vector::<2>::new(0.85, 0.325)).norm() < 1e-3, "{center}");
    }
}
