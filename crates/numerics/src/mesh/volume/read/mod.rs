//! Import of volume meshes.

mod error;
mod gmsh;
mod load;
mod raw_mesh;
mod reader;
mod tetgen;
mod vtk;

pub use error::VolumeImportError;
pub use load::load;
