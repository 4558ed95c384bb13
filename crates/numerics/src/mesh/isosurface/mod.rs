//! Surface mesh of the liquid: surface nets of a level set, closed at walls.

mod dual_vertex;
mod labels;
mod surface_nets;

pub use labels::{CONTACT_LINE, LIQUID_AIR, LIQUID_SOLID};
pub use surface_nets::{Isosurface, extract_isosurface};
