//! Rigid solids: floating, added mass, momentum, impact, contact.

pub mod bounce;
pub mod buoyancy;
pub mod floating;
pub mod leak;
pub mod momentum_with_solid;
pub mod moving_plate;
pub mod rigid_contact;
