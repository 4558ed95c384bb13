//! Surfaces made of facets: their measures, their reading, their making from a level set.

mod dual_vertex;
pub mod import;
pub mod isosurface;
pub mod ply;
pub mod surface;
pub mod tree;

pub use isosurface::{Isosurface, extract};
pub use surface::SurfaceMesh;
pub use tree::FacetTree;
