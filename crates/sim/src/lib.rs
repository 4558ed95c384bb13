//! Simulation of a liquid with surface tension on a staggered grid, coupled to rigid and deformable solids.
//!
//! This crate never opens a file, reads a clock or chooses a number of threads.

mod collision;
mod components;
mod contact_line;
mod coupling;
mod flow;
mod free_surface;
mod model;
pub mod paper;
mod simulation;
mod solid;
mod state;

pub use collision::initial_points::{narrowest_current_gap, narrowest_initial_gap};
pub use collision::overlap::{initial_overlaps, overlaps};
pub use collision::potential::slips::{ContactKey, Slip, Slips};
pub use collision::potential::stored_energy::{Barriers, advanced_solids};
pub use contact_line::tracker::{ContactLine, LinePoint, LineTracker};
pub use flow::outflow::OPEN_SIDE_MARGIN_CELLS;
pub use flow::prescribed::PrescribedFlow;
pub use flow::pressure::FlowSolves;
pub use model::time_step::PhaseEnd;
pub use model::{Model, Numerics, Scheme, Wall};
pub use simulation::diagnostics::{Diagnostics, StepReport};
pub use simulation::repairs::{Quantity, Repairs};
pub use simulation::{Compiled, LiquidRegion, Simulation, StepError};
pub use solid::domain_walls::WETTING_WALL_MARGIN_CELLS;
pub use solid::kind;
pub use solid::mass_properties::MassProperties;
pub use solid::wettability::{CosineImage, Hysteresis, WettabilityLayer};
pub use solid::{
    DEFAULT_FRICTION, DEFAULT_RESTITUTION, DeformableKinematics, Kinematics, MIN_PLATE_THICKNESS_CELLS,
    PrescribedMotion, RigidKinematics, Solid, SolidKind, SolidState, SolidSurfaces, SolidView, Solids,
};
pub use state::{Component, State};
