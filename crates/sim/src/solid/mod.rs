//! Solids by themselves: rigid ones, those that go as told, those that deform; their surfaces and what wets them.

pub mod definition;
pub mod deformable;
pub mod domain_walls;
pub mod equilibrium_angle;
pub mod rigid_body;
pub mod surface;
pub mod wettability;

pub use definition::{DEFAULT_FRICTION, Motion, PrescribedMotion, DEFAULT_RESTITUTION, Solid, SolidState, MIN_PLATE_THICKNESS_CELLS};
