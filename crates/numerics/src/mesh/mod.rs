//! Surfaces made of facets: their measures, their reading, their making from a level set.

pub mod ply;
pub mod surface;

pub use surface::SurfaceMesh;
