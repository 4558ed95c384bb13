//! Scene files: the grammar as written, the resolved scene in SI units, and errors that point at the value.

mod deserialize;
mod document;
mod grammar;
mod material;
mod resolve;
mod resolved;
mod runnable;
mod scene_files;
mod source;
mod write;

pub use document::Document;
pub use grammar::{Format, OutlineName, SceneFile, Scheme, Side, Wall};
pub use material::{Elastic, Material};
pub use resolve::{LoadOptions, Quality};
pub use resolved::{
    Body, Bounds, ContactLine, Domain, Expectation, Hysteresis, Liquid, Moved, Numerics, Outline, Output,
    Rotation, Scene, ShapeSpec, Solid, SolidTension, Tensions, WALLS, Warning, Warnings, Wetting,
    WettingImage,
};
pub(crate) use resolved::{outline, rotation, vector};
pub use runnable::ensure_runnable;
pub use scene_files::SceneFiles;
pub(crate) use scene_files::builtin_name;
pub use source::Source;
