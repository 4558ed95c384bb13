//! The physics of Meniscus: a surface-tension liquid on a staggered grid.
//!
//! This crate never opens a file, reads a clock or chooses a number of threads.

mod collision;
mod components;
mod contact_line;
mod coupling;
mod flow;
mod free_surface;
mod model;
mod repairs;
mod simulation;
mod solid;
mod state;

pub use collision::overlap::overlaps;
pub use collision::potential::slips::{Slip, Slips, Touch};
pub use collision::potential::stored_energy::{Barriers, solids_after};
pub use collision::start::{narrowest_gap, narrowest_gap_now};
pub use contact_line::tracker::{ContactLine, LinePoint, LineTracker};
pub use flow::outflow::OPEN_MARGIN;
pub use flow::prescribed::Kinematic;
pub use model::time_step::PhaseEnd;
pub use model::{Model, Numerics, Wall};
pub use repairs::{Quantity, Repairs};
pub use simulation::diagnostics::{Ledger, StepReport};
pub use simulation::{Body, Simulation, StepError};
pub use solid::deformable::Soft;
pub use solid::domain_walls::MARGIN;
pub use solid::rigid_body::RigidBody;
pub use solid::wettability::{Hysteresis, Layer, Picture};
pub use solid::{FRICTION, Motion, Path, RESTITUTION, Solid, SolidState, THINNEST};
pub use state::{Drop, State};
