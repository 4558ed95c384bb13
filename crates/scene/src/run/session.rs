//! The session: the loop of one process over the steps of a run.

use super::checkpoint;
use super::error::RunError;
use super::event::{Event, Observer, Progress};
use super::outcome::Outcome;
use super::scene_text::scene_text;
use super::watchdog::{FinishOnDrop, Limits, Watchdog};
use crate::estimate::thin_liquid;
use crate::job::{Job, RunStatistics, Stop};
use crate::output::frame::{FrameExtractor, NotFinite, liquid_surface};
use crate::output::log::Log;
use crate::output::summary::{FINISHED, Summary};
use crate::output::time_series::{self, RunValues, TimeSeriesWriter};
use crate::output::{FileError, Folder, SolidMeasures, atomic_file};
use crate::units::format_si;
use meniscus_sim::{ContactLine, Simulation, StepReport};
use std::io::Write;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Shortest time between checkpoints, so that writing them does not dominate short runs.
const MIN_CHECKPOINT_INTERVAL: Duration = Duration::from_millis(100);
/// Longest time between checkpoints; it bounds the work that can be lost.
const MAX_CHECKPOINT_INTERVAL: Duration = Duration::from_secs(60);

/// A run in this process.
pub(super) struct Session<'a, const D: usize> {
    job: &'a Job,
    folder: &'a Folder,
    simulation: Simulation<D>,
    extractor: FrameExtractor<D>,
    /// The contact line of the present state.
    contact_line: ContactLine<D>,
    statistics: RunStatistics,
    measures: SolidMeasures,
    series: TimeSeriesWriter,
    log: Log,
    resumed_at: Option<f64>,
    checkpoint: Option<PathBuf>,
    checkpoint_frame: u64,
    checkpoint_time: Instant,
    /// Start of this process less the seconds worked before it.
    clock: Instant,
    seconds_before: f64,
    watchdog: Arc<Watchdog>,
}

/// Why the loop ended without error.
enum LoopExit {
    AtEnd,
    StopRequested(Stop),
}

impl<'a, const D: usize> Session<'a, D> {
    /// A new run in a prepared folder.
    pub(super) fn start(
        simulation: Simulation<D>,
        job: &'a Job,
        folder: &'a Folder,
    ) -> Result<Self, FileError> {
        atomic_file::write_atomically(&folder.scene(), |w| w.write_all(scene_text(job).as_bytes()))?;
        let tally = RunStatistics::at_start(&simulation.model, &simulation.diagnostics());
        let names = || job.solids.iter().map(|s| s.0.as_str());
        let measures = SolidMeasures::new(&simulation, job.solids.len()).columns::<D>(names());
        let series = TimeSeriesWriter::create(&folder.series(), names(), &measures)?;
        Self::open(simulation, tally, series, job, folder, None)
    }

    /// A run that continues from a checkpoint.
    pub(super) fn resume(
        simulation: Simulation<D>,
        tally: RunStatistics,
        series: TimeSeriesWriter,
        job: &'a Job,
        folder: &'a Folder,
    ) -> Result<Self, FileError> {
        atomic_file::write_atomically(&folder.scene(), |w| w.write_all(scene_text(job).as_bytes()))?;
        let time = simulation.state.time;
        Self::open(simulation, tally, series, job, folder, Some(time))
    }

    fn open(
        simulation: Simulation<D>,
        statistics: RunStatistics,
        series: TimeSeriesWriter,
        job: &'a Job,
        folder: &'a Folder,
        resumed_at: Option<f64>,
    ) -> Result<Self, FileError> {
        let extractor = FrameExtractor::new(&simulation.model, &job.solids);
        Ok(Self {
            job,
            folder,
            contact_line: extractor.contact_line(&simulation),
            extractor,
            checkpoint: checkpoint::list(&folder.checkpoints()).first().cloned(),
            checkpoint_frame: statistics.next_frame,
            checkpoint_time: Instant::now(),
            clock: Instant::now(),
            seconds_before: statistics.wall_seconds,
            log: Log::open(&folder.log())?,
            measures: SolidMeasures::new(&simulation, job.solids.len()),
            simulation,
            statistics,
            series,
            resumed_at,
            watchdog: Arc::new(Watchdog::new(Limits::default())),
        })
    }

    /// Runs until the end, a request to stop, or a failure. Another thread watches it if the observer has a remote.
    pub(super) fn run(
        self,
        stop: &(dyn Fn() -> Option<Stop> + Sync),
        observer: &mut dyn Observer,
    ) -> Result<Outcome, RunError> {
        let Some(remote) = observer.remote() else { return self.run_and_close(stop, observer) };
        let (watchdog, log, summary) =
            (Arc::clone(&self.watchdog), self.log.try_clone(), self.folder.summary());
        std::thread::scope(|scope| {
            let _finish = FinishOnDrop(&watchdog);
            let watchdog = &watchdog;
            scope.spawn(move || watchdog.watch(stop, &*remote, log, &summary));
            self.run_and_close(stop, observer)
        })
    }

    fn run_and_close(
        mut self,
        stop: &dyn Fn() -> Option<Stop>,
        observer: &mut dyn Observer,
    ) -> Result<Outcome, RunError> {
        let left = self.begin(observer).and_then(|()| self.run_steps(stop, observer));
        let reason = match &left {
            Ok(LoopExit::AtEnd) => FINISHED.to_string(),
            Ok(LoopExit::StopRequested(stop)) => stop.reason().to_string(),
            Err(error) => format!("failed: {error}"),
        };
        // After a failure of the solver the state is the last good one, unless it is not finite.
        let is_state_good = match &left {
            Ok(_) => true,
            Err(error) => error.is_solver_failure() && self.state_is_finite(),
        };
        let closed = self.close(&reason, is_state_good, observer);
        match (left, closed) {
            (Err(error), _) => Err(self.with_checkpoint(error)),
            (Ok(_), Err(error)) => Err(self.with_checkpoint(error)),
            (Ok(LoopExit::AtEnd), Ok(summary)) => Ok(Outcome::Finished(summary)),
            (Ok(LoopExit::StopRequested(stop)), Ok(summary)) => Ok(Outcome::Stopped(stop, summary)),
        }
    }

    fn begin(&mut self, observer: &mut dyn Observer) -> Result<(), RunError> {
        let event = Event::Begin {
            scene: self.job.name.clone(),
            dimension: D,
            cells: self.simulation.model.grid.domain_cells().to_vec(),
            last_frame: self.job.last_frame(),
            folder: self.folder.root().to_path_buf(),
            resumed_at: self.resumed_at,
            threads: rayon::current_num_threads(),
            version: env!("CARGO_PKG_VERSION"),
        };
        self.emit(event, observer)?;
        if self.resumed_at.is_some() {
            return Ok(());
        }
        for message in self.job.warnings.clone() {
            self.emit(Event::Warning { message }, observer)?;
        }
        let diagnostics = self.simulation.diagnostics();
        let report = StepReport {
            dt: 0.0,
            cfl: 0.0,
            solves: Default::default(),
            newton_iterations: 0,
            repairs: Default::default(),
            diagnostics,
        };
        self.append_row(&report, 0.0)?;
        self.write_frame(observer)?;
        self.write_checkpoint(observer)
    }

    fn run_steps(
        &mut self,
        stop: &dyn Fn() -> Option<Stop>,
        observer: &mut dyn Observer,
    ) -> Result<LoopExit, RunError> {
        while self.statistics.next_frame <= self.job.last_frame() {
            if let Some(stop) = stop() {
                return Ok(LoopExit::StopRequested(stop));
            }
            let report = self.step()?;
            if let Some(message) = self.watchdog.end(report.dt) {
                self.emit(Event::Warning { message }, observer)?;
            }
            observer.notify(&Event::Step(self.progress(&report)));
            if self.job.schedule.has_reached_frame(self.simulation.state.time, self.statistics.next_frame) {
                self.write_frame(observer)?;
            }
            if self.checkpoint_is_due() {
                self.write_checkpoint(observer)?;
            }
        }
        Ok(LoopExit::AtEnd)
    }

    fn checkpoint_is_due(&self) -> bool {
        let frames = self.statistics.next_frame.saturating_sub(self.checkpoint_frame);
        let pause = self.checkpoint_time.elapsed();
        pause >= MAX_CHECKPOINT_INTERVAL
            || frames >= self.job.checkpoint_every && pause >= MIN_CHECKPOINT_INTERVAL
    }

    /// Description of the narrowest gap between solids; empty if none is narrow.
    fn narrowest_gap(&self) -> String {
        let Simulation { model, state, .. } = &self.simulation;
        let Some((solid, other, gap)) = meniscus_sim::narrowest_current_gap(model, &state.solids) else {
            return String::new();
        };
        let name = |k: usize| self.job.solids.get(k).map_or("a wall".to_owned(), |s| format!("`{}`", s.0));
        let other = match other {
            None => "a side of the domain".to_owned(),
            Some(other) if other == solid => "itself".to_owned(),
            Some(other) => name(other),
        };
        format!("; the narrowest gap, {gap:.1e} m, is between {} and {other}", name(solid))
    }

    /// One time step and its row.
    fn step(&mut self) -> Result<StepReport<D>, RunError> {
        let (schedule, frame) = (&self.job.schedule, self.statistics.next_frame);
        let fixed = self.simulation.model.numerics.fixed_step.is_some();
        let longest =
            if fixed { f64::INFINITY } else { schedule.longest_step(self.simulation.state.time, frame) };
        let mut last = Instant::now();
        let (tally, watchdog) = (&mut self.statistics, &self.watchdog);
        watchdog.begin(self.simulation.state.step + 1);
        let mut phase_end = |name: &'static str| {
            let now = Instant::now();
            tally.add_phase(name, (now - last).as_secs_f64());
            watchdog.phase_end(name);
            last = now;
        };
        let done = self.simulation.step(longest, &mut phase_end);
        let report = done.map_err(|error| RunError::of_step(error, || self.narrowest_gap()))?;
        if schedule.is_frame_time(self.simulation.state.time, frame) {
            self.simulation.state.time = schedule.time(frame);
        }
        let ledger = &report.diagnostics;
        let sums = [ledger.volume, ledger.kinetic_energy, ledger.surface_energy, ledger.max_speed];
        if !sums.into_iter().chain(ledger.momentum.iter().copied()).all(f64::is_finite) {
            return Err(self.not_finite("volume, energy or momentum of the liquid"));
        }
        let time = self.simulation.state.time;
        let momentum_error = self.statistics.add_step(&self.simulation.model, time, &report);
        self.update_contact_line();
        self.append_row(&report, momentum_error)?;
        Ok(report)
    }

    fn update_contact_line(&mut self) {
        if !self.simulation.model.solids.is_empty() {
            let start = Instant::now();
            self.contact_line = self.extractor.contact_line(&self.simulation);
            self.statistics.add_phase("contact line", start.elapsed().as_secs_f64());
        }
    }

    fn append_row(&mut self, report: &StepReport<D>, momentum_error: f64) -> Result<(), RunError> {
        self.statistics.wall_seconds = self.seconds_before + self.clock.elapsed().as_secs_f64();
        let run = RunValues { momentum_error, wall_seconds: self.statistics.wall_seconds };
        let row = time_series::row(&self.simulation, report, &self.contact_line, &run, &self.measures);
        Ok(self.series.append(&row)?)
    }

    fn write_frame(&mut self, observer: &mut dyn Observer) -> Result<(), RunError> {
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
            paths.push(writer.write(self.folder, number, &frame)?);
        }
        // The event names the file of the first writer.
        let path = paths.into_iter().next().unwrap_or_else(|| self.folder.frames());
        self.statistics.add_phase("frames", start.elapsed().as_secs_f64());
        self.emit(Event::Frame { frame: number, time: self.simulation.state.time, path }, observer)
    }

    /// Warns once per run of liquid that the grid does not resolve.
    fn check_thin_liquid(&mut self, observer: &mut dyn Observer) -> Result<(), RunError> {
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

    fn write_checkpoint(&mut self, observer: &mut dyn Observer) -> Result<(), RunError> {
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
    fn close(
        &mut self,
        reason: &str,
        is_state_good: bool,
        observer: &mut dyn Observer,
    ) -> Result<Summary, RunError> {
        let saved = if is_state_good { self.write_checkpoint(observer) } else { Ok(()) };
        let written = self.series.sync();
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
        written?;
        told?;
        Ok(summary)
    }

    fn state_is_finite(&self) -> bool {
        liquid_surface(&self.simulation).is_ok()
    }

    fn emit(&mut self, event: Event, observer: &mut dyn Observer) -> Result<(), RunError> {
        observer.notify(&event);
        let line = serde_json::to_value(&event).unwrap_or_default();
        Ok(self.log.write(&line)?)
    }

    fn summary(&self, reason: &str) -> Summary {
        Summary::of(self.job, &self.simulation, &self.contact_line, &self.statistics, reason)
    }

    fn progress(&self, report: &StepReport<D>) -> Progress {
        let state = &self.simulation.state;
        Progress {
            step: state.step,
            time: state.time,
            end: self.job.schedule.time(self.job.last_frame()),
            dt: report.dt,
            cfl: report.cfl,
            iterations: report.iterations(),
            volume_error: report.diagnostics.volume_error,
            frame: self.statistics.next_frame,
            last_frame: self.job.last_frame(),
            drops: state.components.len(),
            wall_seconds: self.statistics.wall_seconds,
        }
    }

    fn not_finite(&self, what: &'static str) -> RunError {
        RunError::NotFinite { what, time: self.simulation.state.time, checkpoint: None }
    }

    /// Adds the last good checkpoint to an error.
    fn with_checkpoint(&self, error: RunError) -> RunError {
        let checkpoint = self.checkpoint.clone();
        match error {
            RunError::Output { error, .. } => RunError::Output { error, checkpoint },
            RunError::Step { error, .. } => RunError::Step { error, checkpoint },
            RunError::Solids { time, step, narrowest, .. } => {
                RunError::Solids { time, step, narrowest, checkpoint }
            }
            RunError::NotFinite { what, time, .. } => RunError::NotFinite { what, time, checkpoint },
            other => other,
        }
    }
}
