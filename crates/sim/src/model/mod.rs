//! Fixed data of a run: its parameters, the resolution of the grid, and the bounds of the step length.

pub mod parameters;
pub mod resolution;
pub mod time_step;

pub use parameters::{Model, Numerics, Scheme, Wall};
