//! Scene files: the grammar, exactly as written; the scene that they resolve to, in SI; errors that point at the value.

mod document;
mod grammar;
mod meshes;
mod resolve;
mod resolved;
mod runnable;
mod write;

pub use document::{Document, Source};
pub(crate) use grammar::short;
pub use grammar::*;
pub(crate) use meshes::read as read_mesh_file;
pub use resolve::{LoadOptions, Quality};
pub use resolved::*;
pub(crate) use resolved::{outline, describe_outside, rotation, vector};
pub use runnable::ensure_runnable;
