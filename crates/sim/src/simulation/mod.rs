//! A simulation: what it is, one step of it, and what it reports.

pub mod diagnostics;
pub mod dimension;
pub mod step;
pub mod stepper;
pub mod workspace;

pub use stepper::{LiquidRegion, Simulation, StepError};
