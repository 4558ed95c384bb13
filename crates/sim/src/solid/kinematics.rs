//! States of solids: positions, velocities, and the forces of the last step.

use meniscus_elastic::{Elastic, ElasticState};
use meniscus_numerics::{Matrix, Vector};
use serde::{Deserialize, Serialize};

/// Time, s, of the difference that gives anchored vertices their initial velocity.
const INITIAL_DIFFERENCE_TIME: f64 = 1e-9;

/// State of a solid. Plain data.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SolidState<const D: usize> {
    /// Positions and velocities.
    pub kinematics: Kinematics<D>,
    /// Force of the liquid's pressure in the last step, N (2D: N/m).
    pub pressure_force: Vector<D>,
    /// Force of surface tension along the contact line in the last step, N (2D: N/m).
    pub contact_line_force: Vector<D>,
    /// Acceleration by contacts in the last step, without impacts, m/s².
    pub contact_acceleration: Vector<D>,
}

/// Positions and velocities of a solid: the unknowns of its [kind](super::SolidKind).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Kinematics<const D: usize> {
    /// Those of a fixed, prescribed or free rigid solid.
    Rigid(RigidKinematics<D>),
    /// Those of a deformable solid.
    Deformable(DeformableKinematics<D>),
}

/// Position and velocity of a rigid solid.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RigidKinematics<const D: usize> {
    /// Centre of mass, m.
    pub center: Vector<D>,
    /// Rotation since the start.
    pub rotation: Matrix<D>,
    /// Velocity of the centre, m/s.
    pub velocity: Vector<D>,
    /// Angular velocity, rad/s (2D: the last entry).
    pub angular_velocity: [f64; 3],
}

/// Positions and velocities of a deformable solid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DeformableKinematics<const D: usize> {
    /// Centre of mass, m.
    pub center: Vector<D>,
    /// Velocity of the centre of mass, m/s.
    pub velocity: Vector<D>,
    /// Positions and velocities of the mesh's vertices.
    pub vertices: ElasticState<D>,
}

impl<const D: usize> SolidState<D> {
    /// A solid on which no forces have acted.
    pub fn new(kinematics: Kinematics<D>) -> Self {
        let none = Vector::zeros();
        Self { kinematics, pressure_force: none, contact_line_force: none, contact_acceleration: none }
    }

    /// Position and velocity of a rigid solid.
    pub fn rigid(&self) -> Option<&RigidKinematics<D>> {
        match &self.kinematics {
            Kinematics::Rigid(rigid) => Some(rigid),
            Kinematics::Deformable(_) => None,
        }
    }

    /// [`Self::rigid`], to be changed.
    pub fn rigid_mut(&mut self) -> Option<&mut RigidKinematics<D>> {
        match &mut self.kinematics {
            Kinematics::Rigid(rigid) => Some(rigid),
            Kinematics::Deformable(_) => None,
        }
    }

    /// Positions and velocities of a deformable solid.
    pub fn as_deformable(&self) -> Option<&DeformableKinematics<D>> {
        match &self.kinematics {
            Kinematics::Rigid(_) => None,
            Kinematics::Deformable(body) => Some(body),
        }
    }

    /// [`Self::as_deformable`], to be changed.
    pub fn deformable_mut(&mut self) -> Option<&mut DeformableKinematics<D>> {
        match &mut self.kinematics {
            Kinematics::Rigid(_) => None,
            Kinematics::Deformable(body) => Some(body),
        }
    }

    /// The solid as if it were rigid: a deformable one moves with its centre of mass, without rotation.
    pub fn as_rigid(&self) -> RigidKinematics<D> {
        match &self.kinematics {
            Kinematics::Rigid(rigid) => *rigid,
            Kinematics::Deformable(body) => {
                RigidKinematics { velocity: body.velocity, ..RigidKinematics::at_rest(body.center) }
            }
        }
    }

    /// Positions of its nodes, m. Those of a deformable solid are its vertices; both of a rigid one are at its centre.
    pub fn node_positions(&self) -> Vec<Vector<D>> {
        match self.as_deformable() {
            Some(body) => body.vertices.positions.clone(),
            None => vec![self.center_of_mass(); 2],
        }
    }

    /// Velocities of its nodes. Those of a rigid solid are its velocity and its angular velocity.
    pub fn node_velocities(&self) -> Vec<Vector<D>> {
        match self.as_deformable() {
            Some(body) => body.vertices.velocities.clone(),
            None => vec![self.velocity(), angular_to_node(&self.as_rigid().angular_velocity)],
        }
    }

    /// Centre of mass, m.
    pub fn center_of_mass(&self) -> Vector<D> {
        self.as_rigid().center
    }

    /// Velocity of the centre of mass, m/s.
    pub fn velocity(&self) -> Vector<D> {
        self.as_rigid().velocity
    }
}

impl<const D: usize> RigidKinematics<D> {
    /// A solid at rest with its centre of mass at `center` (m).
    pub fn at_rest(center: Vector<D>) -> Self {
        Self { center, rotation: Matrix::identity(), velocity: Vector::zeros(), angular_velocity: [0.0; 3] }
    }

    /// Velocity of the solid at a point, m/s.
    pub fn velocity_at(&self, x: &Vector<D>) -> Vector<D> {
        let arm = Vector::<3>::from_fn(|a, _| if a < D { x[a] - self.center[a] } else { 0.0 });
        let turning = Vector::<3>::from(self.angular_velocity).cross(&arm);
        self.velocity + Vector::from_fn(|a, _| turning[a])
    }

    /// Rotates it at `angular_velocity` (rad/s) for `dt` (s).
    pub fn rotate(&mut self, angular_velocity: &[f64; 3], dt: f64) {
        let turn = nalgebra::Rotation3::new(Vector::<3>::from(*angular_velocity) * dt).into_inner();
        self.rotation = Matrix::<D>::from_fn(|r, c| turn[(r, c)]) * self.rotation;
    }
}

impl<const D: usize> DeformableKinematics<D> {
    /// The solid at the start, with the `velocity` (m/s) of vertices that are not anchored.
    pub fn at_start(elastic: &Elastic<D>, velocity: &Vector<D>) -> Self {
        let mut vertices = elastic.rest_state(INITIAL_DIFFERENCE_TIME);
        let free = vertices.velocities.iter_mut().zip(elastic.anchored()).filter(|(_, held)| !**held);
        free.for_each(|(v, _)| *v = *velocity);
        let mut body = Self { center: Vector::zeros(), velocity: Vector::zeros(), vertices };
        body.update_center_of_mass(elastic);
        body
    }

    /// Updates centre and velocity to those of its mass.
    pub fn update_center_of_mass(&mut self, elastic: &Elastic<D>) {
        let masses = elastic.masses();
        let mass: f64 = masses.iter().sum();
        let mean = |of: &[Vector<D>]| of.iter().zip(masses).map(|(x, m)| x * (m / mass)).sum();
        (self.center, self.velocity) = (mean(&self.vertices.positions), mean(&self.vertices.velocities));
    }
}

/// Angular velocity as the velocity of a node.
pub fn angular_to_node<const D: usize>(angular_velocity: &[f64; 3]) -> Vector<D> {
    Vector::from_fn(|a, _| {
        if D == 3 {
            angular_velocity[a]
        } else if a == 0 {
            angular_velocity[2]
        } else {
            0.0
        }
    })
}

/// Angular velocity of a node.
pub fn angular_from_node<const D: usize>(node: &Vector<D>) -> [f64; 3] {
    if D == 3 { std::array::from_fn(|a| node[a]) } else { [0.0, 0.0, node[0]] }
}
