//! The invariants and their checks after every step.

pub mod energy;
pub mod invariant_checks;
pub mod invariants;
