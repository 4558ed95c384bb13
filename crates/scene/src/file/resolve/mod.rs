//! Resolves a scene file to a scene: defaults, grid, SI units, checks. Errors point at the value.

mod expectation;
mod repairs;
mod resolver;
mod scene;
mod shape;
mod solid;
mod wetting;

pub(super) use resolver::Resolver;
pub use scene::{LoadOptions, Quality};
