//! Surface meshes and volume meshes: measures, file input and output, extraction from a level set.

pub mod bvh;
pub mod icosphere;
pub mod io;
pub mod isosurface;
mod on_surface;
mod remesh;
mod shape_surface;
pub mod surface;
pub mod volume;

pub use bvh::FacetBvh;
pub use io::{import, ply};
pub use isosurface::{Isosurface, extract_isosurface};
pub use on_surface::{Contour, ContourPoint, Geodesic};
pub use shape_surface::ShapeSurface;
pub use surface::SurfaceMesh;
pub use volume::{Simplex, VolumeMesh};
