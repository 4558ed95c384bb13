//! The output folder of a run.

pub mod file;
mod folder;
pub mod frame;
pub mod log;
pub mod series;
pub mod summary;

pub use file::FileError;
pub use folder::{Folder, FolderError};
