//! Failures of a command: a message for the user, an exit status for scripts.

use meniscus_scene::error::{ErrorKind, SceneError};
use meniscus_scene::output::FileError;
use meniscus_scene::run::RunError;
use miette::{Diagnostic, LabeledSpan, NamedSource, SourceCode};
use std::fmt;
use std::path::Path;

/// Wrong usage.
pub const USAGE: u8 = 2;
/// The scene is invalid.
pub const SCENE: u8 = 3;
/// Input or output failed.
pub const OUTPUT: u8 = 4;
/// An expectation or a verification was missed.
pub const MISSED: u8 = 6;
/// Stopped on request, resumable.
pub const STOPPED: u8 = 75;

/// Why a command failed.
#[derive(Debug)]
pub struct Failure {
    /// Exit status.
    pub status: u8,
    message: String,
    help: Option<String>,
    /// The source text and the position of the error in it.
    place: Option<Box<(NamedSource<String>, LabeledSpan)>>,
}

/// A place in a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place<'a> {
    /// The file; `--set` for a setting.
    pub file: &'a str,
    /// Its line, from 1.
    pub line: usize,
    /// The column in characters, from 1.
    pub column: usize,
    /// The text that is wrong.
    pub text: &'a str,
}

/// The result of a command: its exit status.
pub type Result<T = u8> = std::result::Result<T, Failure>;

impl Failure {
    /// A failure with its exit status.
    pub fn new(status: u8, message: impl Into<String>) -> Self {
        Self { status, message: message.into(), help: None, place: None }
    }

    /// The same failure with a help text.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// For `map_err`: a failed operation on a file.
    pub fn file(action: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let of = FileError::of(action, path);
        move |source| of(source).into()
    }

    /// The help text.
    pub fn help_text(&self) -> Option<&str> {
        self.help.as_deref()
    }

    /// Where the error is in a scene, if it is in one.
    pub fn place(&self) -> Option<Place<'_>> {
        let (source, label) = &**self.place.as_ref()?;
        let text = source.inner();
        let (start, end) = (label.offset(), label.offset() + label.len());
        let before = text.get(..start)?;
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        Some(Place {
            file: source.name(),
            line: before.matches('\n').count() + 1,
            column: before[line_start..].chars().count() + 1,
            text: text.get(start..end).unwrap_or_default(),
        })
    }

    /// The failure as one line of JSON.
    pub fn json(&self) -> serde_json::Value {
        serde_json::json!({
            "event": "error", "message": self.message, "help": self.help, "exit_status": self.status,
        })
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Failure {}

impl Diagnostic for Failure {
    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.help.as_ref().map(|help| Box::new(help) as Box<dyn fmt::Display>)
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.place.as_ref().map(|place| &place.0 as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        self.place.as_ref().map(|place| Box::new(std::iter::once(place.1.clone())) as Box<_>)
    }
}

impl From<FileError> for Failure {
    fn from(error: FileError) -> Self {
        Self::new(OUTPUT, error.to_string()).help(error.advice())
    }
}

impl From<RunError> for Failure {
    fn from(error: RunError) -> Self {
        let advice = error.advice();
        let help = match error.checkpoint() {
            Some(path) => format!("last good checkpoint: {}\n{advice}", path.display()),
            None => advice,
        };
        Self::new(error.exit_status(), error.to_string()).help(help)
    }
}

impl From<SceneError> for Failure {
    fn from(error: SceneError) -> Self {
        let mut failure = Self::new(error.exit_status(), error.message.clone());
        failure.help = error.help.clone();
        match &error.span {
            Some(span) => {
                let text = error.source_text.to_string();
                let source = NamedSource::new(&error.source_name, text);
                failure.place = Some(Box::new((source, LabeledSpan::new_with_span(None, span.clone()))));
            }
            None if error.kind == ErrorKind::Invalid && !error.source_name.is_empty() => {
                failure.message = format!("{}: {}", error.source_name, failure.message);
            }
            None => {}
        }
        failure
    }
}
