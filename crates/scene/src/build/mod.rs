//! Builds a simulation from a scene.

mod any_simulation;
pub mod displaced_liquid;
mod initial_condition;
mod kinds;
mod setup;
mod shapes;
mod terms;
mod thickness;
mod wettability;

pub use any_simulation::{AnySimulation, GridValues, SceneSimulation, SimulationSize};
pub use initial_condition::{Setup, SignedDistanceFn};
pub use setup::{AnySetup, model, setup};
pub use shapes::signed_distance_fn;
