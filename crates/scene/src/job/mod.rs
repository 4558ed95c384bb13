//! What a run is asked to do, and what it carries along beside the state.

mod plan;
mod schedule;
mod tally;

pub use plan::{ExistingRun, Job, Stop};
pub use schedule::Schedule;
pub(crate) use tally::padded_to_3d;
pub use tally::{RunStatistics, ThinLiquidStatistics};
