//! Regions given by a signed distance, filled with simplices of good shape.

mod of_shape;
mod quadratic;
mod simplices;

pub use quadratic::stuff_with_order;
pub use simplices::{Distance, StuffingError, stuff};
