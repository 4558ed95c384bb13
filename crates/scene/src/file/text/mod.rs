//! The text of a scene: TOML with positions, `--set`, quantities with units, and how they are deserialised.

mod deserialize;
mod document;
mod forms;
mod quantity;
mod source;

pub use document::Document;
pub use forms::{Either, Named, one_or_many, read_as};
pub use quantity::{
    Acceleration, Angle, AngularVelocity, Density, DynamicViscosity, Frequency, KinematicViscosity, Length,
    MeshScale, Pressure, Quantity, Si, Speed, Tension, Time,
};
pub(crate) use quantity::{HELP_MARK, short};
pub use source::Source;
