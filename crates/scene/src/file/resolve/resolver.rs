//! The state of the resolution of a scene, and the checks that all its parts share.

use crate::error::SceneError;
use crate::file::grammar::{Angle, Length, Speed, short};
use crate::file::resolved::Warning;
use crate::file::source::Source;
use std::f64::consts::PI;
use std::path::PathBuf;

/// State of the resolution of a scene.
pub struct Resolver {
    pub source: Source,
    pub base: PathBuf,
    pub dim: usize,
    pub dx: f64,
    pub size: Vec<f64>,
    pub warnings: Vec<Warning>,
}

impl Resolver {
    pub fn error(&self, path: &str, message: impl Into<String>, help: impl Into<String>) -> SceneError {
        self.source.at_value(SceneError::new(message).with_help(help), path)
    }

    pub fn warn(&mut self, path: &str, message: impl Into<String>) {
        self.warnings.push(Warning { path: path.to_owned(), message: message.into() });
    }

    /// Refuses a name that is not safe as a file name.
    pub fn check_file_name(&self, path: &str, name: &str) -> Result<(), SceneError> {
        let fine = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
        if name.is_empty() || name.len() > 100 || name.starts_with('.') || !name.chars().all(fine) {
            let message = format!("the name `{}` cannot be used as a file name", name.escape_debug());
            let help = "use at most 100 characters: letters, digits, `-`, `_` and, except at the start, `.`";
            return Err(self.error(path, message, help));
        }
        Ok(())
    }

    pub fn positive(&self, path: &str, what: &str, value: f64) -> Result<f64, SceneError> {
        if value > 0.0 && value.is_finite() {
            return Ok(value);
        }
        let message = format!("{what} must be above zero, not {value}");
        Err(self.error(path, message, "give a value above zero"))
    }

    pub fn not_negative(&self, path: &str, what: &str, value: f64) -> Result<f64, SceneError> {
        if value >= 0.0 && value.is_finite() {
            return Ok(value);
        }
        Err(self.error(path, format!("{what} must not be negative: {value}"), "give zero or more"))
    }

    pub fn within(&self, path: &str, what: &str, value: f64, low: f64, high: f64) -> Result<f64, SceneError> {
        if value >= low && value <= high {
            return Ok(value);
        }
        let help = format!("accepted: {low} to {high}");
        Err(self.error(path, format!("{what} is {value}, out of range"), help))
    }

    /// A contact angle, rad.
    pub fn angle(&self, path: &str, angle: Angle) -> Result<f64, SceneError> {
        if (0.0..=PI).contains(&angle.0) {
            return Ok(angle.0);
        }
        let message = format!("a contact angle of {} deg is out of range", short(angle.0.to_degrees()));
        Err(self.error(path, message, "accepted: \"0 deg\" to \"180 deg\", through the liquid"))
    }

    /// A length above zero.
    pub fn positive_length(&self, path: &str, what: &str, value: Length) -> Result<f64, SceneError> {
        self.positive(path, what, value.resolve(self.dx))
    }

    /// Checks the number of entries of a vector.
    pub fn check_dimension(&self, path: &str, found: usize) -> Result<(), SceneError> {
        if found == self.dim {
            return Ok(());
        }
        let message = format!("found {found} entries, but the scene has {} dimensions", self.dim);
        Err(self.error(path, message, format!("give {} entries", self.dim)))
    }

    /// A point or displacement, m.
    pub fn point(&self, path: &str, value: &[Length]) -> Result<Vec<f64>, SceneError> {
        self.check_dimension(path, value.len())?;
        Ok(value.iter().map(|l| l.resolve(self.dx)).collect())
    }

    pub fn velocity(&self, path: &str, value: Option<&Vec<Speed>>) -> Result<Vec<f64>, SceneError> {
        let Some(v) = value else { return Ok(vec![0.0; self.dim]) };
        self.check_dimension(path, v.len())?;
        Ok(v.iter().map(|s| s.0).collect())
    }
}
