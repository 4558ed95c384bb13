//! Events of a run.

use serde::Serialize;
use std::path::PathBuf;

/// An event of a run. As JSON: one object with the key `event`.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum Event {
    /// The run begins or continues.
    Begin {
        /// Name of the scene.
        scene: String,
        /// 2 or 3.
        dimension: usize,
        /// Cells along each axis.
        cells: Vec<usize>,
        /// Number of the last frame.
        last_frame: u64,
        /// Output folder.
        folder: PathBuf,
        /// The time from which an earlier run continues, s.
        resumed_at: Option<f64>,
        /// Number of threads.
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
    /// A step takes long. Sent from another thread while the step goes on.
    LongStep {
        /// Number of the step.
        step: u64,
        /// Its duration so far, s.
        seconds: f64,
        /// Median duration of the steps before it, s; none if they are too few.
        median: Option<f64>,
        /// Time step before it, s.
        dt_before: f64,
        /// The phase at work, inferred from the step before.
        phase: String,
    },
    /// A warning for the user.
    Warning {
        /// Its text.
        message: String,
    },
    /// The run has ended.
    End {
        /// The `exit_reason` of the summary.
        reason: String,
        /// Steps done.
        steps: u64,
        /// Simulated time, s.
        time: f64,
        /// Wall time in all, s.
        wall_seconds: f64,
    },
}

/// Progress of a run.
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
    /// Largest displacement of the liquid in the step, cells.
    pub cfl: f64,
    /// Pressure iterations.
    pub iterations: usize,
    /// Present relative volume error.
    pub volume_error: f64,
    /// Number of the next frame.
    pub frame: u64,
    /// Number of the last frame.
    pub last_frame: u64,
    /// Connected components of the liquid.
    pub drops: usize,
    /// Wall time so far, s.
    pub wall_seconds: f64,
}

/// Receiver of the events of a run.
pub trait Observer {
    /// Receives an event. Called immediately, between steps.
    fn notify(&mut self, event: &Event);

    /// A receiver for events sent from another thread during a step, if any.
    fn remote(&self) -> Option<Box<dyn RemoteObserver>> {
        None
    }
}

/// An observer that does nothing.
pub struct SilentObserver;

impl Observer for SilentObserver {
    fn notify(&mut self, _: &Event) {}
}

/// Receiver of events from another thread during a step.
pub trait RemoteObserver: Send {
    /// Receives an event.
    fn notify(&self, event: &Event);
    /// Gives the run up within a step and ends the process; the disk holds the state of the last checkpoint.
    fn abandon(&self, reason: &str);
}
