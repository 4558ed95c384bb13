//! What a run needs to know of a scene beside the physics.

use super::schedule::Schedule;
use crate::estimate::parameters::Parameter;

/// What a run needs to know of a scene beside the physics.
#[derive(Clone, Debug, PartialEq)]
pub struct Job {
    /// Name of the scene.
    pub name: String,
    /// The scene with everything filled in, as TOML: what `scene.toml` of the output will be.
    pub text: String,
    /// Identity of everything that decides the bits of the result. Checkpoints of another identity are refused.
    pub identity: u64,
    /// When frames are due.
    pub schedule: Schedule,
    /// Time between frames, s.
    pub frame_interval: f64,
    /// The frames to write, first and last; the run ends with the last.
    pub frames: Option<(u64, u64)>,
    /// Frames between checkpoints.
    pub checkpoint_every: u64,
    /// Name and mesh edge, m, of every solid.
    pub solids: Vec<(String, f64)>,
    /// Warnings about the scene, told at the start.
    pub warnings: Vec<String>,
    /// The scene's `description`.
    pub description: Option<String>,
    /// The parameters of the scene, for the summary.
    pub parameters: Vec<Parameter>,
}

/// What to do with an output folder that holds a run already.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExistingRun {
    /// Refuse.
    Refuse,
    /// Remove it and start again.
    Replace,
    /// Go on from its last checkpoint; start if there is none.
    Resume,
}

/// Why a run is asked to stop before its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// A signal.
    Signal,
    /// A second signal: within the step, whose work is lost.
    AtOnce,
    /// The time given with `--walltime` is over.
    Walltime,
}

impl Stop {
    /// The beginning of the `exit_reason` of the summary.
    pub(crate) fn reason(self) -> &'static str {
        match self {
            Self::Signal | Self::AtOnce => "stopped: signal",
            Self::Walltime => "stopped: walltime",
        }
    }
}
