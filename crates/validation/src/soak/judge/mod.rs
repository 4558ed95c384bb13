//! What every step is compared with.

pub mod energy;
pub mod invariant_checks;
pub mod invariants;
