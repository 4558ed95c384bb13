//! What a run tells while it goes.

use serde::Serialize;
use std::path::PathBuf;

/// Something that happened in a run. As JSON: one object with the key `event`.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum Event {
    /// The run begins, or goes on.
    Begin {
        /// Name of the scene.
        scene: String,
        /// 2 or 3.
        dimension: usize,
        /// Cells along each axis.
        cells: Vec<usize>,
        /// Number of the last frame.
        last_frame: u64,
        /// Where the output goes.
        folder: PathBuf,
        /// The time from which an earlier run is continued, s.
        resumed_at: Option<f64>,
        /// Threads at work.
        threads: usize,
        /// Version of Meniscus.
        version: &'static str,
    },
    /// A step was done.
    Step(Progress),
    /// A frame was written.
    Frame {
        /// Its number.
        frame: u64,
        /// Its time, s.
        time: f64,
        /// The file.
        path: PathBuf,
    },
    /// A checkpoint was written.
    Checkpoint {
        /// Steps done.
        step: u64,
        /// Its time, s.
        time: f64,
        /// The file.
        path: PathBuf,
    },
    /// A step is taking long. Told from another thread, while it goes on.
    LongStep {
        /// Its number.
        step: u64,
        /// How long it has taken so far, s.
        seconds: f64,
        /// Median of the steps before it, s; none where they are too few.
        median: Option<f64>,
        /// Length of the step before it, s.
        dt_before: f64,
        /// The phase that it is in, as far as the step before tells.
        phase: String,
    },
    /// Something that the user should know.
    Warning {
        /// What.
        message: String,
    },
    /// The run is over, for whatever reason.
    End {
        /// Why: the `exit_reason` of the summary.
        reason: String,
        /// Steps done.
        steps: u64,
        /// Its time, s.
        time: f64,
        /// Seconds of work in all.
        wall_seconds: f64,
    },
}

/// Where a run is.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Progress {
    /// Steps done.
    pub step: u64,
    /// Simulated time, s.
    pub time: f64,
    /// Simulated time at the end, s.
    pub end: f64,
    /// Length of the step, s.
    pub dt: f64,
    /// Cells that the fastest liquid moved.
    pub cfl: f64,
    /// Pressure iterations.
    pub iterations: usize,
    /// Relative volume error now.
    pub volume_error: f64,
    /// Frame that comes next.
    pub frame: u64,
    /// Number of the last frame.
    pub last_frame: u64,
    /// Components of the liquid.
    pub drops: usize,
    /// Seconds of work so far.
    pub wall_seconds: f64,
}

/// Told of everything that happens in a run.
pub trait Observer {
    /// Called at once, between steps.
    fn notify(&mut self, event: &Event);

    /// The observer of events that another thread sends while a step goes on; none if there is none.
    fn remote(&self) -> Option<Box<dyn RemoteObserver>> {
        None
    }
}

/// An observer that does nothing.
pub struct SilentObserver;

impl Observer for SilentObserver {
    fn notify(&mut self, _: &Event) {}
}

/// What an observer does from another thread while a step goes on.
pub trait RemoteObserver: Send {
    /// Told of an event.
    fn notify(&self, event: &Event);
    /// The run is given up within a step; what is on the disk is that of the last checkpoint. Ends the process.
    fn abandon(&self, reason: &str);
}
