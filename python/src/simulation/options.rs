//! How a run is started.

use crate::session::Acceleration;
use meniscus_cli::Failure;
use meniscus_scene::run::ExistingRun;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::{Arc, Mutex};

/// Stack of a thread, bytes; that of a main thread.
const THREAD_STACK_BYTES: usize = 8 << 20;

/// Comment in the scene of a run with gravity of its own.
pub const GRAVITY_NOTE: &str =
    "# Gravity was a function of time, given in Python: this file alone does not repeat the run.\n";

/// The options of a start.
#[derive(Default)]
pub struct StartOptions {
    /// Whether a run in the folder goes on.
    resume: bool,
    /// Whether it is replaced.
    force: bool,
    /// The end, with its unit.
    pub until: Option<String>,
    /// Number of threads.
    threads: Option<usize>,
    /// Gravity as a function of time.
    pub gravity: Option<Py<PyAny>>,
}

impl StartOptions {
    /// The options of named arguments.
    pub fn of(given: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let mut options = Self::default();
        for (name, value) in given.into_iter().flat_map(|given| given.iter()) {
            match name.extract::<String>()?.as_str() {
                "resume" => options.resume = value.extract()?,
                "force" => options.force = value.extract()?,
                "until" => options.until = value.extract()?,
                "threads" => options.threads = value.extract()?,
                "gravity" => options.gravity = Some(value.unbind()).filter(|g| !g.is_none(name.py())),
                other => {
                    return Err(PyTypeError::new_err(format!(
                        "start() has no argument `{other}`; it has out, resume, force, until, threads, gravity"
                    )));
                }
            }
        }
        Ok(options)
    }

    /// What happens to a run in the folder.
    pub fn existing(&self) -> PyResult<ExistingRun> {
        match (self.resume, self.force) {
            (true, true) => {
                Err(PyValueError::new_err("both resume and force are given: a run goes on or is replaced"))
            }
            (true, false) => Ok(ExistingRun::Resume),
            (false, true) => Ok(ExistingRun::Replace),
            (false, false) => Ok(ExistingRun::Refuse),
        }
    }

    /// The threads of the run.
    pub fn pool(&self) -> Result<rayon::ThreadPool, Failure> {
        let threads = self.threads.unwrap_or(0);
        let pool =
            rayon::ThreadPoolBuilder::new().num_threads(threads).stack_size(THREAD_STACK_BYTES).build();
        pool.map_err(|e| Failure::new(1, format!("cannot start the threads: {e}")))
    }
}

/// An acceleration that a Python function returns; its first error is kept.
pub fn acceleration(function: Py<PyAny>, error: &Arc<Mutex<Option<PyErr>>>) -> Acceleration {
    let error = Arc::clone(error);
    Box::new(move |time| {
        let found = Python::attach(|py| {
            let found: Vec<f64> = function.call1(py, (time,))?.extract(py)?;
            if found.iter().all(|x| x.is_finite()) {
                return Ok(found);
            }
            Err(PyValueError::new_err(format!("gravity({time}) is not finite")))
        });
        match (found, error.lock()) {
            (Ok(found), _) => Some(found),
            (Err(new), Ok(mut kept)) => {
                kept.get_or_insert(new);
                None
            }
            (Err(_), Err(_)) => None,
        }
    })
}
