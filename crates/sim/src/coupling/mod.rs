//! What liquid and solids give each other in a step: impulses of the pressure and of contact lines, and the solve of both together.

pub mod impulses;
pub mod pressure;
pub mod solve;
