//! From the file to a scene that makes sense: defaults, grid, SI, and errors that point at the value.

mod repairs;
mod scene;
mod shape;
mod solid;
mod wetting;

pub use scene::{LoadOptions, Quality};
