//! Contours and geodesic distances on surface meshes.

mod contour;
mod geodesic;

pub use contour::{Contour, ContourPoint};
pub use geodesic::Geodesic;
