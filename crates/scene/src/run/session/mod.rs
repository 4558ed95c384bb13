//! The session: the loop of one process over the steps of a run.
//!
//! [`Session::run`] is the whole of it. A caller that looks at the state meanwhile begins, advances from frame to frame, and ends.

mod output;

use super::checkpoint;
use super::error::RunError;
use super::event::{Event, Observer, Progress};
use super::outcome::Outcome;
use super::scene_text::scene_text;
use super::watchdog::{FinishOnDrop, Limits, Watchdog};
use crate::job::{Job, RunStatistics, Stop};
use crate::output::frame::{Frame, FrameExtractor, FrameParts, NotFinite, liquid_surface};
use crate::output::log::Log;
use crate::output::summary::{FINISHED, Summary};
use crate::output::time_series::TimeSeriesWriter;
use crate::output::{FileError, Folder, SolidMeasures, atomic_file};
use meniscus_sim::{ContactLine, Simulation, StepReport};
use std::io::Write;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

/// A function that a session calls with its simulation before each step.
pub type BeforeStep<const D: usize> = Box<dyn FnMut(&mut Simulation<D>) + Send>;

/// A run in this process.
pub struct Session<const D: usize> {
    job: Job,
    folder: Folder,
    before_step: Option<BeforeStep<D>>,
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

/// What a session writes, and where.
pub(super) struct Output<'a> {
    pub(super) job: &'a Job,
    pub(super) folder: &'a Folder,
    /// The log, locked by this process.
    pub(super) log: Log,
}

/// How far [`Session::advance`] came.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Advance {
    /// To the time of this frame.
    Frame(u64),
    /// There is no further frame: the run is complete.
    AtEnd,
    /// A request to stop came before a step.
    StopRequested(Stop),
}

impl<const D: usize> Session<D> {
    /// A new run in a prepared folder.
    pub(super) fn start(simulation: Simulation<D>, output: Output<'_>) -> Result<Self, FileError> {
        let Output { job, folder, .. } = output;
        atomic_file::write_atomically(&folder.scene(), |w| w.write_all(scene_text(job).as_bytes()))?;
        let tally = RunStatistics::at_start(&simulation.model, &simulation.diagnostics());
        let names = || job.solids.iter().map(|s| s.0.as_str());
        let measures = SolidMeasures::new(&simulation, job.solids.len()).columns::<D>(names());
        let series = TimeSeriesWriter::create(&folder.series(), names(), &measures)?;
        Self::open(simulation, tally, series, output, None)
    }

    /// A run that continues from a checkpoint.
    pub(super) fn resume(
        simulation: Simulation<D>,
        tally: RunStatistics,
        series: TimeSeriesWriter,
        output: Output<'_>,
    ) -> Result<Self, FileError> {
        let Output { job, folder, .. } = output;
        atomic_file::write_atomically(&folder.scene(), |w| w.write_all(scene_text(job).as_bytes()))?;
        let time = simulation.state.time;
        Self::open(simulation, tally, series, output, Some(time))
    }

    fn open(
        simulation: Simulation<D>,
        statistics: RunStatistics,
        series: TimeSeriesWriter,
        output: Output<'_>,
        resumed_at: Option<f64>,
    ) -> Result<Self, FileError> {
        let Output { job, folder, log } = output;
        let extractor = FrameExtractor::new(&simulation.model, &job.solids, job.frame_interval);
        Ok(Self {
            job: job.clone(),
            folder: folder.clone(),
            before_step: None,
            contact_line: extractor.contact_line(&simulation),
            extractor,
            checkpoint: checkpoint::list(&folder.checkpoints()).first().cloned(),
            checkpoint_frame: statistics.next_frame,
            checkpoint_time: Instant::now(),
            clock: Instant::now(),
            seconds_before: statistics.wall_seconds,
            log,
            measures: SolidMeasures::new(&simulation, job.solids.len()),
            simulation,
            statistics,
            series,
            resumed_at,
            watchdog: Arc::new(Watchdog::new(Limits::default())),
        })
    }

    /// The simulation in its present state.
    pub fn simulation(&self) -> &Simulation<D> {
        &self.simulation
    }

    /// The contact line of the present state.
    pub fn contact_line(&self) -> &ContactLine<D> {
        &self.contact_line
    }

    /// The frame of the present state, with `parts` of it that are extracted on request only.
    ///
    /// # Errors
    /// [`NotFinite`] if a field or the liquid's surface is not finite.
    pub fn frame(&self, parts: FrameParts) -> Result<Frame, NotFinite> {
        self.extractor.frame(&self.simulation, &self.contact_line, parts)
    }

    /// Number of the next frame.
    pub fn next_frame(&self) -> u64 {
        self.statistics.next_frame
    }

    /// The job of the run.
    pub fn job(&self) -> &Job {
        &self.job
    }

    /// The summary of the present state.
    pub fn present_summary(&self) -> Summary {
        self.summary("running")
    }

    /// Calls a function before each step from now on. What it changes in the simulation is in no checkpoint, so a run is resumed bit for
    /// bit only with the same function.
    pub fn before_each_step(&mut self, function: BeforeStep<D>) {
        self.before_step = Some(function);
    }

    /// Goes on with another job of the same scene, such as one with a longer duration.
    ///
    /// # Errors
    /// [`RunError::OtherScene`] if its results are others, or a failure of the output.
    pub fn set_job(&mut self, job: Job) -> Result<(), RunError> {
        if job.identity != self.job.identity {
            return Err(RunError::OtherScene(self.folder.root().to_path_buf()));
        }
        let next = first_frame_after(&job, self.simulation.state.time, self.statistics.next_frame);
        if next < self.statistics.next_frame {
            self.folder.remove_frames_from(next)?;
            self.statistics.next_frame = next;
        }
        self.job = job;
        let text = scene_text(&self.job);
        atomic_file::write_atomically(&self.folder.scene(), |w| w.write_all(text.as_bytes()))?;
        Ok(())
    }

    /// Runs until the end, a request to stop, or a failure. Another thread watches it if the observer has a remote.
    ///
    /// # Errors
    /// [`RunError`], with the last good checkpoint.
    pub fn run(
        self,
        stop: &(dyn Fn() -> Option<Stop> + Sync),
        observer: &mut dyn Observer,
    ) -> Result<Outcome, RunError> {
        let Some(remote) = observer.remote() else { return self.run_and_end(stop, observer) };
        let (watchdog, log, summary) =
            (Arc::clone(&self.watchdog), self.log.try_clone(), self.folder.summary());
        std::thread::scope(|scope| {
            let _finish = FinishOnDrop(&watchdog);
            let watchdog = &watchdog;
            scope.spawn(move || watchdog.watch(stop, &*remote, log, &summary));
            self.run_and_end(stop, observer)
        })
    }

    fn run_and_end(
        mut self,
        stop: &dyn Fn() -> Option<Stop>,
        observer: &mut dyn Observer,
    ) -> Result<Outcome, RunError> {
        let mut left = self.begin(observer).map(|()| Advance::Frame(0));
        while let Ok(Advance::Frame(_)) = left {
            left = self.advance(stop, observer);
        }
        self.end(left, observer)
    }

    /// Writes the last checkpoint and the summary of a run that was left with this result of [`Self::begin`] or [`Self::advance`].
    /// [`Advance::Frame`] counts as a request of the caller to stop.
    ///
    /// # Errors
    /// The error of the run or that of its last files, with the last good checkpoint.
    pub fn end(
        &mut self,
        left: Result<Advance, RunError>,
        observer: &mut dyn Observer,
    ) -> Result<Outcome, RunError> {
        let left = left.map(|advance| match advance {
            Advance::AtEnd => None,
            Advance::StopRequested(stop) => Some(stop),
            Advance::Frame(_) => Some(Stop::Caller),
        });
        let reason = match &left {
            Ok(None) => FINISHED.to_string(),
            Ok(Some(stop)) => stop.reason().to_string(),
            Err(error) => format!("failed: {error}"),
        };
        // After a failure of the solver the state is the last good one, unless it is not finite.
        let is_state_good = match &left {
            Ok(_) => true,
            Err(error) => error.is_solver_failure() && self.state_is_finite(),
        };
        let reason = if left.is_ok() { Ok(&*reason) } else { Err(&*reason) };
        let closed = self.close(reason, is_state_good, observer);
        match (left, closed) {
            (Err(error), _) => Err(self.with_checkpoint(error)),
            (Ok(_), Err(error)) => Err(self.with_checkpoint(error)),
            (Ok(None), Ok(summary)) => Ok(Outcome::Finished(summary)),
            (Ok(Some(stop)), Ok(summary)) => Ok(Outcome::Stopped(stop, summary)),
        }
    }

    /// Begins or continues the run: a new one writes its first row, frame and checkpoint.
    ///
    /// # Errors
    /// [`RunError`].
    pub fn begin(&mut self, observer: &mut dyn Observer) -> Result<(), RunError> {
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

    /// Steps to the time of the next frame and writes it, unless `stop` asks to stop between two steps.
    ///
    /// # Errors
    /// [`RunError`]; the state is then that before the failed step.
    pub fn advance(
        &mut self,
        stop: &dyn Fn() -> Option<Stop>,
        observer: &mut dyn Observer,
    ) -> Result<Advance, RunError> {
        while self.statistics.next_frame <= self.job.last_frame() {
            if let Some(stop) = stop() {
                return Ok(Advance::StopRequested(stop));
            }
            let report = self.step()?;
            if let Some(message) = self.watchdog.end(report.dt) {
                self.emit(Event::Warning { message }, observer)?;
            }
            observer.notify(&Event::Step(self.progress(&report)));
            let number = self.statistics.next_frame;
            let reached = self.job.schedule.has_reached_frame(self.simulation.state.time, number);
            if reached {
                self.write_frame(observer)?;
            }
            if self.checkpoint_is_due() {
                self.write_checkpoint(observer)?;
            }
            if reached {
                return Ok(Advance::Frame(number));
            }
        }
        Ok(Advance::AtEnd)
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
        if let Some(before) = &mut self.before_step {
            before(&mut self.simulation);
        }
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

    fn state_is_finite(&self) -> bool {
        liquid_surface(&self.simulation).is_ok()
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

/// Number of the frame to write next at a time, when `next` was the next one of an earlier job: the last frame of a shorter run may lie
/// before its time in a longer one.
pub(super) fn first_frame_after(job: &Job, time: f64, next: u64) -> u64 {
    (0..next).rev().find(|frame| job.schedule.has_reached_frame(time, *frame)).map_or(0, |frame| frame + 1)
}
