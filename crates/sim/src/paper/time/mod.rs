//! Section 6: time integration.
//!
//! ```text
//! scheme.rs     what is fixed: parameters, surfaces of rigid solids;   state.rs  what evolves
//! geometry.rs   types, surfaces and W_s of a state;   transport.rs  advection, redistancing, extension of velocities
//! start.rs      the state at the start;   solves.rs  the three solves;   line.rs  the contact line
//! step.rs       the seven steps
//! ```

pub mod geometry;
pub mod line;
pub mod scheme;
pub mod solves;
pub mod start;
pub mod state;
pub mod step;
pub mod transport;

#[cfg(test)]
mod tests;
