//! Volumes made of simplices: triangles in 2D, tetrahedra in 3D.
//!
//! Boxes are lattices ([`block`]), flat outlines are triangulated and given a thickness ([`planar`], [`extrude`]), any
//! signed distance is filled by isosurface stuffing ([`stuffing`]), files are read ([`read`]); [`quality`] measures and
//! checks what came of it. Any of them may be of quadratic simplices, which [`quadratic`] divides into the mesh's linear ones.

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
pub use quadratic::{ElementOrder, QuadraticSimplex};
pub use quality::{MeshDefect, MeshQuality, SimplexShape};
pub use read::VolumeImportError;
pub use stuffing::{StuffingError, stuff};
pub use volume_mesh::{Simplex, VolumeMesh};
