//! Solids: rigid, prescribed and deformable ones, their surfaces and their wettability.

pub mod deformable;
pub mod domain_walls;
pub mod equilibrium_angle;
pub mod kinematics;
pub mod mass_properties;
pub mod surface;
pub mod wettability;

pub use kinematics::{
    DEFAULT_FRICTION, DEFAULT_RESTITUTION, MIN_PLATE_THICKNESS_CELLS, PrescribedMotion, Solid, SolidKind,
    SolidState,
};
