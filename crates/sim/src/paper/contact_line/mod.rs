//! Section 4.3: the contact line as a mesh of particles on the surfaces of solids.
//!
//! ```text
//! level_set.rs   Algorithm 1: a level set of codimension one on the surface, by "enlarge and shrink"
//! line_mesh.rs   marching segments and triangles; repair.rs: split and collapsed edges
//! mass.rs        Eq. 3 and the lumped mass
//! plane_fit.rs   Algorithm 2
//! forces.rs      the three tangential forces of Eq. 4
//! solid_tension.rs  the tensions of the solid's own surface (E12)
//! ```

pub mod forces;
pub mod level_set;
pub mod line_mesh;
pub mod mass;
pub mod plane_fit;
pub mod repair;
pub mod solid_tension;

#[cfg(test)]
mod tests;

/// Radius `R` of the control volume of a line particle, of its samples and of its incident faces, in cells (Sections 4.3.1 and 5.2).
pub const RADIUS_CELLS: f64 = 3.0;
