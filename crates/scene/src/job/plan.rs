//! The plan of a run: what a scene says of its output, duration and numerics apart from the physics.

use super::schedule::Schedule;
use crate::estimate::parameters::Parameter;
use crate::output::frame::FrameWriter;
use std::sync::Arc;

/// The part of a scene that controls a run and is not physics.
#[derive(Clone, Debug)]
pub struct Job {
    /// Name of the scene.
    pub name: String,
    /// The complete scene as TOML, written to `scene.toml` of the output.
    pub text: String,
    /// Hash of everything that determines the result bit for bit. Checkpoints with another identity are refused.
    pub identity: u64,
    /// Times of the frames.
    pub schedule: Schedule,
    /// Time between frames, s.
    pub frame_interval: f64,
    /// First and last frame to write; the run ends with the last.
    pub frames: Option<(u64, u64)>,
    /// Writers of the frames; the log names the file of the first one.
    pub writers: Vec<Arc<dyn FrameWriter>>,
    /// Frames between checkpoints.
    pub checkpoint_every: u64,
    /// Name and mesh edge, m, of every solid.
    pub solids: Vec<(String, f64)>,
    /// Warnings about the scene, shown at the start.
    pub warnings: Vec<String>,
    /// The scene's `description`.
    pub description: Option<String>,
    /// The parameters of the scene, for the summary.
    pub parameters: Vec<Parameter>,
}

/// Treatment of an output folder that already holds a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExistingRun {
    /// Refuse.
    Refuse,
    /// Remove the run and start again.
    Replace,
    /// Continue from its last checkpoint; start if there is none.
    Resume,
}

/// Why a run is asked to stop early.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// A signal.
    Signal,
    /// A second signal: stops within the step, whose work is lost.
    AtOnce,
    /// The time given with `--walltime` is used up.
    Walltime,
    /// The program that steps through the run goes no further.
    Caller,
}

impl Stop {
    /// The beginning of the `exit_reason` of the summary.
    pub(crate) fn reason(self) -> &'static str {
        match self {
            Self::Signal | Self::AtOnce => "stopped: signal",
            Self::Walltime => "stopped: walltime",
            Self::Caller => "stopped: by the calling program",
        }
    }
}
