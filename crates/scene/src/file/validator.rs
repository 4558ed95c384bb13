//! The validator of a scene: checks that all its sections use, with errors that point at the value.

use super::text::{Source, short};
use crate::error::{SceneError, nearest};
use std::f64::consts::PI;
use std::path::{Path, PathBuf};

/// Speed of sound in air, m/s.
const SPEED_OF_SOUND: f64 = 343.0;

/// A warning.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Warning {
    /// Dotted path of the value.
    pub path: String,
    /// Message.
    pub message: String,
}

/// Checks of a scene. All take the dotted path of a value, at which their errors point.
pub struct Validator {
    /// Source positions of the scene.
    pub source: Source,
    /// Folder that the paths of files are relative to.
    pub base: PathBuf,
    /// Number of dimensions, once the domain is valid.
    pub dim: usize,
    /// Cell size, m, once the domain is valid.
    pub dx: f64,
    /// Size of the domain, m, once the domain is valid.
    pub size: Vec<f64>,
    /// Warnings so far.
    pub warnings: Vec<Warning>,
}

/// Paths of keys under a table.
pub fn under(path: &str, table: &str) -> impl Fn(&str) -> String {
    let path = format!("{path}.{table}");
    move |key| format!("{path}.{key}")
}

impl Validator {
    /// A validator that knows no grid yet.
    pub fn new(source: Source, base: &Path) -> Self {
        Self { source, base: base.to_owned(), dim: 0, dx: f64::NAN, size: Vec::new(), warnings: Vec::new() }
    }

    /// An error at a value.
    pub fn error(&self, path: &str, message: impl Into<String>, help: impl Into<String>) -> SceneError {
        self.source.at_value(SceneError::new(message).with_help(help), path)
    }

    /// Adds a warning.
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

    /// Refuses a number that is not above zero.
    pub fn positive(&self, path: &str, what: &str, value: f64) -> Result<(), SceneError> {
        if value > 0.0 && value.is_finite() {
            return Ok(());
        }
        let message = format!("{what} must be above zero, not {value}");
        Err(self.error(path, message, "give a value above zero"))
    }

    /// Refuses a negative number.
    pub fn not_negative(&self, path: &str, what: &str, value: f64) -> Result<(), SceneError> {
        if value >= 0.0 && value.is_finite() {
            return Ok(());
        }
        Err(self.error(path, format!("{what} must not be negative: {value}"), "give zero or more"))
    }

    /// Refuses a number outside of a range.
    pub fn within(
        &self,
        path: &str,
        what: &str,
        value: f64,
        [low, high]: [f64; 2],
    ) -> Result<(), SceneError> {
        if value >= low && value <= high {
            return Ok(());
        }
        let help = format!("accepted: {low} to {high}");
        Err(self.error(path, format!("{what} is {value}, out of range"), help))
    }

    /// Checks a contact angle, rad.
    pub fn angle(&self, path: &str, angle: f64) -> Result<(), SceneError> {
        if (0.0..=PI).contains(&angle) {
            return Ok(());
        }
        let message = format!("a contact angle of {} deg is out of range", short(angle.to_degrees()));
        Err(self.error(path, message, "accepted: \"0 deg\" to \"180 deg\", through the liquid"))
    }

    /// Checks the number of entries of a vector.
    pub fn dimension(&self, path: &str, vector: &[f64]) -> Result<(), SceneError> {
        self.count(path, vector.len())
    }

    /// Checks the number of entries that a vector has in the text.
    pub fn entries(&self, path: &str) -> Result<(), SceneError> {
        self.count(path, (0..).take_while(|i| self.source.has(&format!("{path}.{i}"))).count())
    }

    fn count(&self, path: &str, found: usize) -> Result<(), SceneError> {
        if found == self.dim {
            return Ok(());
        }
        let message = format!("found {found} entries, but the scene has {} dimensions", self.dim);
        Err(self.error(path, message, format!("give {} entries", self.dim)))
    }

    /// Checks a vector, which is zero where the scene does not give it.
    pub fn vector_or_zero(&self, path: &str, vector: &mut Vec<f64>) -> Result<(), SceneError> {
        if vector.is_empty() && !self.source.has(path) {
            *vector = vec![0.0; self.dim];
        }
        self.dimension(path, vector)
    }

    /// Checks lengths along each axis, m, which are above zero.
    pub fn sizes(&self, path: &str, what: &str, sizes: &[f64]) -> Result<(), SceneError> {
        self.dimension(path, sizes)?;
        let mut each = sizes.iter().enumerate();
        each.try_for_each(|(i, size)| self.positive(&format!("{path}.{i}"), what, *size))
    }

    /// Makes a vector one of unit length. A vector of unit length is left as it is, bit for bit.
    pub fn direction(&self, path: &str, vector: &mut [f64], entries: usize) -> Result<(), SceneError> {
        if vector.len() != entries {
            let message = format!("found {} entries in this direction vector", vector.len());
            return Err(self.error(path, message, format!("give {entries} entries")));
        }
        let largest = vector.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        if !(largest > 0.0 && largest.is_finite()) || vector.iter().any(|v| !v.is_finite()) {
            let help = "give finite numbers without units that are not all zero";
            return Err(self.error(path, "this vector does not define a direction", help));
        }
        let norm = vector.iter().map(|v| (v / largest).powi(2)).sum::<f64>().sqrt() * largest;
        if (norm - 1.0).abs() >= 1e-12 {
            vector.iter_mut().for_each(|v| *v = *v / largest / (norm / largest));
        }
        Ok(())
    }

    /// Refuses a prescribed speed above the speed of sound in air (m/s): liquids are not incompressible there.
    pub fn prescribed_speed(&self, path: &str, speed: f64) -> Result<(), SceneError> {
        if speed <= SPEED_OF_SOUND {
            return Ok(());
        }
        let message =
            format!("the prescribed speed of {} m/s is above the speed of sound in air", short(speed));
        let help = "reduce the velocity, or give the displacement more time";
        Err(self.error(&self.source.first_inside(path), message, help))
    }

    /// Returns an error if no solid has this name; it points at the key or at the value.
    pub fn known_solid(&self, path: &str, key: bool, name: &str, names: &[&str]) -> Result<(), SceneError> {
        if names.contains(&name) {
            return Ok(());
        }
        let near = nearest(name, names.iter().copied().chain(key.then_some("liquid_air")));
        let near = near.map_or_else(String::new, |n| format!("did you mean `{n}`? "));
        let list = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
        let error = SceneError::new(format!("there is no solid `{}`", name.escape_debug()))
            .with_help(format!("{near}solids of this scene: {list}"));
        Err(if key { self.source.at_key(error, path) } else { self.source.at_value(error, path) })
    }

    /// The path of an existing file that a scene names; `None` if there is none.
    pub fn existing_file(&self, name: &Path) -> Option<PathBuf> {
        std::fs::canonicalize(self.base.join(name)).ok().filter(|file| file.is_file())
    }
}
