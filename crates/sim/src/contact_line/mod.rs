//! The contact line, where liquid, solid and air meet: its forces, friction, hysteresis, angle and position.
//!
//! The contact angle is not imposed: Young's angle minimises the energy of [`crate::free_surface::energy`].

pub mod angle;
pub mod force;
pub mod friction;
pub mod hysteresis;
pub mod local_balance;
pub mod sampling;
pub mod solid_tension;
pub mod tracker;
