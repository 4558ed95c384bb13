//! The output folder of a run, and parts of Markdown pages.

pub mod atomic_file;
mod folder;
pub mod frame;
pub mod log;
pub mod markdown;
mod solid_measures;
pub mod summary;
pub mod time_series;

pub use atomic_file::FileError;
pub use folder::{Folder, FolderError};
pub use solid_measures::{SolidMeasures, solid_columns};
