//! Coupling of liquid and solids in a step: impulses of pressure and contact lines, and the joint solve.

pub mod impulses;
pub mod pressure;
pub mod solve;
