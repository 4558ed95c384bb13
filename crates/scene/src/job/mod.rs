//! What a run is asked to do, and what it carries along beside the state.

mod plan;
mod schedule;
mod tally;

pub use plan::{Existing, Job, Stop};
pub use schedule::Schedule;
pub(crate) use tally::three;
pub use tally::{Tally, ThinTally};
