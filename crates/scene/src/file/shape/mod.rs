//! Shapes of a scene: as they are written and in memory, their checks, and their bounds.

mod bounds;
mod box_form;
mod extrusion_form;
mod geometry;
mod rotation;
mod spec;
mod validate;

pub use bounds::Bounds;
pub use extrusion_form::{Outline, OutlineName};
pub(crate) use geometry::{outline, rotation, vector};
pub use rotation::Rotation;
pub use spec::ShapeSpec;
