//! A run that Python steps from frame to frame.

mod options;
mod waiting;

pub use options::StartOptions;

use crate::errors::{OrRaise, exception};
use crate::frame::Frame;
use crate::session::{AnySession, Warnings};
use crate::stored::{json_value, series, stored_summary};
use meniscus_cli::{
    DEFAULT_PAGE_MB, Failure, SceneArgs, check_runnable, conclude, duration, load, make_page, prepare, show,
};
use meniscus_scene::build::AnySetup;
use meniscus_scene::file::{Expect, Scene as SceneFile};
use meniscus_scene::output::Folder;
use meniscus_scene::output::frame::Format;
use meniscus_scene::output::summary::Summary;
use meniscus_scene::run::{Advance, Job, Outcome, Stop};
use options::GRAVITY_NOTE;
use pyo3::exceptions::{PyKeyboardInterrupt, PyRuntimeError, PyUserWarning};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::ffi::CString;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, TryLockError};
use waiting::{Interrupted, wait};

/// Relative difference of times that counts as rounding.
const TIME_TOLERANCE: f64 = 1e-12;

/// Part of the identity of a run with gravity of its own, so that nothing resumes it that does not have the function.
const GRAVITY_MARK: u64 = 0x6772_6176_6974_7921;

/// A run that is stepped from frame to frame; made by ``Scene.start``, best in a ``with`` statement.
///
/// At the end of the ``with`` statement the run is closed as ``meniscus run`` closes it: one that reached its end gets its summary, pictures
/// and page; one that was left before gets a checkpoint, from which ``resume=True`` goes on with the same bits. Ctrl-C ends it between two
/// steps with a checkpoint, and raises ``KeyboardInterrupt``. Other threads of Python go on during steps.
#[pyclass(frozen, module = "meniscus")]
pub struct Simulation {
    folder: Folder,
    args: SceneArgs,
    /// Duration of the scene without `until`, s; `[expect]` is about it.
    whole: f64,
    has_gravity: bool,
    pool: rayon::ThreadPool,
    run: Mutex<Run>,
}

/// What changes in a run.
struct Run {
    session: Option<AnySession>,
    scene: SceneFile,
    /// Whether there is something to write at the end.
    has_advanced: bool,
    /// The last frame that was handed out.
    handed_out: Option<u64>,
    summary: Option<Summary>,
    /// An error of the caller's function, which ends the run.
    function_error: Arc<Mutex<Option<PyErr>>>,
    warnings: Warnings,
}

/// A scene that is ready to run.
struct Ready {
    scene: SceneFile,
    setup: AnySetup,
    job: Job,
}

/// Loads and builds a scene with more settings. `[expect]` is about the duration `whole`, s: a shorter run is not checked against it.
fn ready(args: &SceneArgs, more: &[String], whole: f64, has_gravity: bool) -> Result<Ready, Failure> {
    let mut scene = load(args, more)?.scene;
    if scene.output.duration < whole * (1.0 - 1e-9) {
        scene.expect = Expect::default();
    }
    check_runnable(&scene)?;
    let (setup, mut job) = prepare(&scene)?;
    if has_gravity {
        job.identity ^= GRAVITY_MARK;
        job.text = format!("{GRAVITY_NOTE}{}", job.text);
    }
    Ok(Ready { scene, setup, job })
}

impl Simulation {
    /// Opens a folder for a run.
    pub fn start(
        py: Python<'_>,
        args: SceneArgs,
        out: Option<PathBuf>,
        options: StartOptions,
    ) -> PyResult<Self> {
        let pool = py.detach(|| options.pool()).or_raise(py)?;
        let (existing, has_gravity) = (options.existing()?, options.gravity.is_some());
        let sets: Vec<String> = options.until.iter().map(|until| duration(until)).collect();
        let mut warnings = Warnings::default();
        let opened = py.detach(|| {
            let whole = load(&args, &[])?.scene;
            let folder = out.unwrap_or_else(|| Path::new("out").join(&whole.name));
            let folder = Folder::at(&folder);
            let made = pool.install(|| {
                let Ready { scene, setup, job } = ready(&args, &sets, whole.output.duration, has_gravity)?;
                let opened = AnySession::open(&setup, &job, &folder, existing, &mut warnings)?;
                Ok::<_, Failure>((scene, opened))
            });
            made.map(|(scene, opened)| (folder, whole.output.duration, scene, opened))
        });
        let (folder, whole, scene, (mut session, finished)) = opened.or_raise(py)?;
        let function_error = Arc::default();
        if let Some(gravity) = options.gravity {
            session.set_gravity(options::acceleration(gravity, &function_error));
        }
        let has_advanced = finished.is_none();
        let run = Run {
            session: Some(session),
            scene,
            has_advanced,
            handed_out: None,
            summary: finished,
            function_error,
            warnings,
        };
        let made = Self { folder, args, whole, has_gravity, pool, run: Mutex::new(run) };
        if has_advanced {
            made.begin(py)?;
        }
        Ok(made)
    }

    fn begin(&self, py: Python<'_>) -> PyResult<()> {
        let mut run = self.run()?;
        let run: &mut Run = &mut run;
        let begun = py.detach(|| {
            let Run { session, warnings, .. } = &mut *run;
            session.as_mut().map_or(Ok(()), |session| self.pool.install(|| session.begin(warnings)))
        });
        match begun {
            Ok(()) => run.tell_warnings(py),
            Err(error) => {
                let ended = py.detach(|| self.end(run, Err(error)));
                ended.map(drop).or_raise(py)
            }
        }
    }

    /// What changes; an error where another thread has it.
    fn run(&self) -> PyResult<MutexGuard<'_, Run>> {
        match self.run.try_lock() {
            Ok(run) => Ok(run),
            Err(TryLockError::Poisoned(run)) => Ok(run.into_inner()),
            Err(TryLockError::WouldBlock) => {
                Err(PyRuntimeError::new_err("another thread is stepping this simulation"))
            }
        }
    }

    /// Goes to the next frame; none at the end.
    fn next(&self, py: Python<'_>, until: f64) -> PyResult<Option<Frame>> {
        let mut run = self.run()?;
        let session = run.session.as_ref().ok_or_else(closed)?;
        let (present, at_end) = (session.present_frame(), session.time() >= until * (1.0 - TIME_TOLERANCE));
        let is_new = present.is_some() && present != run.handed_out;
        if !is_new && (at_end || !self.advance(py, &mut run)?) {
            return Ok(None);
        }
        run.frame(py).map(Some)
    }

    /// Steps to the next frame. Returns whether there was one. A run that cannot go on is closed.
    fn advance(&self, py: Python<'_>, run: &mut Run) -> PyResult<bool> {
        run.has_advanced = true;
        let function_error = Arc::clone(&run.function_error);
        let failed = move || function_error.lock().is_ok_and(|error| error.is_some());
        let Run { session, warnings, .. } = &mut *run;
        let session = session.as_mut().ok_or_else(closed)?;
        let Interrupted { value: left, error } = wait(py, |stop| {
            let asked = || stop().then_some(Stop::Signal).or_else(|| failed().then_some(Stop::Caller));
            self.pool.install(|| session.advance(&asked, warnings))
        });
        match left {
            Ok(Advance::Frame(_)) if error.is_none() => run.tell_warnings(py).map(|()| true),
            Ok(Advance::AtEnd) if error.is_none() => Ok(false),
            left => {
                // A frame that was reached when Ctrl-C came is a place to stop, too.
                let left = left.map(|at| if at == Advance::AtEnd { at } else { stopped(error.is_some()) });
                py.detach(|| self.end(run, left)).or_raise(py)?;
                let own = run.function_error.lock().ok().and_then(|mut error| error.take());
                Err(error.or(own).unwrap_or_else(|| PyKeyboardInterrupt::new_err(())))
            }
        }
    }

    /// Closes the session as a run is closed.
    fn end(
        &self,
        run: &mut Run,
        left: Result<Advance, meniscus_scene::run::RunError>,
    ) -> Result<(), Failure> {
        let Some(mut session) = run.session.take() else { return Ok(()) };
        let outcome = self.pool.install(|| session.end(left, &mut run.warnings))?;
        drop(session);
        match outcome {
            Outcome::Finished(mut summary) => {
                let shown = self.pool.install(|| {
                    conclude(&run.scene, &mut summary, &self.folder)?;
                    if run.scene.output.formats.contains(&Format::Page) {
                        show(self.folder.root(), summary.frames, true)?;
                    }
                    Ok(())
                });
                run.summary = Some(summary);
                shown
            }
            Outcome::Stopped(_, summary) | Outcome::AlreadyFinished(summary) => {
                run.summary = Some(summary);
                Ok(())
            }
        }
    }

    /// Makes the run end at a time. Returns it, s.
    fn set_end(&self, py: Python<'_>, until: Option<String>) -> PyResult<f64> {
        let mut run = self.run()?;
        let session = run.session.as_mut().ok_or_else(closed)?;
        let Some(until) = until else { return Ok(session.end_time()) };
        let interval = format!("output.frame_interval=\"{:?} s\"", session.job_frame_interval());
        let sets = [duration(&until), interval];
        let end = py.detach(|| load(&self.args, &sets)).or_raise(py)?.scene.output.duration;
        if end <= session.time() || end == session.end_time() {
            return Ok(end);
        }
        let done = py.detach(|| {
            let Ready { scene, job, .. } = ready(&self.args, &sets, self.whole, self.has_gravity)?;
            session.set_job(job)?;
            Ok::<_, Failure>(scene)
        });
        run.scene = done.or_raise(py)?;
        run.has_advanced = true;
        Ok(end)
    }
}

/// The request to stop of Ctrl-C, or of the calling program.
fn stopped(by_signal: bool) -> Advance {
    Advance::StopRequested(if by_signal { Stop::Signal } else { Stop::Caller })
}

fn closed() -> PyErr {
    PyRuntimeError::new_err("this simulation is closed; start it again with resume=True to go on")
}

impl Run {
    fn tell_warnings(&mut self, py: Python<'_>) -> PyResult<()> {
        for message in std::mem::take(&mut self.warnings.0) {
            let text = CString::new(message.replace('\0', " ")).unwrap_or_default();
            PyErr::warn(py, &py.get_type::<PyUserWarning>(), &text, 1)?;
        }
        Ok(())
    }

    /// The frame of the present state.
    fn frame(&mut self, py: Python<'_>) -> PyResult<Frame> {
        let session = self.session.as_mut().ok_or_else(closed)?;
        let snapshot = py.detach(|| session.snapshot());
        let snapshot = snapshot.map_err(|error| exception(py, &Failure::new(5, error.to_string())))?;
        self.handed_out = snapshot.number.or(self.handed_out);
        Ok(snapshot.into())
    }
}

#[pymethods]
impl Simulation {
    /// The frames of the run, one after another: first that of the present state, if its time is that of a frame and it was not handed out,
    /// then each that the run steps to. ``until`` (such as ``"32 ms"``) makes the run end there.
    #[pyo3(signature = (until = None))]
    fn frames(slf: Py<Self>, py: Python<'_>, until: Option<String>) -> PyResult<Frames> {
        let end = slf.get().set_end(py, until)?;
        Ok(Frames { simulation: slf, end })
    }

    /// Runs to the end, or to the time ``until``.
    #[pyo3(signature = (until = None))]
    fn run_to_end(&self, py: Python<'_>, until: Option<String>) -> PyResult<()> {
        let end = self.set_end(py, until)?;
        let mut run = self.run()?;
        while run.session.as_ref().ok_or_else(closed)?.time() < end * (1.0 - TIME_TOLERANCE) {
            if !self.advance(py, &mut run)? {
                break;
            }
        }
        Ok(())
    }

    /// The frame of the present state.
    #[getter]
    fn frame(&self, py: Python<'_>) -> PyResult<Frame> {
        let mut run = self.run()?;
        let handed_out = run.handed_out;
        let frame = run.frame(py)?;
        run.handed_out = handed_out;
        Ok(frame)
    }

    /// Simulated time, s.
    #[getter]
    fn time(&self) -> PyResult<f64> {
        let run = self.run()?;
        let at_end = || run.summary.as_ref().map_or(0.0, |summary| summary.simulated_seconds);
        Ok(run.session.as_ref().map_or_else(at_end, AnySession::time))
    }

    /// Number of steps done.
    #[getter]
    fn steps(&self) -> PyResult<u64> {
        let run = self.run()?;
        let at_end = || run.summary.as_ref().map_or(0, |summary| summary.steps);
        Ok(run.session.as_ref().map_or_else(at_end, AnySession::steps))
    }

    /// The output folder.
    #[getter]
    fn folder(&self) -> PathBuf {
        self.folder.root().to_path_buf()
    }

    /// Whether the run was closed.
    #[getter]
    fn is_closed(&self) -> PyResult<bool> {
        Ok(self.run()?.session.is_none())
    }

    /// The summary now, as in ``summary.json``: a dict.
    #[getter]
    fn summary(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let run = self.run()?;
        match run.session.as_ref().filter(|_| run.has_advanced) {
            Some(session) => json_value(py, &serde_json::json!(session.summary()).to_string()),
            None => stored_summary(py, &self.folder),
        }
    }

    /// The time series so far, as in ``timeseries.csv``: a dict of arrays (steps,) of float64 by the name of the column, nan where a row
    /// has no value.
    #[getter]
    fn series<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let mut run = self.run()?;
        if let Some(session) = &mut run.session {
            session.sync_series().or_raise(py)?;
        }
        series(py, &self.folder)
    }

    /// Writes the page of the run, ``page/index.html``, and returns its path.
    fn page(&self, py: Python<'_>) -> PyResult<PathBuf> {
        py.detach(|| make_page(self.folder.root(), 1, DEFAULT_PAGE_MB)).or_raise(py)
    }

    /// Closes the run. Nothing happens if it is closed already.
    fn close(&self, py: Python<'_>) -> PyResult<()> {
        self.close_by(py, false)
    }

    fn __enter__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    fn __exit__(
        &self,
        py: Python<'_>,
        kind: &Bound<'_, PyAny>,
        _value: &Bound<'_, PyAny>,
        _traceback: &Bound<'_, PyAny>,
    ) -> PyResult<bool> {
        self.close_by(py, kind.is(py.get_type::<PyKeyboardInterrupt>()))?;
        Ok(false)
    }

    fn __repr__(&self) -> String {
        format!("<meniscus.Simulation in {}>", self.folder.root().display())
    }
}

impl Simulation {
    fn close_by(&self, py: Python<'_>, signal: bool) -> PyResult<()> {
        let mut run = self.run()?;
        let run: &mut Run = &mut run;
        let Some(session) = &run.session else { return Ok(()) };
        if !run.has_advanced {
            run.session = None;
            return Ok(());
        }
        let left = if session.is_complete() { Advance::AtEnd } else { stopped(signal) };
        py.detach(|| self.end(run, Ok(left))).or_raise(py)?;
        run.tell_warnings(py)
    }
}

/// The frames of a run, an iterator.
#[pyclass(frozen, module = "meniscus")]
pub struct Frames {
    simulation: Py<Simulation>,
    end: f64,
}

#[pymethods]
impl Frames {
    fn __iter__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    fn __next__(&self, py: Python<'_>) -> PyResult<Option<Frame>> {
        self.simulation.get().next(py, self.end)
    }
}
