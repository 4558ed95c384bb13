//! Errors: those of the command, as Python exceptions with the same text, help and place.

use meniscus_cli::Failure;
use pyo3::create_exception;
use pyo3::exceptions::{PyException, PyValueError};
use pyo3::prelude::*;

create_exception!(
    meniscus,
    MeniscusError,
    PyException,
    "An error of Meniscus.\n\nAttributes: ``message``, ``help`` (str or None), ``status`` (int, the exit status of the command), and where \
     the error is in a scene ``file``, ``line``, ``column`` (from 1) and ``text``, else None."
);
create_exception!(meniscus, SceneError, MeniscusError, "The scene is invalid, or a setting of it is.");
create_exception!(meniscus, OutputError, MeniscusError, "A file or a folder could not be read or written.");
create_exception!(
    meniscus,
    SolverError,
    MeniscusError,
    "The solver cannot continue; the last good checkpoint is kept."
);

/// Exit status of wrong usage.
const USAGE: u8 = 2;

/// The exception of a failure.
pub fn exception(py: Python<'_>, failure: &Failure) -> PyErr {
    let mut text = failure.to_string();
    let place = failure.place();
    if let Some(place) = &place {
        text += &format!("\n  --> {}:{}:{}: {}", place.file, place.line, place.column, place.text);
    }
    if let Some(help) = failure.help_text() {
        text += &format!("\n  help: {help}");
    }
    let error = match failure.status {
        USAGE => PyValueError::new_err(text),
        3 => SceneError::new_err(text),
        4 => OutputError::new_err(text),
        5 => SolverError::new_err(text),
        _ => MeniscusError::new_err(text),
    };
    let value = error.value(py);
    // An exception takes any attribute; one that could not be set would only be missing.
    let _ = value.setattr("message", failure.to_string());
    let _ = value.setattr("help", failure.help_text());
    let _ = value.setattr("status", failure.status);
    let _ = value.setattr("file", place.map(|p| p.file));
    let _ = value.setattr("line", place.map(|p| p.line));
    let _ = value.setattr("column", place.map(|p| p.column));
    let _ = value.setattr("text", place.map(|p| p.text));
    error
}

/// Turns what fails as a command does into a Python exception.
pub trait OrRaise<T> {
    /// The value, or the exception.
    fn or_raise(self, py: Python<'_>) -> PyResult<T>;
}

impl<T, E: Into<Failure>> OrRaise<T> for Result<T, E> {
    fn or_raise(self, py: Python<'_>) -> PyResult<T> {
        self.map_err(|error| exception(py, &error.into()))
    }
}
