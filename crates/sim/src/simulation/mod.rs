//! A simulation: what it is, one step of it, and what it reports.

pub mod diagnostics;
pub mod dimension;
pub mod driver;
pub mod step;
pub mod workspace;

pub use driver::{LiquidRegion, Simulation, StepError};
