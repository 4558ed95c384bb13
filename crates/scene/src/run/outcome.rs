//! How a run ended.

use crate::job::Stop;
use crate::output::summary::Summary;

/// How a run ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// It did all it was asked.
    Finished(Summary),
    /// There was nothing left to do.
    AlreadyFinished(Summary),
    /// It stopped on request after a checkpoint.
    Stopped(Stop, Summary),
}
