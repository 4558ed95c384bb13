//! What every step is compared with.

pub mod books;
pub mod energy;
pub mod invariants;
