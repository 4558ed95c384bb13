//! Meshing of regions given by a signed distance with well-shaped simplices.

mod isosurface_stuffing;
mod of_shape;
mod quadratic;

pub use isosurface_stuffing::{Distance, StuffingError, stuff};
pub use quadratic::stuff_with_order;
