//! Contact of solids. No step lets solids overlap or inverts an element, whatever its length.
//!
//! The velocities at the end of a step minimise an incremental potential ([`potential`]) by Newton's method, coupled to the pressure
//! solve ([`newton`]). Rigid solids bounce before that ([`impact`]).

pub mod broad_phase;
pub mod configuration;
pub mod impact;
pub mod initial_points;
pub mod newton;
pub mod overlap;
pub mod points;
pub mod potential;
pub mod solid_response;
pub mod tied_face;
