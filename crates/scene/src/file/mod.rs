//! Scene files: the grammar as written, the resolved scene in SI units, and errors that point at the value.

mod builtin_meshes;
mod deserialize;
mod document;
mod grammar;
mod resolve;
mod resolved;
mod runnable;
mod write;

pub(crate) use builtin_meshes::read as read_mesh_file;
pub use document::{Document, Source};
pub(crate) use grammar::short;
pub use grammar::*;
pub use resolve::{LoadOptions, Quality};
pub use resolved::*;
pub(crate) use resolved::{outline, rotation, vector};
pub use runnable::ensure_runnable;
