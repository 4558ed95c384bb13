//! Regions filled with quadratic simplices, whose nodes lie on the surface.

use crate::Vector;
use crate::mesh::volume::VolumeMesh;
use crate::mesh::volume::quadratic::{ElementOrder, MAX_NODE_DISPLACEMENT_EDGES};
use crate::mesh::volume::stuffing::isosurface_stuffing::surface_crossing;
use crate::mesh::volume::stuffing::{Distance, StuffingError, stuff};

/// Part of a volume that large quadratic simplices may lose of what linear ones have with the same vertices: that of a solid's mass
/// and of its stiffness against being pulled.
const MAX_VOLUME_LOSS: f64 = 0.05;

/// As [`stuff`], of simplices of an order, with vertices about `edge` (m) apart. Quadratic simplices are twice as large, unless that
/// loses what is thin: then they are not, and vertices are nearer to each other.
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
    /// As [`subdivided`](Self::divided), with the nodes on the boundary's edges moved onto the surface of a signed distance (m), as far
    /// as simplices stay well shaped.
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
