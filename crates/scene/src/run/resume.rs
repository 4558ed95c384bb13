//! Resuming from a checkpoint.

use super::RunError;
use super::checkpoint::{self, CheckpointError};
use super::event::{Event, Observer};
use super::scene_text::identity_line;
use super::session::{Output, Session, first_frame_after};
use crate::build::Setup;
use crate::job::Job;
use crate::output::time_series::TimeSeriesWriter;
use crate::output::{FileError, Folder};
use meniscus_sim::Compiled;
use meniscus_sim::Simulation;

/// Opens the folder of a run, complete or not, at the newest undamaged checkpoint. Without any checkpoint the run begins.
///
/// # Errors
/// [`RunError`].
pub fn reopen<const D: usize>(
    setup: &Setup<D>,
    job: &Job,
    folder: &Folder,
    observer: &mut dyn Observer,
) -> Result<Session<D>, RunError>
where
    Simulation<D>: Compiled<D>,
{
    let log = folder.lock()?;
    let mut failure = None;
    for path in checkpoint::list(&folder.checkpoints()) {
        match checkpoint::read(&path, job.identity, setup.model.grid) {
            Ok((state, mut tally)) => {
                tally.next_frame = first_frame_after(job, state.time, tally.next_frame);
                let Some(series) = TimeSeriesWriter::reopen(&folder.series(), tally.series_bytes)? else {
                    let what = "timeseries.csv is shorter than when it was written".to_string();
                    failure.get_or_insert(CheckpointError::Damaged { path, what });
                    continue;
                };
                checkpoint::remove_newer(&path);
                folder.make()?;
                folder.remove_frames_from(tally.next_frame)?;
                let simulation = Simulation::resume(setup.model.clone(), state);
                return Ok(Session::resume(simulation, tally, series, Output { job, folder, log })?);
            }
            Err(error @ CheckpointError::Foreign { .. }) => return Err(error.into()),
            Err(error) => {
                let message = format!("{error}; the previous checkpoint is tried");
                observer.notify(&Event::Warning { message });
                failure.get_or_insert(error);
            }
        }
    }
    match failure {
        Some(error) => Err(error.into()),
        None => {
            if folder.holds_a_run() {
                check_identity(job, folder)?;
            }
            folder.renew(&log)?;
            Ok(Session::start(setup.simulation(), Output { job, folder, log })?)
        }
    }
}

/// Refuses a folder that holds another scene.
pub(super) fn check_identity(job: &Job, folder: &Folder) -> Result<(), RunError> {
    let path = folder.scene();
    if !path.exists() {
        return Ok(());
    }
    let text = std::fs::read_to_string(&path).map_err(FileError::of("read", &path))?;
    if identity_line(&text) == Some(job.identity) {
        return Ok(());
    }
    Err(RunError::OtherScene(folder.root().to_path_buf()))
}
