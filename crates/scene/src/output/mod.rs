//! The output folder of a run.

pub mod file;
mod folder;
pub mod frame;
pub mod log;
pub mod series;
mod solids;
pub mod summary;

pub use file::FileError;
pub use folder::{Folder, FolderError};
pub use solids::SolidMeasures;
