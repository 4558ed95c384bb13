//! Regions given by a signed distance, filled with simplices of good shape.

mod isosurface_stuffing;
mod of_shape;
mod quadratic;

pub use isosurface_stuffing::{Distance, StuffingError, stuff};
pub use quadratic::stuff_with_order;
