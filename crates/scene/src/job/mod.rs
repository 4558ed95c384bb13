//! The job of a run, its schedule, and the statistics that it keeps beside the state.

mod plan;
mod schedule;
mod statistics;

pub use plan::{ExistingRun, Job, Stop};
pub use schedule::Schedule;
pub(crate) use statistics::padded_to_3d;
pub use statistics::{RunStatistics, ThinLiquidStatistics};
