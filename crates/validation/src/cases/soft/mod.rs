//! Liquid and deformable solids.

pub mod edge_pinned;
pub mod elastica_drop;
pub mod floating_plate;
pub mod newton;
pub mod plates;
pub mod soft_impact;
pub mod soft_moment;
pub mod soft_release;
pub mod soft_sag;
pub mod soft_tank;
pub mod soft_tension;

use crate::{Case, Group};

/// The group.
pub const GROUP: Group = Group { title: "Liquid and deformable solids", cases: CASES };

/// Its cases, in the order in which they run.
const CASES: &[Case] = &[
    floating_plate::CASE,
    plates::KINK,
    plates::STRIP,
    plates::STIFF,
    soft_sag::CASE,
    soft_moment::CASE,
    edge_pinned::CASE,
    soft_tank::CASE,
    soft_tension::CASE,
    soft_release::CASE,
    newton::CASE,
    soft_impact::CASE,
    elastica_drop::CASE,
];
