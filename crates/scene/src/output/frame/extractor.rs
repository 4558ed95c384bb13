//! Extraction of frames from a simulation.

use super::known::VELOCITIES;
use super::volumes::{elements, fields};
use super::{Attribute, Frame, FrameMesh, FrameParts};
use crate::job::padded_to_3d;
use meniscus_numerics::grid::{CellField, Sampler};
use meniscus_numerics::mesh::{SurfaceMesh, isosurface};
use meniscus_numerics::{Vector, par};
use meniscus_sim::{ContactLine, LinePoint, LineTracker, Model, Simulation, SolidView};
use thiserror::Error;

/// Distance, in cells, up to which a vertex of the liquid's surface lies on a solid's surface or on the contact line. It is the accuracy
/// of the vertices of surface nets.
const ON_SURFACE_CELLS: f64 = 0.3;

/// Edges per cell of the mesh of wetted walls; the default of solids.
const WALL_MESH_EDGES_PER_CELL: f64 = 1.5;

/// Components of the displacement.
const DISPLACEMENT: [&str; 3] = ["ux", "uy", "uz"];

/// Components of the force on a contact line.
const LINE_FORCE: [&str; 3] = ["fx", "fy", "fz"];

/// A field of the state, or the liquid's surface, is not finite.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("the {what} is not finite")]
pub struct NotFinite {
    /// The field.
    pub what: &'static str,
}

/// Extracts frames from the states of a simulation. It has the names and the meshes of the solids.
#[derive(Clone, Debug)]
pub struct FrameExtractor<const D: usize> {
    names: Vec<String>,
    interval: f64,
    tracker: LineTracker<D>,
}

impl<const D: usize> FrameExtractor<D> {
    /// For a model whose solids have these names and these lengths of their meshes' edges, m, in the model's order, and for frames
    /// at this interval, s.
    pub fn new(model: &Model<D>, solids: &[(String, f64)], interval: f64) -> Self {
        let walls = model.wetting_wall_solid().map(|_| model.grid.dx / WALL_MESH_EDGES_PER_CELL);
        let edges: Vec<f64> = solids.iter().map(|(_, edge)| *edge).chain(walls).collect();
        let names = solids.iter().map(|(name, _)| name.clone()).collect();
        Self { names, interval, tracker: LineTracker::new(model, &edges) }
    }

    /// The contact line of the current state.
    pub fn contact_line(&self, simulation: &Simulation<D>) -> ContactLine<D> {
        self.tracker.extract(simulation)
    }

    /// The frame of the current state with its contact line, and with `parts` of it that are extracted on request only.
    ///
    /// # Errors
    /// [`NotFinite`] if a field or the liquid's surface is not finite.
    pub fn frame(
        &self,
        simulation: &Simulation<D>,
        line: &ContactLine<D>,
        parts: FrameParts,
    ) -> Result<Frame, NotFinite> {
        let Simulation { model, state, .. } = simulation;
        let solid = |(number, name): (usize, &String)| {
            let surface = self.tracker.surface(simulation.solids(), number);
            (name.clone(), solid(simulation, number, &surface, line))
        };
        let elements_of = |(number, name): (usize, &String)| {
            let found = parts.elements.then(|| elements(simulation.solid(number))).flatten()?;
            Some((name.clone(), found))
        };
        Ok(Frame {
            time: state.time,
            interval: Some(self.interval),
            unit: 1.0,
            up_axis: D - 1,
            liquid: liquid_surface(simulation)?,
            solids: self.names.iter().enumerate().map(solid).collect(),
            contact_line: (!line.points.is_empty()).then(|| contact_line(line)),
            wall_solid: model.wetting_wall_solid(),
            elements: self.names.iter().enumerate().filter_map(elements_of).collect(),
            fields: parts.fields.then(|| fields(simulation)),
        })
    }
}

/// The liquid's surface outside the solids.
///
/// # Errors
/// [`NotFinite`] if a field or the surface is not finite.
pub fn liquid_surface<const D: usize>(simulation: &Simulation<D>) -> Result<FrameMesh, NotFinite> {
    let state = &simulation.state;
    let is_finite = |values: &[f64]| par::all(values.len(), 4096, |i| values[i].is_finite());
    if !is_finite(&state.phi.data) {
        return Err(NotFinite { what: "signed distance" });
    }
    if !state.velocity.axes.iter().all(|axis| is_finite(axis)) {
        return Err(NotFinite { what: "velocity" });
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
    let mut mesh = mesh(&surface.mesh);
    if !mesh.positions.iter().flatten().all(|x| x.is_finite()) {
        return Err(NotFinite { what: "liquid's surface" });
    }
    let kind = surface.vertex_kind.into_iter().map(f64::from).collect();
    mesh.attributes.push(Attribute::known("kind", kind));
    let sampler = simulation.model.velocity_sampler(&state.velocity);
    mesh.attributes.extend(velocities(&par::map_slice(&surface.mesh.positions, 64, |x| sampler.linear(x))));
    Ok(mesh)
}

/// max(φ, -d) with the distance d to the solids, m.
fn phi_outside_solids<const D: usize>(simulation: &Simulation<D>) -> CellField<D> {
    let mut field = simulation.state.phi.clone();
    let (grid, lattice) = (simulation.model.grid, simulation.model.grid.lattice());
    par::for_each_mut(&mut field.data, 256, |i, value| {
        if *value < grid.dx {
            *value = value.max(-simulation.distance_to_solids(&grid.center(lattice.coordinates(i))));
        }
    });
    field
}

fn classify_vertices<const D: usize>(simulation: &Simulation<D>, positions: &[Vector<D>], kind: &mut [u8]) {
    if simulation.model.solids.is_empty() {
        return;
    }
    let (model, near) = (&simulation.model, ON_SURFACE_CELLS * simulation.model.grid.dx);
    let phi = Sampler::cells(&model.grid, &simulation.state.phi.data, model.scalar_boundary());
    par::for_each_mut(kind, 64, |i, kind| {
        let x = &positions[i];
        if simulation.distance_to_solids(x) < near {
            *kind = if phi.linear(x) > -near { isosurface::CONTACT_LINE } else { isosurface::LIQUID_SOLID };
        }
    });
}

/// The surface of a solid with the distance to the contact line, Young's angle where it varies, and where the solid deforms its
/// displacement and strain.
fn solid<const D: usize>(
    simulation: &Simulation<D>,
    number: usize,
    surface: &SurfaceMesh<D>,
    line: &ContactLine<D>,
) -> FrameMesh {
    let mut mesh = mesh(surface);
    let mut phi_c = line.phi_c.get(number).cloned().unwrap_or_default();
    phi_c.resize(mesh.positions.len(), 0.0);
    mesh.attributes.push(Attribute::known("phi_c", phi_c));
    mesh.attributes.extend(deformation(simulation.solid(number)));
    mesh.attributes.extend(velocities(&surface_velocities(simulation.solid(number), &surface.positions)));
    let young = young_angles(simulation, number, &surface.positions);
    if !young.is_empty() {
        mesh.attributes.push(Attribute::known("young", young));
    }
    mesh
}

/// Velocities of the vertices of a solid's surface at these positions, m/s.
fn surface_velocities<const D: usize>(solid: SolidView<'_, D>, positions: &[Vector<D>]) -> Vec<Vector<D>> {
    match solid.state.as_deformable() {
        None => positions.iter().map(|x| solid.velocity_at(x)).collect(),
        Some(body) => {
            let vertices = solid.surface.volume_vertices().iter();
            vertices.map(|v| body.vertices.velocities[*v as usize]).collect()
        }
    }
}

/// The components of velocities as attributes.
fn velocities<const D: usize>(all: &[Vector<D>]) -> [Attribute; 3] {
    let of = |a: usize| all.iter().map(|v| padded_to_3d(v)[a]).collect();
    std::array::from_fn(|a| Attribute::known(VELOCITIES[a], of(a)))
}

/// Displacement and strain of a deformable solid at the vertices of its surface; none of a rigid one.
fn deformation<const D: usize>(solid: SolidView<'_, D>) -> Vec<Attribute> {
    let Some((elastic, body)) = solid.elastic().zip(solid.state.as_deformable()) else { return Vec::new() };
    let (rest, now) = (&elastic.rest_mesh().positions, &body.vertices.positions);
    let strains = elastic.strains(now);
    let of = |value: &dyn Fn(usize) -> f64| {
        solid.surface.volume_vertices().iter().map(|v| value(*v as usize)).collect()
    };
    let mut all: Vec<Attribute> = Vec::new();
    for (a, name) in DISPLACEMENT.into_iter().enumerate() {
        let displacement = |v: usize| padded_to_3d(&(now[v] - rest[v]))[a];
        all.push(Attribute::known(name, of(&displacement)));
    }
    all.push(Attribute::known("strain", of(&|v| strains[v])));
    all
}

/// Young's angle, degrees, at points of a solid with a pattern.
fn young_angles<const D: usize>(simulation: &Simulation<D>, number: usize, points: &[Vector<D>]) -> Vec<f64> {
    let solid = simulation.solid(number);
    if solid.pattern.is_empty() {
        return Vec::new();
    }
    let cosine = |x: &Vector<D>| solid.young_cosine_near(x, simulation.model.grid.dx);
    par::map_slice(points, 16, |x| cosine(x).clamp(-1.0, 1.0).acos().to_degrees())
}

/// The contact line: vertices with angle, speed, force per length and the number of the solid; in 3D with edges.
fn contact_line<const D: usize>(line: &ContactLine<D>) -> FrameMesh {
    let of = |value: &dyn Fn(&LinePoint<D>) -> f64| line.points.iter().map(value).collect();
    let mut attributes = vec![
        Attribute::known("angle", of(&|p| p.angle_degrees)),
        Attribute::known("speed", of(&|p| p.speed)),
    ];
    for (a, name) in LINE_FORCE.into_iter().enumerate() {
        attributes.push(Attribute::known(name, of(&|p| padded_to_3d(&p.force)[a])));
    }
    attributes.push(Attribute::known("solid", of(&|p| f64::from(p.solid))));
    let positions = line.points.iter().map(|p| padded_to_3d(&p.at)).collect();
    FrameMesh { positions, triangles: Vec::new(), edges: in_order(line.segments.clone()), attributes }
}

/// Edges ordered by their first vertex, as they are in stored files.
fn in_order(mut edges: Vec<[u32; 2]>) -> Vec<[u32; 2]> {
    edges.sort_by_key(|[from, _]| *from);
    edges
}

/// A mesh without attributes.
fn mesh<const D: usize>(surface: &SurfaceMesh<D>) -> FrameMesh {
    let positions = surface.positions.iter().map(padded_to_3d).collect();
    let mut mesh = FrameMesh { positions, ..FrameMesh::default() };
    if D == 2 {
        mesh.edges = in_order(surface.facets.iter().map(|f| [f[0], f[1]]).collect());
    } else {
        mesh.triangles = surface.facets.iter().map(|f| [f[0], f[1], f[D - 1]]).collect();
    }
    mesh
}
