//! A resolved scene: SI, defaults filled in, checked for sense.

mod expectation;
mod extent;
mod geometry;
mod scene;
mod tension;

pub use expectation::Expectation;
pub use extent::Bounds;
pub(crate) use extent::describe_outside;
pub(crate) use geometry::{outline, rotation, vector};
pub use scene::*;
pub use tension::*;
