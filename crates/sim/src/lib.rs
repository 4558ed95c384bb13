//! The physics of Meniscus: a surface-tension liquid on a staggered grid.
//!
//! This crate never opens a file, reads a clock or chooses a number of threads.

mod coupling;
mod keep;
mod kinematic;
mod ledger;
mod line;
mod liquid;
mod model;
mod simulation;
mod solid;
mod state;
mod step;
mod workspace;

pub use kinematic::Kinematic;
pub use ledger::{Ledger, StepReport};
pub use model::{Model, Numerics, Wall};
pub use simulation::{Body, PhaseEnd, Simulation, StepError};
pub use solid::{Motion, Path, RigidBody, Solid, SolidState};
pub use state::{Drop, State};
