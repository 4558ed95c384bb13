//! Places of the points of solids on the way of a step, and their derivatives by the velocities of the nodes.

use super::points::{CollisionPoints, PointOwner, SdfPair, angular_from_node};
use crate::model::Model;
use crate::solid::SolidState;
use meniscus_numerics::shape::Shape;
use meniscus_numerics::{Matrix, Vector};

/// Step of the differences of a distance, in cells.
const DIFFERENCE_STEP_CELLS: f64 = 1e-4;

impl SdfPair {
    /// The distance of the point, which is at `x`, from the other, m.
    pub fn distance<const D: usize>(&self, places: &Configuration<'_, D>, x: &Vector<D>) -> f64 {
        match *self {
            Self::Rigid(_, solid, part) => places.distance_to_rigid((solid, part), x),
            Self::Side(_, side) => places.points.domain_sides[side].distance(x),
        }
    }
}

/// Solids somewhere on the way of a step.
pub struct Configuration<'a, const D: usize> {
    /// The model.
    pub model: &'a Model<D>,
    solids: &'a [SolidState<D>],
    /// The solids' points.
    pub points: &'a CollisionPoints<D>,
    /// Velocities of the nodes.
    velocities: &'a [Vector<D>],
    /// For how long they go on, s.
    time: f64,
    frames: Vec<Frame<D>>,
}

/// Where a rigid solid is.
#[derive(Clone, Copy, Debug)]
struct Frame<const D: usize> {
    center: Vector<D>,
    rotation: Matrix<D>,
    /// What its angular velocity does to the rate at which it turns at the end: the left Jacobian of the exponential.
    left_jacobian: Matrix<3>,
}

/// How a point follows a node: the node, and the derivative of the point's position by the node's velocity over the time.
pub type NodeJacobian<const D: usize> = (usize, Matrix<D>);

impl<'a, const D: usize> Configuration<'a, D> {
    /// After a time with these velocities.
    pub fn new(
        model: &'a Model<D>,
        solids: &'a [SolidState<D>],
        points: &'a CollisionPoints<D>,
        velocities: &'a [Vector<D>],
        time: f64,
    ) -> Self {
        let frame = |(k, now): (usize, &SolidState<D>)| {
            if now.soft.is_some() {
                return Frame {
                    center: Vector::zeros(),
                    rotation: Matrix::identity(),
                    left_jacobian: Matrix::identity(),
                };
            }
            let [velocity, turn] = [velocities[points.first_node[k]], velocities[points.first_node[k] + 1]];
            let turn = Vector::<3>::from(angular_from_node(&turn)) * time;
            let rotation = nalgebra::Rotation3::new(turn).into_inner();
            let rotation = Matrix::<D>::from_fn(|r, c| rotation[(r, c)]) * now.rotation;
            Frame { center: now.center + velocity * time, rotation, left_jacobian: left_jacobian(&turn) }
        };
        let frames = solids.iter().enumerate().map(frame).collect();
        Self { model, solids, points, velocities, time, frames }
    }

    /// The time, s.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Where a point is, m.
    pub fn position(&self, owner: &PointOwner<D>) -> Vector<D> {
        match *owner {
            PointOwner::Vertex { solid, vertex } => {
                let from =
                    self.solids[solid].soft.as_ref().map_or(Vector::zeros(), |s| s.state.positions[vertex]);
                from + self.velocities[self.points.first_node[solid] + vertex] * self.time
            }
            PointOwner::Rigid { solid, at } => {
                let frame = &self.frames[solid];
                frame.center + frame.rotation * (at - self.model.solids[solid].mass_properties.center)
            }
        }
    }

    /// Where all points are, m.
    pub fn positions(&self) -> Vec<Vector<D>> {
        self.points.owners.iter().map(|owner| self.position(owner)).collect()
    }

    /// A box around a rigid solid, m.
    pub fn bounds(&self, solid: usize) -> [Vector<D>; 2] {
        let frame = &self.frames[solid];
        let now = SolidState { center: frame.center, rotation: frame.rotation, ..self.solids[solid].clone() };
        self.model.solids[solid].bounds(&now)
    }

    /// Where the point of a rigid solid that is at `x` was at the start, m.
    pub fn to_reference(&self, solid: usize, x: &Vector<D>) -> Vector<D> {
        let frame = &self.frames[solid];
        self.model.solids[solid].mass_properties.center + frame.rotation.tr_mul(&(x - frame.center))
    }

    /// Distance of a point from a part of a rigid solid, m.
    pub fn distance_to_rigid(&self, (solid, part): (usize, usize), x: &Vector<D>) -> f64 {
        self.part(solid, part).signed_distance(&self.to_reference(solid, x))
    }

    /// The direction away from that; any where there is none.
    pub fn rigid_normal(&self, (solid, part): (usize, usize), x: &Vector<D>) -> Vector<D> {
        let up = Vector::from_fn(|a, _| if a + 1 == D { 1.0 } else { 0.0 });
        let normal = self
            .part(solid, part)
            .normal(&self.to_reference(solid, x), DIFFERENCE_STEP_CELLS * self.model.grid.dx);
        self.frames[solid].rotation * if normal.norm_squared() > 0.0 { normal } else { up }
    }

    fn part(&self, solid: usize, part: usize) -> &'a Shape<D> {
        match &self.model.solids[solid].shape {
            whole @ Shape::Union(_) => whole.parts()[part],
            whole => whole,
        }
    }

    /// How a point follows the nodes.
    pub fn node_jacobians(&self, owner: &PointOwner<D>) -> Vec<NodeJacobian<D>> {
        match *owner {
            PointOwner::Vertex { solid, vertex } => {
                vec![(self.points.first_node[solid] + vertex, Matrix::identity())]
            }
            PointOwner::Rigid { solid, .. } => {
                let frame = &self.frames[solid];
                let arm = self.position(owner) - frame.center;
                let arm = Vector::<3>::from_fn(|a, _| if a < D { arm[a] } else { 0.0 });
                let turned = -arm.cross_matrix() * frame.left_jacobian;
                // In 2D the node's first component turns about the third axis.
                let turn = Matrix::<D>::from_fn(|r, c| match D {
                    2 if c == 0 => turned[(r, 2)],
                    2 => 0.0,
                    _ => turned[(r, c)],
                });
                let node = self.points.first_node[solid];
                vec![(node, Matrix::identity()), (node + 1, turn)]
            }
        }
    }
}

/// The left Jacobian of the exponential of a rotation: `(exp((θ + δ)×) ≈ exp((J δ)×) exp(θ×))`.
fn left_jacobian(turn: &Vector<3>) -> Matrix<3> {
    let (angle, cross) = (turn.norm(), turn.cross_matrix());
    // Series where differences would be of nearly equal numbers.
    let (first, second) = if angle < 1e-3 {
        (0.5 - angle * angle / 24.0, 1.0 / 6.0 - angle * angle / 120.0)
    } else {
        ((1.0 - angle.cos()) / (angle * angle), (angle - angle.sin()) / angle.powi(3))
    };
    Matrix::<3>::identity() + cross * first + cross * cross * second
}
