//! A frame: the surfaces of the liquid and of the solids and the contact line as PLY files.

use super::atomic_file::{self, FileError};
use crate::job::padded_to_3d;
use meniscus_elastic::Elastic;
use meniscus_numerics::Vector;
use meniscus_numerics::grid::{CellField, Sampler};
use meniscus_numerics::mesh::ply::PlyMesh;
use meniscus_numerics::mesh::{SurfaceMesh, isosurface};
use meniscus_sim::{ContactLine, LinePoint, Simulation, Soft};
use rayon::prelude::*;
use std::path::Path;

/// Distance, in cells, up to which a vertex of the liquid's surface lies on a solid's surface or on the contact line. It is the accuracy
/// of the vertices of surface nets.
const ON_SURFACE_CELLS: f64 = 0.3;

/// Components of the displacement.
const DISPLACEMENT: [&str; 3] = ["ux", "uy", "uz"];

/// The liquid's surface outside the solids.
///
/// # Errors
/// The name of a field that is not finite.
pub fn liquid<const D: usize>(simulation: &Simulation<D>) -> Result<PlyMesh, &'static str> {
    let state = &simulation.state;
    if !state.phi.data.par_iter().all(|v| v.is_finite()) {
        return Err("signed distance");
    }
    if !state.velocity.axes.iter().all(|axis| axis.par_iter().all(|v| v.is_finite())) {
        return Err("velocity");
    }
    let mut surface = match simulation.model.solids.is_empty() {
        true => isosurface::extract_isosurface(&state.phi, simulation.liquid_cells()),
        false => {
            let outside = phi_outside_solids(simulation);
            let cells = simulation.liquid_cells().clone();
            let cells = cells.filtered(&simulation.model.grid, |c| outside.data[c] < 0.0);
            isosurface::extract_isosurface(&outside, &cells)
        }
    };
    classify_vertices(simulation, &surface.mesh.positions, &mut surface.vertex_kind);
    let mut mesh = ply(&surface.mesh, state.time);
    if !mesh.positions.iter().flatten().all(|x| x.is_finite()) {
        return Err("liquid's surface");
    }
    mesh.scalars.insert("kind".into(), surface.vertex_kind.into_iter().map(f64::from).collect());
    mesh.comments.push("kind 0 liquid-air, 1 liquid-solid, 2 contact line".into());
    Ok(mesh)
}

/// max(φ, -d) with the distance d to the solids, m.
fn phi_outside_solids<const D: usize>(simulation: &Simulation<D>) -> CellField<D> {
    let mut field = simulation.state.phi.clone();
    let (grid, lattice) = (simulation.model.grid, simulation.model.grid.lattice());
    field.data.par_iter_mut().enumerate().filter(|(_, v)| **v < grid.dx).for_each(|(i, value)| {
        *value = value.max(-simulation.distance_to_solids(&grid.center(lattice.coordinates(i))));
    });
    field
}

fn classify_vertices<const D: usize>(simulation: &Simulation<D>, positions: &[Vector<D>], kind: &mut [u8]) {
    if simulation.model.solids.is_empty() {
        return;
    }
    let (model, near) = (&simulation.model, ON_SURFACE_CELLS * simulation.model.grid.dx);
    let phi = Sampler::cells(&model.grid, &simulation.state.phi.data, model.scalar_boundary());
    positions.par_iter().zip(kind).for_each(|(x, kind)| {
        if simulation.distance_to_solids(x) < near {
            *kind = if phi.linear(x) > -near { isosurface::CONTACT_LINE } else { isosurface::LIQUID_SOLID };
        }
    });
}

/// The surface of a solid with the distance to the contact line, Young's angle where it varies, and where the solid deforms its
/// displacement and strain.
pub fn solid<const D: usize>(
    simulation: &Simulation<D>,
    number: usize,
    surface: &SurfaceMesh<D>,
    line: &ContactLine<D>,
) -> PlyMesh {
    let young = young_angles(simulation, number, &surface.positions);
    let mut mesh = ply(surface, simulation.state.time);
    let distance = line.phi_c.get(number).cloned().unwrap_or_default();
    mesh.scalars.insert("phi_c".into(), distance);
    mesh.comments.push("phi_c distance to the contact line along the surface, negative where wetted".into());
    if let Some((elastic, soft)) = soft_state(simulation, number) {
        let (rest, strains) = (&elastic.rest_mesh().positions, elastic.strains(&soft.state.positions));
        let of = |value: &dyn Fn(usize) -> f64| {
            soft.surface.volume_vertices().iter().map(|v| value(*v as usize)).collect()
        };
        for (a, name) in DISPLACEMENT.into_iter().enumerate() {
            let displacement = |v: usize| padded_to_3d(&(soft.state.positions[v] - rest[v]))[a];
            mesh.scalars.insert(name.into(), of(&displacement));
        }
        mesh.scalars.insert("strain".into(), of(&|v| strains[v]));
        mesh.comments.push("ux uy uz way from the place at rest, strain largest |stretch - 1|".into());
    }
    if !young.is_empty() {
        mesh.scalars.insert("young".into(), young);
        mesh.comments.push("young contact angle at rest in degrees".into());
    }
    mesh
}

/// A deformable solid and its state.
fn soft_state<const D: usize>(simulation: &Simulation<D>, number: usize) -> Option<(&Elastic<D>, &Soft<D>)> {
    let soft = simulation.state.solids[number].soft.as_ref();
    simulation.model.solids[number].elastic().zip(soft)
}

/// Young's angle, degrees, at points of a solid with a pattern.
fn young_angles<const D: usize>(simulation: &Simulation<D>, number: usize, points: &[Vector<D>]) -> Vec<f64> {
    let (solid, now) = (&simulation.model.solids[number], &simulation.state.solids[number]);
    if solid.pattern.is_empty() {
        return Vec::new();
    }
    let cosine = |x: &Vector<D>| solid.young_cosine_near(now, x, simulation.model.grid.dx);
    points.par_iter().map(|x| cosine(x).clamp(-1.0, 1.0).acos().to_degrees()).collect()
}

/// The contact line: vertices with angle, speed, force per length and the number of the solid (the walls of the domain follow the last
/// solid); in 3D with edges.
pub fn contact_line<const D: usize>(simulation: &Simulation<D>, line: &ContactLine<D>) -> PlyMesh {
    let mut mesh = ply(&SurfaceMesh::<D>::default(), simulation.state.time);
    mesh.positions = line.points.iter().map(|p| padded_to_3d(&p.at)).collect();
    mesh.edges = line.segments.clone();
    let mut put = |name: &str, value: &dyn Fn(&LinePoint<D>) -> f64| {
        mesh.scalars.insert(name.into(), line.points.iter().map(value).collect());
    };
    put("angle", &|p| p.angle_degrees);
    put("speed", &|p| p.speed);
    for (a, name) in ["fx", "fy", "fz"].into_iter().enumerate() {
        put(name, &|p| padded_to_3d(&p.force)[a]);
    }
    put("solid", &|p| f64::from(p.solid));
    mesh.comments.push("angle in degrees through the liquid, speed in m/s, force in N/m".into());
    if let Some(walls) = simulation.model.wetting_wall_solid() {
        mesh.comments.push(format!("solid {walls} are the walls of the domain"));
    }
    mesh
}

fn ply<const D: usize>(surface: &SurfaceMesh<D>, time: f64) -> PlyMesh {
    let positions = surface.positions.iter().map(padded_to_3d).collect();
    let mut mesh = PlyMesh { positions, ..PlyMesh::default() };
    if D == 2 {
        mesh.edges = surface.facets.iter().map(|f| [f[0], f[1]]).collect();
    } else {
        mesh.faces = surface.facets.iter().map(|f| [f[0], f[1], f[D - 1]]).collect();
    }
    mesh.comments = vec![
        concat!("Meniscus ", env!("CARGO_PKG_VERSION")).into(),
        format!("time {time:?}"),
        "unit metre".into(),
    ];
    mesh
}

/// Writes a mesh.
///
/// # Errors
/// [`FileError`].
pub fn write(path: &Path, mesh: &PlyMesh) -> Result<(), FileError> {
    atomic_file::write_atomically(path, |writer| mesh.write(writer))
}
