//! Contact lines: angles, menisci, friction, hysteresis, patterns, sheets wrapped around drops.

pub mod domain_walls;
pub mod hysteresis;
pub mod line_friction;
pub mod meniscus;
pub mod ridge;
pub mod sessile;
pub mod sessile_gravity;
pub mod sliding;
pub mod wettability_step;
pub mod wrapping;

use crate::{Case, Group};

/// The group.
pub const GROUP: Group = Group { title: "Contact lines", cases: CASES };

/// Its cases, in the order in which they run.
const CASES: &[Case] = &[
    sessile::CASE_2D,
    sessile::CASE_3D,
    sessile::CURVED,
    sessile::STEPS,
    sessile::THIN,
    sliding::CASE,
    wettability_step::CASE,
    hysteresis::CASE,
    line_friction::CASE,
    sessile_gravity::CASE_2D,
    sessile_gravity::CASE_3D,
    meniscus::CASE_2D,
    meniscus::TUBE,
    domain_walls::CASE,
    ridge::CASE,
    wrapping::OPEN,
    wrapping::WRAP,
];
