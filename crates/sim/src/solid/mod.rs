//! Solids: rigid, prescribed and deformable ones, their surfaces and their wettability.

pub mod collision_surface;
pub mod description;
pub mod domain_walls;
pub mod equilibrium_angle;
pub mod kind;
pub mod kinematics;
pub mod mass_properties;
pub mod surface;
pub mod view;
pub mod wettability;

pub use description::{DEFAULT_FRICTION, DEFAULT_RESTITUTION, MIN_PLATE_THICKNESS_CELLS, Solid};
pub use kind::{PrescribedMotion, SolidKind};
pub use kinematics::{
    DeformableKinematics, Kinematics, RigidKinematics, SolidState, angular_from_node, angular_to_node,
};
pub use view::{SolidSurfaces, SolidView, Solids};
