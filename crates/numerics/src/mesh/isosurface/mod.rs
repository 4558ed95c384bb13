//! The liquid's surface as a mesh: surface nets of a distance, cut at solids.

mod dual_vertex;
mod labels;
mod surface_nets;

pub use labels::{CONTACT_LINE, LIQUID_AIR, LIQUID_SOLID};
pub use surface_nets::{Isosurface, extract_isosurface};
