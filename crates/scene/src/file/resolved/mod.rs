//! A resolved scene in SI units, with defaults filled in and checked.

mod bounds;
mod expectation;
mod geometry;
mod scene;
mod shape;
mod tension;
mod warning;

pub use bounds::Bounds;
pub use expectation::Expectation;
pub(crate) use geometry::{outline, rotation, vector};
pub use scene::{Body, Domain, Liquid, Moved, Numerics, Output, Scene, Solid, WALLS};
pub(crate) use shape::VOLUME_EXTENSIONS;
pub use shape::{Outline, Rotation, ShapeSpec};
pub use tension::{ContactLine, Hysteresis, SolidTension, Tensions, Wetting, WettingImage};
pub use warning::{Warning, Warnings};
