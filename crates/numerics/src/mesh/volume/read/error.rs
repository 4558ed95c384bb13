//! Errors of the import of volume meshes.

use crate::mesh::volume::MeshDefect;
use std::io;
use std::path::PathBuf;
use thiserror::Error;

/// Why a file cannot be used. Each message says how to repair the file.
#[derive(Debug, Error)]
pub enum VolumeImportError {
    /// The file could not be read.
    #[error("{}: cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// The extension is not that of a supported format.
    #[error("{}: {found:?} is not a format of volume meshes; use .msh (Gmsh), .node with .ele (TetGen, Triangle) or .vtk", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// Extension found.
        found: String,
    },
    /// The content does not match the file name extension.
    #[error("{}, {place}: {what}; export the mesh again (Gmsh: 4.1 or 2.2, VTK: legacy)", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// Line, or byte of a binary part.
        place: String,
        /// What is wrong.
        what: String,
    },
    /// The file has no elements of the required dimension.
    #[error("{}: the file holds no {element}; a {dimension}D solid needs them", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
        /// Missing elements: triangles or tetrahedra.
        element: &'static str,
        /// Dimension requested.
        dimension: usize,
    },
    /// An element has an unsupported type.
    #[error("{}: element {element} is {what}; mesh with {wanted} of first order", path.display())]
    Element {
        /// The file.
        path: PathBuf,
        /// Its number in the file.
        element: u64,
        /// Its type.
        what: String,
        /// Required type: triangles or tetrahedra.
        wanted: &'static str,
    },
    /// A vertex of an element does not exist or is repeated.
    #[error("{}: element {element} has a vertex that does not exist, or the same vertex twice; export the mesh again", path.display())]
    Vertex {
        /// The file.
        path: PathBuf,
        /// The element's number in the file.
        element: u64,
    },
    /// A triangle of a 2D mesh does not lie in the plane z = 0.
    #[error("{}: a vertex of element {element} has z = {z}; a mesh of a 2D scene lies in z = 0", path.display())]
    NotPlanar {
        /// The file.
        path: PathBuf,
        /// The element's number in the file.
        element: u64,
        /// The vertex' z coordinate.
        z: f64,
    },
    /// Some but not all elements are inverted.
    #[error(
        "{}: {count} of {total} elements are inverted, the first is element {element} near {near:?}; \
         repair the mesh (Gmsh: -optimize, or mesh again with another size)", path.display()
    )]
    Inverted {
        /// The file.
        path: PathBuf,
        /// Number of inverted elements.
        count: usize,
        /// Number of all elements.
        total: usize,
        /// The first one's number in the file.
        element: u64,
        /// Its centre, m.
        near: Vec<f64>,
    },
    /// Elements are degenerate: they have no volume.
    #[error(
        "{}: {count} elements have no volume, the first is element {element} near {near:?}; \
         repair the mesh (Gmsh: -optimize, or mesh again with another size)", path.display()
    )]
    Flat {
        /// The file.
        path: PathBuf,
        /// Number of degenerate elements.
        count: usize,
        /// The first one's number in the file.
        element: u64,
        /// Its centre, m.
        near: Vec<f64>,
    },
    /// The mesh as a whole cannot be used.
    #[error("{}: {defect} (vertices are numbered without unused ones); mesh the solid again", path.display())]
    Defect {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        defect: MeshDefect,
    },
}
