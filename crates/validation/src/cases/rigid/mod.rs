//! Rigid solids: floating, added mass, momentum, impact, contact.

pub mod bounce;
pub mod buoyancy;
pub mod floating;
pub mod leak;
pub mod momentum_with_solid;
pub mod moving_plate;
pub mod rigid_contact;

use crate::{Case, Group};

/// The group.
pub const GROUP: Group = Group { title: "Rigid solids", cases: CASES };

/// Its cases, in the order in which they run.
const CASES: &[Case] = &[
    bounce::CASE,
    moving_plate::CASE,
    floating::FREE_BODY,
    floating::FIXED_BODY,
    buoyancy::BUOYANCY,
    buoyancy::ADDED_MASS,
    momentum_with_solid::CASE,
    leak::CASE,
    rigid_contact::CASE,
];
