//! The output folder of a run.

pub mod atomic_file;
mod folder;
pub mod frame;
pub mod log;
mod solid_measures;
pub mod summary;
pub mod time_series;

pub use atomic_file::FileError;
pub use folder::{Folder, FolderError};
pub use solid_measures::SolidMeasures;
