//! The contact line, where liquid, solid and air meet: the forces there, friction, hysteresis, and where it is.
//!
//! The line is nowhere imposed: Young's angle is where the energy of [`crate::free_surface::energy`] is least.

pub mod angle;
pub mod force;
pub mod friction;
pub mod hysteresis;
pub mod local_balance;
pub mod sampling;
pub mod solid_tension;
pub mod tracker;
