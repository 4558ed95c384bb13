//! Output of a session: it writes rows of the time series, frames, checkpoints, the log and the summary.

use super::Session;
use crate::estimate::thin_liquid;
use crate::output::frame::NotFinite;
use crate::output::summary::Summary;
use crate::output::time_series::{self, RunValues};
use crate::run::RunError;
use crate::run::checkpoint;
use crate::run::event::{Event, Observer};
use crate::units::format_si;
use meniscus_sim::StepReport;
use std::time::{Duration, Instant};

/// Shortest time between checkpoints, so that writing them does not dominate short runs.
const MIN_CHECKPOINT_INTERVAL: Duration = Duration::from_millis(100);
/// Longest time between checkpoints; it bounds the work that can be lost.
const MAX_CHECKPOINT_INTERVAL: Duration = Duration::from_secs(60);

impl<const D: usize> Session<D> {
    pub(super) fn append_row(&mut self, report: &StepReport<D>, momentum_error: f64) -> Result<(), RunError> {
        self.statistics.wall_seconds = self.seconds_before + self.clock.elapsed().as_secs_f64();
        let run = RunValues { momentum_error, wall_seconds: self.statistics.wall_seconds };
        let row = time_series::row(&self.simulation, report, &self.contact_line, &run, &self.measures);
        Ok(self.series.append(&row)?)
    }

    pub(super) fn write_frame(&mut self, observer: &mut dyn Observer) -> Result<(), RunError> {
        let start = Instant::now();
        let number = self.statistics.next_frame;
        let frame = self.extractor.frame(&self.simulation, &self.contact_line, self.job.frame_parts());
        let frame = frame.map_err(|NotFinite { what }| self.not_finite(what))?;
        self.statistics.next_frame += 1;
        self.statistics.add_overlaps(self.simulation.solids());
        self.check_thin_liquid(observer)?;
        if !self.job.writes(number) {
            return Ok(());
        }
        let mut paths = Vec::new();
        for writer in &self.job.writers {
            paths.push(writer.write(&self.folder, number, &frame)?);
        }
        // The event names the file of the first writer.
        let path = paths.into_iter().next().unwrap_or_else(|| self.folder.frames());
        self.statistics.add_phase("frames", start.elapsed().as_secs_f64());
        self.emit(Event::Frame { frame: number, time: self.simulation.state.time, path }, observer)
    }

    /// Warns once per run of liquid that the grid does not resolve.
    pub(super) fn check_thin_liquid(&mut self, observer: &mut dyn Observer) -> Result<(), RunError> {
        let (start, time) = (Instant::now(), self.simulation.state.time);
        let thin = thin_liquid::of_simulation(&self.simulation);
        let first = self.statistics.add_thin_liquid(time, &thin);
        self.statistics.add_phase("thin liquid", start.elapsed().as_secs_f64());
        let Some(place) = thin.place.filter(|_| first) else { return Ok(()) };
        let place: Vec<String> = place.iter().map(|x| format_si(*x, "m")).collect();
        let message = format!(
            "at time {} {:.1} % of the liquid is in regions thinner than two cells, near ({}): the grid does not resolve films, \
             threads and gaps there (`thin_liquid` in summary.json has the largest share)",
            format_si(time, "s"),
            100.0 * thin.share,
            place.join(", ")
        );
        self.emit(Event::Warning { message }, observer)
    }

    pub(super) fn checkpoint_is_due(&self) -> bool {
        let frames = self.statistics.next_frame.saturating_sub(self.checkpoint_frame);
        let pause = self.checkpoint_time.elapsed();
        pause >= MAX_CHECKPOINT_INTERVAL
            || frames >= self.job.checkpoint_every && pause >= MIN_CHECKPOINT_INTERVAL
    }

    pub(super) fn write_checkpoint(&mut self, observer: &mut dyn Observer) -> Result<(), RunError> {
        let start = Instant::now();
        self.statistics.series_bytes = self.series.sync()?;
        self.statistics.wall_seconds = self.seconds_before + self.clock.elapsed().as_secs_f64();
        let state = &self.simulation.state;
        let (step, time) = (state.step, state.time);
        let path = checkpoint::write(&self.folder.checkpoints(), self.job.identity, state, &self.statistics)?;
        self.checkpoint = Some(path.clone());
        self.checkpoint_frame = self.statistics.next_frame;
        self.summary("running").write(&self.folder.summary())?;
        self.statistics.add_phase("checkpoints", start.elapsed().as_secs_f64());
        self.checkpoint_time = Instant::now();
        self.emit(Event::Checkpoint { step, time, path }, observer)
    }

    /// Writes the remaining output, after a failure as far as possible. The state is the last good one unless it is not finite.
    pub(super) fn close(
        &mut self,
        left: Result<&str, &str>,
        is_state_good: bool,
        observer: &mut dyn Observer,
    ) -> Result<Summary, RunError> {
        let saved = if is_state_good { self.write_checkpoint(observer) } else { Ok(()) };
        let saved = saved.and(self.sync_series());
        // A run whose last files are not whole is not finished: a resumed one writes them.
        let failure = saved.as_ref().err().map(|error| format!("failed: {error}"));
        let reason = match (left, &failure) {
            (Ok(_), Some(failure)) => failure,
            (Ok(reason) | Err(reason), _) => reason,
        };
        self.statistics.wall_seconds = self.seconds_before + self.clock.elapsed().as_secs_f64();
        let summary = self.summary(reason);
        let told = summary.write(&self.folder.summary());
        let state = &self.simulation.state;
        let event = Event::End {
            reason: reason.to_string(),
            steps: state.step,
            time: state.time,
            wall_seconds: self.statistics.wall_seconds,
        };
        self.emit(event, observer)?;
        saved?;
        told?;
        Ok(summary)
    }

    /// Brings `timeseries.csv` up to the present step.
    ///
    /// # Errors
    /// [`RunError::Output`].
    pub fn sync_series(&mut self) -> Result<(), RunError> {
        self.series.sync()?;
        Ok(())
    }

    pub(super) fn emit(&mut self, event: Event, observer: &mut dyn Observer) -> Result<(), RunError> {
        observer.notify(&event);
        let line = serde_json::to_value(&event).unwrap_or_default();
        Ok(self.log.write(&line)?)
    }

    pub(super) fn summary(&self, reason: &str) -> Summary {
        Summary::of(&self.job, &self.simulation, &self.contact_line, &self.statistics, reason)
    }
}
