//! Connected components of the liquid: tracking, and restoration of their volume, momentum and angular momentum.

pub mod group;
pub mod moments;
pub mod momentum;
pub mod restoration;
pub mod tracking;
pub mod volume;
