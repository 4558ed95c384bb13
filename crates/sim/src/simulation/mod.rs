//! A simulation: model and state, one step, and its report.

pub mod diagnostics;
pub mod paper_step;
pub mod repairs;
pub mod step;
pub mod stepper;
pub mod transport;
pub mod workspace;

pub use stepper::{Compiled, LiquidRegion, Simulation, StepError};
