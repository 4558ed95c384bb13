//! Outcome of a run.

use crate::job::Stop;
use crate::output::summary::Summary;

/// Outcome of a run.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// The run is complete.
    Finished(Summary),
    /// The run was already complete.
    AlreadyFinished(Summary),
    /// The run stopped on request after a checkpoint.
    Stopped(Stop, Summary),
}
