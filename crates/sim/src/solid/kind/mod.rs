//! Kinds of solids: fixed, prescribed, rigid or deformable. All that the rest asks of a kind is here, each data type in a file beside.

mod prescribed;

use super::collision_surface::CollisionSurface;
use super::kinematics::{DeformableKinematics, Kinematics, RigidKinematics};
use super::surface::SolidSurface;
use meniscus_elastic::Elastic;
use meniscus_numerics::Vector;
use meniscus_numerics::mesh::SurfaceMesh;
use meniscus_numerics::mesh::volume::ElementOrder;
use std::sync::Arc;

pub use prescribed::PrescribedMotion;

/// Kind of a solid. Its state is an arm of [`super::Kinematics`].
#[derive(Clone, Debug)]
pub enum SolidKind<const D: usize> {
    /// It is rigid and stays at rest.
    Fixed,
    /// It is rigid, and its motion is prescribed.
    Prescribed(PrescribedMotion<D>),
    /// It is rigid and moves freely under gravity, liquid and contacts.
    Rigid,
    /// It deforms under the same and its own elastic forces.
    Deformable(Arc<Elastic<D>>),
}

impl<const D: usize> SolidKind<D> {
    /// Whether the motion does not depend on forces.
    pub fn is_prescribed(&self) -> bool {
        matches!(self, Self::Fixed | Self::Prescribed(_))
    }

    /// Whether it is rigid and forces move it.
    pub fn is_free_rigid(&self) -> bool {
        matches!(self, Self::Rigid)
    }

    /// The masses and forces of the vertices that are its unknowns; `None` for a rigid solid.
    pub fn elastic(&self) -> Option<&Elastic<D>> {
        match self {
            Self::Fixed | Self::Prescribed(_) | Self::Rigid => None,
            Self::Deformable(elastic) => Some(elastic),
        }
    }

    /// The surface at rest that its vertices move; empty for a rigid solid.
    pub fn rest_surface(&self) -> SolidSurface<D> {
        let Self::Deformable(elastic) = self else {
            return SolidSurface::new(SurfaceMesh::default(), Vec::new());
        };
        let (mesh, vertices) = elastic.rest_mesh().surface();
        let collision = match elastic.order() {
            ElementOrder::Linear => CollisionSurface::linear(mesh.facets.clone()),
            ElementOrder::Quadratic => {
                CollisionSurface::quadratic(elastic.rest_mesh(), mesh.facets.clone(), &vertices)
            }
        };
        SolidSurface::new(mesh, vertices).with_collision_surface(collision)
    }

    /// Positions and velocities at the start, with this centre of mass (m) and this initial velocity (m/s).
    pub fn initial_kinematics(&self, center: Vector<D>, velocity: Vector<D>) -> Kinematics<D> {
        let at_rest = RigidKinematics::at_rest(center);
        match self {
            Self::Deformable(elastic) => {
                Kinematics::Deformable(DeformableKinematics::at_start(elastic, &velocity))
            }
            Self::Prescribed(path) => Kinematics::Rigid(RigidKinematics {
                velocity: path.mean_velocity(0.0, 1e-9),
                angular_velocity: path.angular_velocity,
                ..at_rest
            }),
            Self::Fixed | Self::Rigid => Kinematics::Rigid(RigidKinematics { velocity, ..at_rest }),
        }
    }
}
