//! Import of volume meshes: Gmsh `.msh` (2.2 and 4.1), TetGen and Triangle `.node` with `.ele`, VTK legacy `.vtk`;
//! tetrahedra in 3D, triangles in 2D. Gmsh and VTK files may be text or binary. Coordinates are in metres.
//!
//! Elements of lower dimension (the boundary in a Gmsh mesh) are skipped, and unused vertices are dropped. If all elements
//! are inverted, they are reversed: the file uses the opposite vertex order.

use super::reader::ReadFault;
use crate::Vector;
use crate::mesh::io::ReadFile;
use crate::mesh::volume::read::error::VolumeImportError;
use crate::mesh::volume::read::raw_mesh::RawMesh;
use crate::mesh::volume::{Simplex, VolumeMesh};
use std::path::{Path, PathBuf};

/// Volume of an element, over the power `D` of its longest edge, below which it is degenerate.
const MIN_RELATIVE_VOLUME: f64 = 1e-9;

/// Reads and checks a mesh; positions in m. It may have several components. `read` gives the content of a file.
///
/// # Errors
/// The file cannot be read or used; the message says how to repair it.
pub fn load<const D: usize>(path: &Path, read: ReadFile) -> Result<VolumeMesh<D>, VolumeImportError> {
    let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    let bytes =
        |path: &Path| read(path).map_err(|source| VolumeImportError::Read { path: path.into(), source });
    let (read, at) = match ending.as_str() {
        "msh" => (super::gmsh::read::<D>(&bytes(path)?), path.to_owned()),
        "vtk" => (super::vtk::read::<D>(&bytes(path)?), path.to_owned()),
        "node" | "ele" => {
            let [nodes, elements] = ["node", "ele"].map(|e| path.with_extension(e));
            match super::tetgen::nodes::<D>(&bytes(&nodes)?) {
                Ok(read) => (super::tetgen::elements::<D>(&bytes(&elements)?, read), elements),
                Err(fault) => (Err(fault), nodes),
            }
        }
        _ => return Err(VolumeImportError::Format { path: path.into(), found: ending }),
    };
    let raw = read.map_err(|fault| match fault {
        ReadFault::Content { place, what } => VolumeImportError::Content { path: at.clone(), place, what },
        ReadFault::Element { element, what } => {
            VolumeImportError::Element { path: at.clone(), element, what, wanted: element_name::<D>() }
        }
        ReadFault::Vertex { element } => VolumeImportError::Vertex { path: at.clone(), element },
    })?;
    from_raw(&at, &raw)
}

/// Name of the elements.
fn element_name<const D: usize>() -> &'static str {
    if D == 2 { "triangles" } else { "tetrahedra" }
}

/// Checks the content of a file and makes a mesh of it.
fn from_raw<const D: usize>(path: &Path, raw: &RawMesh) -> Result<VolumeMesh<D>, VolumeImportError> {
    let path = || path.to_owned();
    if raw.elements.is_empty() {
        return Err(VolumeImportError::Empty { path: path(), element: element_name::<D>(), dimension: D });
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
        mesh.simplices.push(Simplex { root: v[0], others: std::array::from_fn(|k| v[k + 1]) });
    }
    orient(&mut mesh, &raw.elements, &path)?;
    let mesh = mesh.compacted();
    mesh.check_elements().map_err(|defect| VolumeImportError::Defect { path: path(), defect })?;
    Ok(mesh)
}

/// Reverses all elements if all are inverted; rejects meshes with some inverted or degenerate elements.
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
    let is_flat = |v: f64| v.is_nan() || v.abs() < MIN_RELATIVE_VOLUME;
    let flat: Vec<usize> = (0..volumes.len()).filter(|i| is_flat(volumes[*i])).collect();
    if let Some(first) = flat.first() {
        let (element, near) = (elements[*first].0, near(*first));
        return Err(VolumeImportError::Flat { path: path(), count: flat.len(), element, near });
    }
    let inverted: Vec<usize> = (0..volumes.len()).filter(|i| volumes[*i] < 0.0).collect();
    if inverted.len() == volumes.len() {
        mesh.simplices.iter_mut().for_each(|s| s.others.swap(0, 1));
    } else if let Some(first) = inverted.first() {
        let (count, total) = (inverted.len(), volumes.len());
        let (element, near) = (elements[*first].0, near(*first));
        return Err(VolumeImportError::Inverted { path: path(), count, total, element, near });
    }
    Ok(())
}

#[cfg(test)]
#[path = "load_tests.rs"]
mod tests;
