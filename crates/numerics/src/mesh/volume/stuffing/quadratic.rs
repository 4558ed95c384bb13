//! Meshing of regions with quadratic simplices whose boundary nodes lie on the surface.

use crate::Vector;
use crate::mesh::volume::VolumeMesh;
use crate::mesh::volume::quadratic::{ElementOrder, MAX_NODE_DISPLACEMENT_EDGES};
use crate::mesh::volume::stuffing::isosurface_stuffing::surface_crossing;
use crate::mesh::volume::stuffing::{Distance, StuffingError, stuff};

/// Largest fraction of the linear mesh's volume that quadratic simplices of twice the size may lose. A solid's mass and its
/// stiffness in tension fall by the same fraction.
const MAX_VOLUME_LOSS: f64 = 0.05;

/// As [`stuff`], for simplices of the given order with vertices about `edge` (m) apart. Quadratic simplices are twice as large as
/// linear ones. If that loses thin parts, they are of the same size and vertices are closer.
///
/// # Errors
/// As [`stuff`].
pub fn stuff_with_order<const D: usize>(
    order: ElementOrder,
    distance: &Distance<D>,
    lower: &Vector<D>,
    upper: &Vector<D>,
    edge: f64,
) -> Result<VolumeMesh<D>, StuffingError> {
    let linear = stuff(distance, lower, upper, edge)?;
    if order == ElementOrder::Linear {
        return Ok(linear);
    }
    let large = stuff(distance, lower, upper, 2.0 * edge).map(|mesh| mesh.subdivided_onto(distance));
    match large {
        Ok(mesh) if mesh.volume() >= (1.0 - MAX_VOLUME_LOSS) * linear.volume() => Ok(mesh),
        _ => Ok(linear.subdivided_onto(distance)),
    }
}

impl<const D: usize> VolumeMesh<D> {
    /// As [`subdivided`](Self::subdivided), with the nodes on boundary edges moved onto the zero set of a signed distance (m) where
    /// simplices stay well shaped.
    pub fn subdivided_onto(&self, distance: &Distance<D>) -> Self {
        let moved = |(edge, normal): ([u32; 2], Vector<D>)| {
            let [a, b] = edge.map(|v| self.position(v));
            let middle = (a + b) * 0.5;
            let place = surface_crossing(
                &middle,
                &(normal * (MAX_NODE_DISPLACEMENT_EDGES * (b - a).norm())),
                distance,
            )?;
            Some((edge, place - middle))
        };
        let shifts: Vec<([u32; 2], Vector<D>)> =
            self.boundary_edges().into_iter().filter_map(moved).collect();
        self.subdivided_curved(&shifts)
    }
}
