//! Estimates of a scene without running it: time scales, elasticity, memory, and gaps and films that the grid does not resolve.

pub mod check;
mod check_text;
pub mod deformable;
mod gaps;
pub mod memory;
pub mod parameters;
pub mod scales;
pub(crate) mod stiffness;
pub mod thin_liquid;
