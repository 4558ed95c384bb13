//! A resolved scene in SI units, with defaults filled in and checked.

mod bounds;
mod expectation;
mod geometry;
mod scene;
mod tension;

pub use bounds::Bounds;
pub use expectation::Expectation;
pub(crate) use geometry::{outline, rotation, vector};
pub use scene::*;
pub use tension::*;
