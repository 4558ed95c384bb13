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
