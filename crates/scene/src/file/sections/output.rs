//! `[output]`: duration of the run, and the files that it writes.

use crate::error::SceneError;
use crate::file::text::{Si, Time};
use crate::file::validator::Validator;
use crate::output::frame::Format;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `[output]`: duration of the run, and the files that it writes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Output {
    /// Simulated time of the run, above 0.
    #[serde(with = "Si::<Time>")]
    pub duration: f64,
    /// Simulated time between frames, above 0; a hundredth of the duration by default.
    #[serde(default, skip_serializing_if = "Option::is_none", with = "Si::<Option<Time>>")]
    pub frame_interval: Option<f64>,
    /// Formats of the output; `ply` and `page` by default. `ply` is always written.
    #[serde(default = "default_formats")]
    pub formats: Vec<Format>,
    /// Number of frames between checkpoints, 1 or more; 20 by default. A checkpoint is also written when the
    /// last one is a minute old.
    #[serde(default = "default_checkpoint_every")]
    pub checkpoint_every: usize,
}

fn default_formats() -> Vec<Format> {
    vec![Format::Ply, Format::Page]
}

fn default_checkpoint_every() -> usize {
    20
}

impl Output {
    /// Simulated time between frames, s.
    pub fn frame_interval(&self) -> f64 {
        self.frame_interval.unwrap_or(self.duration / 100.0)
    }

    /// Checks the section of a scene, and makes its defaults explicit.
    ///
    /// # Errors
    /// [`SceneError`] at the value.
    pub(in crate::file) fn validate(&mut self, v: &mut Validator) -> Result<(), SceneError> {
        v.positive("output.duration", "the duration", self.duration)?;
        let path = "output.frame_interval";
        let interval = self.frame_interval();
        v.positive(path, "the time between frames", interval)?;
        if self.duration / interval > 1e6 {
            let message = "this interval gives more than a million frames";
            return Err(v.error(path, message, "use a longer interval"));
        }
        if interval > self.duration {
            let message =
                "the frame interval exceeds the duration: only the first and the last frame are written";
            v.warn(path, message);
        }
        self.frame_interval = Some(interval);
        if let Some(i) = self.formats.iter().position(|format| *format == Format::Vdb).filter(|_| v.dim == 2)
        {
            let message = "the format `vdb` is for scenes of 3 dimensions";
            let help = "use \"vti\" for the fields of a scene of 2 dimensions";
            return Err(v.error(&format!("output.formats.{i}"), message, help));
        }
        self.formats.push(Format::Ply);
        self.formats.sort_unstable();
        self.formats.dedup();
        if self.checkpoint_every == 0 {
            let message = "the number of frames between checkpoints is 0";
            return Err(v.error("output.checkpoint_every", message, "give a number of frames of at least 1"));
        }
        Ok(())
    }
}
