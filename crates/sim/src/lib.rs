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

pub use crate::collision::overlap::overlaps;
pub use crate::collision::potential::slips::{Slip, Slips, Touch};
pub use crate::collision::potential::stored_energy::{Barriers, solids_after};
pub use crate::collision::start::{narrowest_gap, narrowest_gap_now};
pub use crate::contact_line::tracker::{ContactLine, LinePoint, LineTracker};
pub use crate::flow::outflow::OPEN_MARGIN;
pub use crate::flow::prescribed::Kinematic;
pub use crate::model::time_step::PhaseEnd;
pub use crate::model::{Model, Numerics, Wall};
pub use crate::repairs::{Quantity, Repairs};
pub use crate::simulation::diagnostics::{Ledger, StepReport};
pub use crate::simulation::{Body, Simulation, StepError};
pub use crate::solid::deformable::Soft;
pub use crate::solid::domain_walls::MARGIN;
pub use crate::solid::rigid_body::RigidBody;
pub use crate::solid::wettability::{Hysteresis, Layer, Picture};
pub use crate::solid::{FRICTION, Motion, Path, RESTITUTION, Solid, SolidState, THINNEST};
pub use crate::state::{Drop, State};
