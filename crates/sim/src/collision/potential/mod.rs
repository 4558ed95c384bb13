//! The incremental potential of a step, and its terms between solids.

pub mod barrier;
pub mod dashpot;
pub mod friction;
pub mod incremental_potential;
pub mod slips;
pub mod stored_energy;
pub mod term;
pub mod time_levels;
