//! A frame: the liquid's surface as a PLY file.

use super::file::{self, FileError};
use crate::run::three;
use meniscus_numerics::mesh::isosurface;
use meniscus_numerics::mesh::ply::PlyMesh;
use meniscus_sim::Simulation;
use rayon::prelude::*;
use std::path::Path;

/// The liquid's surface of a state; `Err` names a field that is not finite.
///
/// # Errors
/// The name of the field.
pub fn liquid<const D: usize>(simulation: &Simulation<D>) -> Result<PlyMesh, &'static str> {
    let state = &simulation.state;
    if !state.phi.data.par_iter().all(|v| v.is_finite()) {
        return Err("signed distance");
    }
    if !state.velocity.axes.iter().all(|axis| axis.par_iter().all(|v| v.is_finite())) {
        return Err("velocity");
    }
    let surface = isosurface::extract(&state.phi, simulation.liquid_cells());
    let positions: Vec<[f64; 3]> = surface.mesh.positions.iter().map(three).collect();
    if !positions.iter().flatten().all(|x| x.is_finite()) {
        return Err("liquid's surface");
    }
    let mut mesh = PlyMesh { positions, ..PlyMesh::default() };
    if D == 2 {
        mesh.edges = surface.mesh.facets.iter().map(|f| [f[0], f[1]]).collect();
    } else {
        mesh.faces = surface.mesh.facets.iter().map(|f| [f[0], f[1], f[D - 1]]).collect();
    }
    mesh.scalars.insert("kind".into(), surface.kind.into_iter().map(f64::from).collect());
    mesh.comments = vec![
        concat!("Meniscus ", env!("CARGO_PKG_VERSION")).into(),
        format!("time {:?}", state.time),
        "unit metre; kind 0 liquid-air, 1 liquid-solid, 2 contact line".into(),
    ];
    Ok(mesh)
}

/// Writes a mesh.
///
/// # Errors
/// [`FileError`].
pub fn write(path: &Path, mesh: &PlyMesh) -> Result<(), FileError> {
    file::replace(path, |writer| mesh.write(writer))
}
