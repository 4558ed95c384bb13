//! From a resolved scene to a simulation.

mod constraints;
mod deformable;
pub mod displaced;
mod setup;
mod shapes;
mod start;
mod thickness;
mod wettability;

pub use setup::{AnySetup, AnySimulation, model, setup};
pub use shapes::signed_distance_fn;
pub use start::{SignedDistanceFn, Setup};
