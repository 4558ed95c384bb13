//! Surfaces made of facets: their measures, their reading, their making from a level set.

mod contour;
mod dual_vertex;
mod geodesic;
pub mod icosphere;
pub mod import;
pub mod isosurface;
pub mod ply;
mod remesh;
mod shape_surface;
pub mod surface;
pub mod tree;
pub mod volume;

pub use contour::{Contour, ContourPoint};
pub use geodesic::Geodesic;
pub use isosurface::{Isosurface, extract};
pub use shape_surface::ShapeSurface;
pub use surface::SurfaceMesh;
pub use tree::FacetTree;
pub use volume::{Simplex, VolumeMesh};
