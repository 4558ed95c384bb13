//! Volume meshes of simplices: triangles in 2D, tetrahedra in 3D.
//!
//! Boxes are lattices ([`block`]). Flat outlines are triangulated and extruded ([`planar`], [`extrude`]). Regions with a
//! signed distance are filled by isosurface stuffing ([`stuffing`]). Files are imported ([`read`]). [`quality`] measures and
//! checks a mesh. Every mesh can have quadratic simplices, which [`quadratic`] divides into the mesh's linear ones.

pub mod block;
pub mod extrude;
pub mod outline;
pub mod planar;
pub mod quadratic;
pub mod quality;
pub mod read;
pub mod stuffing;
mod volume_mesh;

pub use block::BlockError;
pub use outline::{Outline, OutlineError};
pub use planar::PlanarTriangulation;
pub use quadratic::{ElementOrder, QuadraticFacet, QuadraticSimplex};
pub use quality::{MeshDefect, MeshQuality, SimplexShape};
pub use read::VolumeImportError;
pub use stuffing::{StuffingError, stuff};
pub use volume_mesh::{Simplex, VolumeMesh};
