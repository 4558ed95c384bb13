//! The run of a scene: steps, frames and checkpoints until it is complete, stopped, or fails.

pub mod checkpoint;
mod error;
mod event;
mod outcome;
mod resume;
mod scene_text;
mod session;
mod watchdog;

pub use crate::build::{Setup, SignedDistanceFn};
pub use crate::job::{ExistingRun, Job, RunStatistics, Schedule, Stop, ThinLiquidStatistics};
pub use error::RunError;
pub use event::RemoteObserver;
pub use event::{Event, Observer, Progress, SilentObserver};
pub use outcome::Outcome;
pub use resume::reopen;
pub use session::{Advance, BeforeStep, Session};

use crate::output::frame::FrameParts;
use crate::output::summary::{FINISHED, Summary};
use crate::output::{FileError, Folder};
use meniscus_sim::{Compiled, Simulation};
use session::Output;

/// Runs a simulation into a folder. `stop` is polled between steps, and from another thread within them.
///
/// # Errors
/// [`RunError`]; files already written are complete, and the last good checkpoint is kept.
pub fn run<const D: usize>(
    setup: &Setup<D>,
    job: &Job,
    folder: &Folder,
    existing: ExistingRun,
    stop: &(dyn Fn() -> Option<Stop> + Sync),
    observer: &mut dyn Observer,
) -> Result<Outcome, RunError>
where
    Simulation<D>: Compiled<D>,
{
    match open(setup, job, folder, existing, observer)? {
        Opened::AlreadyFinished(summary) => Ok(Outcome::AlreadyFinished(*summary)),
        Opened::Session(session) => session.run(stop, observer),
    }
}

/// Result of [`open`].
pub enum Opened<const D: usize> {
    /// A run that begins or goes on.
    Session(Box<Session<D>>),
    /// A run that has done all that the job asks.
    AlreadyFinished(Box<Summary>),
}

/// Opens an output folder for a run, which [`Session::run`] does as a whole, or the caller step by step.
///
/// # Errors
/// [`RunError`].
pub fn open<const D: usize>(
    setup: &Setup<D>,
    job: &Job,
    folder: &Folder,
    existing: ExistingRun,
    observer: &mut dyn Observer,
) -> Result<Opened<D>, RunError>
where
    Simulation<D>: Compiled<D>,
{
    if existing == ExistingRun::Resume
        && let Some(summary) = finished(job, folder)?
    {
        return Ok(Opened::AlreadyFinished(Box::new(summary)));
    }
    let session = match existing {
        ExistingRun::Resume => reopen(setup, job, folder, observer)?,
        _ => {
            let log = folder.prepare(existing == ExistingRun::Replace)?;
            Session::start(setup.simulation(), Output { job, folder, log })?
        }
    };
    Ok(Opened::Session(Box::new(session)))
}

/// The summary of an earlier run, if it has done all that this job asks.
fn finished(job: &Job, folder: &Folder) -> Result<Option<Summary>, RunError> {
    let Ok(summary) = Summary::read(&folder.summary()) else { return Ok(None) };
    if summary.exit_reason != FINISHED
        || !job.schedule.has_reached_frame(summary.simulated_seconds, job.last_frame())
    {
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

    /// What the writers need of a frame.
    fn frame_parts(&self) -> FrameParts {
        self.writers.iter().fold(FrameParts::default(), |parts, writer| parts.or(writer.parts()))
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
