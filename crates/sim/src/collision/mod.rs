//! Contact of solids: none may overlap, and no element turns inside out, whatever the step.
//!
//! The velocities at the end of a step make an incremental potential least ([`potential`]), by Newton's method together with the pressure
//! ([`newton`]). Before that rigid solids bounce ([`impact`]).

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
