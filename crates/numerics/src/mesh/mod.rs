//! Surfaces made of facets: their measures, their reading, their making from a level set.

mod dual_vertex;
pub mod isosurface;
pub mod ply;
pub mod surface;

pub use isosurface::{Isosurface, extract};
pub use surface::SurfaceMesh;
