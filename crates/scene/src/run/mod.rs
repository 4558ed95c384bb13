//! The run of a scene: steps, frames, checkpoints, until it is done, is asked to stop, or fails.

pub mod checkpoint;
mod error;
mod event;
mod resume;
mod schedule;
mod session;
mod tally;
mod watchdog;

pub use error::RunError;
pub use event::{Event, Observer, Progress, Silent};
pub use schedule::Schedule;
pub(crate) use tally::three;
pub use tally::{Tally, ThinTally};
pub use watchdog::Remote;

use crate::estimate::parameters::Parameter;
use crate::output::summary::{FINISHED, Summary};
use crate::output::{FileError, Folder};
use meniscus_numerics::Vector;
use meniscus_sim::{Body, Model, Simulation};
use std::sync::Arc;

/// What a simulation starts from: its model and the bodies of liquid.
#[derive(Clone)]
pub struct Setup<const D: usize> {
    /// The model.
    pub model: Model<D>,
    /// Bodies of liquid with their start velocity, m/s.
    pub bodies: Vec<(Region<D>, Vector<D>)>,
}

/// Signed distance to a region of space, m, negative inside.
pub type Region<const D: usize> = Arc<dyn Fn(&Vector<D>) -> f64 + Send + Sync>;

impl<const D: usize> Setup<D> {
    /// The simulation at its start.
    pub fn simulation(&self) -> Simulation<D> {
        let bodies: Vec<Body<'_, D>> = self
            .bodies
            .iter()
            .map(|(region, velocity)| Body { distance: &**region, velocity: *velocity })
            .collect();
        Simulation::new(self.model.clone(), &bodies)
    }
}

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
pub enum Existing {
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

/// Runs a simulation into a folder. `stop` is asked between steps, and from another thread within them.
///
/// # Errors
/// [`RunError`]; what was written is whole, and the last good checkpoint is kept.
pub fn run<const D: usize>(
    setup: &Setup<D>,
    job: &Job,
    folder: &Folder,
    existing: Existing,
    stop: &(dyn Fn() -> Option<Stop> + Sync),
    observer: &mut dyn Observer,
) -> Result<Outcome, RunError> {
    if existing == Existing::Resume
        && let Some(summary) = finished(job, folder)?
    {
        return Ok(Outcome::AlreadyFinished(summary));
    }
    let session = match existing {
        Existing::Resume => resume::resume(setup, job, folder, observer)?,
        _ => {
            folder.start(existing == Existing::Replace)?;
            session::Session::start(setup.simulation(), job, folder)?
        }
    };
    session.run(stop, observer)
}

/// The summary of an earlier run that has done all that is asked now.
fn finished(job: &Job, folder: &Folder) -> Result<Option<Summary>, RunError> {
    let Ok(summary) = Summary::read(&folder.summary()) else { return Ok(None) };
    if summary.exit_reason != FINISHED || !job.schedule.reaches(summary.simulated_seconds, job.last_frame()) {
        return Ok(None);
    }
    resume::check_identity(job, folder)?;
    Ok(Some(summary))
}

impl Job {
    /// Number of the last frame to write.
    pub fn last_frame(&self) -> u64 {
        let last = self.schedule.last_frame();
        self.frames.map_or(last, |(_, b)| b.min(last))
    }

    fn writes(&self, frame: u64) -> bool {
        self.frames.is_none_or(|(a, b)| (a..=b).contains(&frame))
    }
}

impl From<FileError> for RunError {
    fn from(error: FileError) -> Self {
        Self::Output { error, checkpoint: None }
    }
}
