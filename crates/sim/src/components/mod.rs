//! Connected components of the liquid: what becomes of them, their volume, momentum and spin.

pub mod group;
pub mod momentum;
pub mod restoration;
pub mod tracking;
pub mod volume;
