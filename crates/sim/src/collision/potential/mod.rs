//! The incremental potential of a step, with the terms of each solid and those between solids.

pub mod barrier;
pub mod dashpot;
pub mod friction;
pub mod incremental_potential;
pub mod slips;
pub mod solid_terms;
pub mod stored_energy;
pub mod term;
pub mod time_levels;
