//! Scene files: their text, the scene as one type for what is written and what is used, and errors that point at the value.

mod runnable;
mod scene;
mod scene_files;
mod sections;
mod shape;
mod text;
mod validator;

pub use runnable::ensure_runnable;
pub use scene::{LoadOptions, Scene, Warnings};
pub use scene_files::SceneFiles;
pub(crate) use scene_files::builtin_name;
pub(crate) use sections::expect_entry;
pub use sections::{
    AngleAt, Body, Collision, ContactLine, Deflection, Domain, Elastic, Expect, Hysteresis, Keyframe, Liquid,
    Material, Moved, Numerics, Output, Patch, Quality, Scheme, SeriesBound, SeriesValue, Side, Solid,
    SolidTension, Tensions, WALLS, Wall, Wetted, Wetting, WettingImage,
};
pub use shape::{Bounds, Outline, OutlineName, Rotation, ShapeSpec};
pub(crate) use shape::{outline, rotation, vector};
pub use text::{DynamicViscosity, Either, Source};
pub use validator::Warning;
