//! Reading volume meshes from files: Gmsh `.msh` (2.2 and 4.1), TetGen and Triangle `.node` with `.ele`, VTK legacy `.vtk`;
//! tetrahedra in 3D, triangles in 2D. Gmsh and VTK files may be text or binary. Coordinates are taken as metres.
//!
//! Elements of lower dimension (the sides of a Gmsh mesh) are passed over, vertices that no element has are dropped, and if
//! all elements are inverted they are turned: then the file counts the other way around.

mod gmsh;
mod reader;
mod tetgen;
mod vtk;

use super::{MeshDefect, Simplex, VolumeMesh};
use crate::Vector;
use reader::Fault;
use std::io;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Volume of an element over the power of its longest edge below which it is flat.
const FLAT: f64 = 1e-9;

/// Why a file cannot be used. Each message says how to mend the file.
#[derive(Debug, Error)]
pub enum VolumeImportError {
    /// The file could not be read.
    #[error("{}: cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The name's ending is not that of a format read here.
    #[error("{}: {found:?} is no volume mesh; use .msh (Gmsh), .node with .ele (TetGen, Triangle) or .vtk", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// The ending found.
        found: String,
    },
    /// The file is not what its name says.
    #[error("{}, {place}: {what}; export the mesh again (Gmsh: 4.1 or 2.2, VTK: legacy)", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// The line, or the byte of a binary part.
        place: String,
        /// What is wrong.
        what: String,
    },
    /// There is nothing in it.
    #[error("{}: holds no {element}; a {dimension}D solid needs them", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
        /// What is missing: triangles or tetrahedra.
        element: &'static str,
        /// Dimension asked for.
        dimension: usize,
    },
    /// An element is not one that is read here.
    #[error("{}: element {element} is {what}; mesh with {wanted} of first order", path.display())]
    Element {
        /// The file.
        path: PathBuf,
        /// Its number in the file.
        element: u64,
        /// What it is.
        what: String,
        /// What is wanted: triangles or tetrahedra.
        wanted: &'static str,
    },
    /// A vertex of an element does not exist, or is there twice.
    #[error("{}: element {element} has a vertex that does not exist, or the same one twice; export again", path.display())]
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
        /// The vertex' z.
        z: f64,
    },
    /// Some elements are inverted, others not.
    #[error(
        "{}: {count} of {total} elements are inverted, the first is element {element} near {near:?}; \
         mend the mesh (Gmsh: -optimize, or mesh again with another size)", path.display()
    )]
    Inverted {
        /// The file.
        path: PathBuf,
        /// How many.
        count: usize,
        /// Of how many.
        total: usize,
        /// Number of the first in the file.
        element: u64,
        /// Its centre, m.
        near: Vec<f64>,
    },
    /// Elements are flat.
    #[error(
        "{}: {count} elements have no volume, the first is element {element} near {near:?}; \
         mend the mesh (Gmsh: -optimize, or mesh again with another size)", path.display()
    )]
    Flat {
        /// The file.
        path: PathBuf,
        /// How many.
        count: usize,
        /// Number of the first in the file.
        element: u64,
        /// Its centre, m.
        near: Vec<f64>,
    },
    /// The mesh as a whole cannot be used.
    #[error("{}: {defect} (vertices by number without unused ones); mesh again", path.display())]
    Defect {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        defect: MeshDefect,
    },
}

/// What a file holds.
#[derive(Default)]
struct Raw {
    /// Coordinates of the vertices.
    points: Vec<[f64; 3]>,
    /// Elements: number in the file, places of the vertices in `points`.
    elements: Vec<(u64, Vec<u32>)>,
}

/// What is done with an element of a kind.
enum Kind {
    /// It is a simplex of the mesh's dimension.
    Taken,
    /// It has a lower dimension.
    Passed,
    /// It cannot be used; its name.
    Refused(&'static str),
}

/// Reads a mesh, checked; positions in m. It may fall into parts that no facet joins.
///
/// # Errors
/// What the file lacks and how to mend it.
pub fn load<const D: usize>(path: &Path) -> Result<VolumeMesh<D>, VolumeImportError> {
    let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    let bytes = |path: &Path| {
        std::fs::read(path).map_err(|source| VolumeImportError::Read { path: path.into(), source })
    };
    let (read, at) = match ending.as_str() {
        "msh" => (gmsh::read::<D>(&bytes(path)?), path.to_owned()),
        "vtk" => (vtk::read::<D>(&bytes(path)?), path.to_owned()),
        "node" | "ele" => {
            let [nodes, elements] = ["node", "ele"].map(|e| path.with_extension(e));
            match tetgen::nodes::<D>(&bytes(&nodes)?) {
                Ok(read) => (tetgen::elements::<D>(&bytes(&elements)?, read), elements),
                Err(fault) => (Err(fault), nodes),
            }
        }
        _ => return Err(VolumeImportError::Format { path: path.into(), found: ending }),
    };
    let raw = read.map_err(|fault| match fault {
        Fault::Content { place, what } => VolumeImportError::Content { path: at.clone(), place, what },
        Fault::Element { element, what } => {
            VolumeImportError::Element { path: at.clone(), element, what, wanted: wanted::<D>() }
        }
        Fault::Vertex { element } => VolumeImportError::Vertex { path: at.clone(), element },
    })?;
    from_raw(&at, &raw)
}

/// What elements are called.
fn wanted<const D: usize>() -> &'static str {
    if D == 2 { "triangles" } else { "tetrahedra" }
}

/// Checks what a file holds and makes a mesh of it.
fn from_raw<const D: usize>(path: &Path, raw: &Raw) -> Result<VolumeMesh<D>, VolumeImportError> {
    let path = || path.to_owned();
    if raw.elements.is_empty() {
        return Err(VolumeImportError::Empty { path: path(), element: wanted::<D>(), dimension: D });
    }
    let positions = raw.points.iter().map(|p| Vector::from_fn(|a, _| p[a])).collect();
    let mut mesh = VolumeMesh::<D> { positions, simplices: Vec::with_capacity(raw.elements.len()) };
    for (element, v) in &raw.elements {
        let repeated = (0..v.len()).any(|i| v[..i].contains(&v[i]));
        if v.len() != D + 1 || repeated || v.iter().any(|v| *v as usize >= raw.points.len()) {
            return Err(VolumeImportError::Vertex { path: path(), element: *element });
        }
        for p in v.iter().map(|v| &raw.points[*v as usize]).filter(|_| D == 2) {
            if p[2].abs() > 1e-6 * (p[0].abs() + p[1].abs()) {
                return Err(VolumeImportError::NotPlanar { path: path(), element: *element, z: p[2] });
            }
        }
        mesh.simplices.push(Simplex { root: v[0], rest: std::array::from_fn(|k| v[k + 1]) });
    }
    orient(&mut mesh, &raw.elements, &path)?;
    let mesh = mesh.compacted();
    mesh.check_pieces().map_err(|defect| VolumeImportError::Defect { path: path(), defect })?;
    Ok(mesh)
}

/// Turns all elements if all are inverted; refuses some that are, and flat ones.
fn orient<const D: usize>(
    mesh: &mut VolumeMesh<D>,
    elements: &[(u64, Vec<u32>)],
    path: &dyn Fn() -> PathBuf,
) -> Result<(), VolumeImportError> {
    let positions = &mesh.positions;
    let relative = |s: &Simplex<D>| {
        let longest = s.vertices().flat_map(|v| s.vertices().map(move |w| (v, w)));
        let longest = longest.map(|(v, w)| (positions[v as usize] - positions[w as usize]).norm());
        s.volume(positions) / longest.fold(0.0, f64::max).powi(D as i32)
    };
    let volumes: Vec<f64> = mesh.simplices.iter().map(relative).collect();
    let near = |i: usize| mesh.simplices[i].center(positions).as_slice().to_vec();
    let is_flat = |v: f64| v.is_nan() || v.abs() < FLAT;
    let flat: Vec<usize> = (0..volumes.len()).filter(|i| is_flat(volumes[*i])).collect();
    if let Some(first) = flat.first() {
        let (element, near) = (elements[*first].0, near(*first));
        return Err(VolumeImportError::Flat { path: path(), count: flat.len(), element, near });
    }
    let inverted: Vec<usize> = (0..volumes.len()).filter(|i| volumes[*i] < 0.0).collect();
    if inverted.len() == volumes.len() {
        mesh.simplices.iter_mut().for_each(|s| s.rest.swap(0, 1));
    } else if let Some(first) = inverted.first() {
        let (count, total) = (inverted.len(), volumes.len());
        let (element, near) = (elements[*first].0, near(*first));
        return Err(VolumeImportError::Inverted { path: path(), count, total, element, near });
    }
    Ok(())
}

#[cfg(test)]
#[path = "read_tests.rs"]
mod tests;
