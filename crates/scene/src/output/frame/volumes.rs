//! Extraction of the optional parts of frames: elements of deformable solids, and fields on the grid.

use super::{Attribute, FrameElements, FrameFields};
use crate::job::padded_to_3d;
use meniscus_numerics::mesh::Simplex;
use meniscus_numerics::{Matrix, Vector, par};
use meniscus_sim::{Simulation, SolidView};

/// The elements of a solid with displacement, velocity, strain and stress; `None` of a rigid one.
pub(super) fn elements<const D: usize>(solid: SolidView<'_, D>) -> Option<FrameElements> {
    let (elastic, body) = solid.elastic().zip(solid.state.as_deformable())?;
    let (mesh, now) = (elastic.rest_mesh(), &body.vertices.positions);
    let displacement = mesh.positions.iter().zip(now).flat_map(|(rest, x)| padded_to_3d(&(x - rest)));
    let velocity = body.vertices.velocities.iter().flat_map(padded_to_3d);
    let numbers = |s: &Simplex<D>| {
        let vertices: Vec<u32> = s.vertices().collect();
        std::array::from_fn(|k| vertices[k.min(D)])
    };
    let mut at_vertices = vec![
        Attribute::new("displacement", "m", "displacement from the position at rest", displacement.collect()),
        Attribute::new("velocity", "m/s", "velocity", velocity.collect()),
        Attribute::new("strain", "1", "largest |stretch - 1|", elastic.strains(now)),
    ];
    if let Some(stresses) = elastic.cauchy_stresses(now) {
        let values = stresses.iter().flat_map(padded_tensor).collect();
        at_vertices.push(Attribute::new("stress", "Pa", "Cauchy stress", values));
    }
    let strains = elastic.green_strains(now).iter().flat_map(padded_tensor).collect();
    Some(FrameElements {
        positions: now.iter().map(padded_to_3d).collect(),
        simplices: mesh.simplices.iter().map(numbers).collect(),
        are_triangles: D == 2,
        at_vertices,
        at_elements: vec![Attribute::new("green_strain", "1", "Green strain (F^T F - 1) / 2", strains)],
    })
}

/// A tensor with three rows and columns, row after row; missing entries are 0.
fn padded_tensor<const D: usize>(tensor: &Matrix<D>) -> [f64; 9] {
    std::array::from_fn(|k| if k / 3 < D && k % 3 < D { tensor[(k / 3, k % 3)] } else { 0.0 })
}

/// φ, velocity and pressure at the centres of all cells, those of a margin around the domain included.
pub(super) fn fields<const D: usize>(simulation: &Simulation<D>) -> FrameFields {
    let Simulation { model, state, .. } = simulation;
    let (grid, lattice) = (model.grid, model.grid.lattice());
    let velocity = |cell: usize| {
        let at = lattice.coordinates(cell);
        padded_to_3d(&Vector::<D>::from_fn(|a, _| {
            let faces = grid.face_lattice(a);
            let next = std::array::from_fn(|b| at[b] + usize::from(a == b));
            0.5 * (state.velocity.axes[a][faces.index(at)] + state.velocity.axes[a][faces.index(next)])
        }))
    };
    // There is no pressure before the first step.
    let has_pressure = state.impulse_time > 0.0;
    let pressure = |cell| if has_pressure { state.pressure(model.density, cell) } else { 0.0 };
    let cells = lattice.len();
    let velocities = par::map(cells, 256, velocity);
    let unit = if D == 2 { "N/m" } else { "Pa" };
    FrameFields {
        extent: std::array::from_fn(|a| lattice.extent.get(a).copied().unwrap_or(1)),
        first: padded_to_3d(&grid.center([0; D])),
        dx: grid.dx,
        attributes: vec![
            Attribute::new(
                "phi",
                "m",
                "signed distance to the liquid's surface, negative in the liquid",
                state.phi.data.clone(),
            ),
            Attribute::new(
                "velocity",
                "m/s",
                "velocity of the liquid, continued around it",
                velocities.concat(),
            ),
            Attribute::new("pressure", unit, "pressure of the liquid", (0..cells).map(pressure).collect()),
        ],
    }
}
