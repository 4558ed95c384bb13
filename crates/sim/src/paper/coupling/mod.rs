//! Section 5: liquid, solids and contact line in one system.
//!
//! ```text
//! solid_map.rs    W_s: velocities of surface vertices → faces;   line_map.rs  W_c: velocities of line particles → faces
//! solids.rs       unknowns of the solids, M_s and D_s
//! momentum.rs     the momentum rows of Eq. 10 and Eqs. 12 to 14
//! system.rs       Eqs. 11 and 15
//! solver.rs       conjugate gradients as in the paper, and MINRES
//! ```

pub mod line_map;
pub mod momentum;
pub mod solid_map;
pub mod solids;
pub mod solver;
pub mod sparse_matrix;
pub mod system;

#[cfg(test)]
mod tests;
