//! Positions of the points of solids within a step, and their derivatives by the velocities of the nodes.

use super::points::{CollisionPoints, PointOwner, SdfPair};
use crate::model::Model;
use crate::solid::{RigidKinematics, SolidState, angular_from_node};
use meniscus_numerics::shape::Shape;
use meniscus_numerics::{Matrix, Vector};

/// Step of the finite differences of a distance, in cells.
const DIFFERENCE_STEP_CELLS: f64 = 1e-4;

impl SdfPair {
    /// Distance from the point, at `x`, to the other feature, m.
    pub fn distance<const D: usize>(&self, places: &Configuration<'_, D>, x: &Vector<D>) -> f64 {
        match *self {
            Self::Rigid(_, solid, part) => places.distance_to_rigid(solid, part, x),
            Self::Side(_, side) => places.points.domain_sides[side].distance(x),
        }
    }
}

/// The solids after moving with given velocities for a given time.
pub struct Configuration<'a, const D: usize> {
    /// The model.
    pub model: &'a Model<D>,
    solids: &'a [SolidState<D>],
    /// Points of the solids.
    pub points: &'a CollisionPoints<D>,
    /// Velocities of the nodes.
    velocities: &'a [Vector<D>],
    /// Time of the motion, s.
    time: f64,
    frames: Vec<Frame<D>>,
}

/// A moved rigid solid; a deformable one has a frame at rest, which no point uses.
#[derive(Clone, Copy, Debug)]
struct Frame<const D: usize> {
    rigid: RigidKinematics<D>,
    /// Left Jacobian of the exponential map: it maps a change of the rotation vector to a rotation at the end.
    left_jacobian: Matrix<3>,
}

/// A node, and the derivative of a point's position by the node's velocity, divided by the time.
pub type NodeJacobian<const D: usize> = (usize, Matrix<D>);

impl<'a, const D: usize> Configuration<'a, D> {
    /// The solids after the time `time` (s) with these velocities.
    pub fn new(
        model: &'a Model<D>,
        solids: &'a [SolidState<D>],
        points: &'a CollisionPoints<D>,
        velocities: &'a [Vector<D>],
        time: f64,
    ) -> Self {
        let frame = |(k, now): (usize, &SolidState<D>)| {
            let mut rigid = now.as_rigid();
            if now.as_deformable().is_some() {
                return Frame { rigid, left_jacobian: Matrix::identity() };
            }
            let [velocity, turn] = [velocities[points.first_node[k]], velocities[points.first_node[k] + 1]];
            let angular_velocity = angular_from_node(&turn);
            rigid.center += velocity * time;
            rigid.rotate(&angular_velocity, time);
            Frame { rigid, left_jacobian: left_jacobian(&(Vector::<3>::from(angular_velocity) * time)) }
        };
        let frames = solids.iter().enumerate().map(frame).collect();
        Self { model, solids, points, velocities, time, frames }
    }

    /// Time of the motion, s.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Position of a point, m.
    pub fn position(&self, owner: &PointOwner<D>) -> Vector<D> {
        match *owner {
            PointOwner::Vertex { solid, vertex } => self.vertex_position(solid, vertex),
            PointOwner::FacetCenter { solid, facet } => facet
                .center_weights()
                .map(|(vertex, weight)| self.vertex_position(solid, vertex as usize) * weight)
                .sum(),
            PointOwner::Rigid { solid, at } => {
                self.model.solids[solid].to_current(&self.frames[solid].rigid, &at)
            }
        }
    }

    fn vertex_position(&self, solid: usize, vertex: usize) -> Vector<D> {
        let body = self.solids[solid].as_deformable();
        let from = body.map_or(Vector::zeros(), |b| b.vertices.positions[vertex]);
        from + self.velocities[self.points.first_node[solid] + vertex] * self.time
    }

    /// Positions of all points, m. This is a serial loop: a parallel one could wait for a task that waits for these positions.
    pub fn positions(&self) -> Vec<Vector<D>> {
        self.points.owners.iter().map(|owner| self.position(owner)).collect()
    }

    /// Bounding box of a rigid solid, m.
    pub fn bounds(&self, solid: usize) -> [Vector<D>; 2] {
        self.model.solids[solid].rigid_bounds(&self.frames[solid].rigid)
    }

    /// Corners of the box around a rigid solid at the start, where they are now, m; `None` if the box is not bounded.
    pub fn box_corners(&self, solid: usize) -> Option<Vec<Vector<D>>> {
        let (low, high) = self.model.solids[solid].shape.bounds();
        let corner = |k: usize| Vector::from_fn(|a, _| if k >> a & 1 == 1 { high[a] } else { low[a] });
        let now = |k| self.model.solids[solid].to_current(&self.frames[solid].rigid, &corner(k));
        (high - low).iter().all(|s| s.is_finite()).then(|| (0..1 << D).map(now).collect())
    }

    /// Initial position, m, of the material point of a rigid solid that is now at `x`.
    pub fn to_reference(&self, solid: usize, x: &Vector<D>) -> Vector<D> {
        self.model.solids[solid].to_reference(&self.frames[solid].rigid, x)
    }

    /// Signed distance of a point from a part of a rigid solid, m.
    pub fn distance_to_rigid(&self, solid: usize, part: usize, x: &Vector<D>) -> f64 {
        self.part(solid, part).signed_distance(&self.to_reference(solid, x))
    }

    /// Outward normal of that part at `x`; the last axis if the distance has no gradient.
    pub fn rigid_normal(&self, solid: usize, part: usize, x: &Vector<D>) -> Vector<D> {
        let up = Vector::from_fn(|a, _| if a + 1 == D { 1.0 } else { 0.0 });
        let normal = self
            .part(solid, part)
            .normal(&self.to_reference(solid, x), DIFFERENCE_STEP_CELLS * self.model.grid.dx);
        self.frames[solid].rigid.rotation * if normal.norm_squared() > 0.0 { normal } else { up }
    }

    fn part(&self, solid: usize, part: usize) -> &'a Shape<D> {
        match &self.model.solids[solid].shape {
            whole @ Shape::Union(_) => whole.parts()[part],
            whole => whole,
        }
    }

    /// Derivatives of a point's position by the velocities of its nodes.
    pub fn node_jacobians(&self, owner: &PointOwner<D>) -> Vec<NodeJacobian<D>> {
        match *owner {
            PointOwner::Vertex { solid, vertex } => {
                vec![(self.points.first_node[solid] + vertex, Matrix::identity())]
            }
            PointOwner::FacetCenter { solid, facet } => {
                let first = self.points.first_node[solid];
                facet.center_weights().map(|(v, w)| (first + v as usize, Matrix::identity() * w)).collect()
            }
            PointOwner::Rigid { solid, .. } => {
                let frame = &self.frames[solid];
                let arm = self.position(owner) - frame.rigid.center;
                let arm = Vector::<3>::from_fn(|a, _| if a < D { arm[a] } else { 0.0 });
                let turned = -arm.cross_matrix() * frame.left_jacobian;
                // In 2D the first component of the second node is the rotation about the third axis.
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

/// Left Jacobian `J` of the exponential map of a rotation: `exp((θ + δ)×) ≈ exp((J δ)×) exp(θ×)`.
fn left_jacobian(turn: &Vector<3>) -> Matrix<3> {
    let (angle, cross) = (turn.norm(), turn.cross_matrix());
    // Taylor series, because the closed form cancels at small angles.
    let (first, second) = if angle < 1e-3 {
        (0.5 - angle * angle / 24.0, 1.0 / 6.0 - angle * angle / 120.0)
    } else {
        ((1.0 - angle.cos()) / (angle * angle), (angle - angle.sin()) / angle.powi(3))
    };
    Matrix::<3>::identity() + cross * first + cross * cross * second
}
