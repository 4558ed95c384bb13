//! What stays fixed during a run: the parameters, what the grid resolves, and how long steps may be.

pub mod parameters;
pub mod resolution;
pub mod time_step;

pub use parameters::{Model, Numerics, Wall};
