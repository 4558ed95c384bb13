//! The physics of Meniscus: a surface-tension liquid on a staggered grid.
//!
//! This crate never opens a file, reads a clock or chooses a number of threads.

mod balance;
mod change;
mod compiled;
mod coupling;
mod descent;
mod exchange;
mod hysteresis;
mod keep;
mod kinematic;
mod ledger;
mod line;
mod liquid;
mod model;
mod outflow;
mod overlap;
mod press;
mod profile;
mod repairs;
mod rigid_body;
mod simulation;
mod skin;
mod soft;
mod solid;
mod state;
mod step;
mod tension;
mod track;
mod walls;
mod wetting;
mod workspace;

pub use descent::{Barriers, Slip, Slips, Touch, narrowest_gap, narrowest_gap_now, solids_after};
pub use kinematic::Kinematic;
pub use ledger::{Ledger, StepReport};
pub use model::{Model, Numerics, Wall};
pub use outflow::OPEN_MARGIN;
pub use overlap::overlaps;
pub use repairs::{Quantity, Repairs};
pub use rigid_body::RigidBody;
pub use simulation::{Body, PhaseEnd, Simulation, StepError};
pub use soft::Soft;
pub use solid::{FRICTION, Motion, Path, RESTITUTION, Solid, SolidState, THINNEST};
pub use state::{Drop, State};
pub use track::{ContactLine, LinePoint, LineTracker};
pub use walls::MARGIN;
pub use wetting::{Hysteresis, Layer, Picture};
