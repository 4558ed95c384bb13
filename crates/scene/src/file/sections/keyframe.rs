//! Keyframes of a prescribed motion.

use crate::error::SceneError;
use crate::file::text::{Length, Si, Time};
use crate::file::validator::Validator;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Prescribed displacement at one time.
#[derive(Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Keyframe {
    /// Time; it increases from one keyframe to the next.
    #[serde(with = "Si::<Time>")]
    pub time: f64,
    /// Displacement from the position at the start.
    #[serde(with = "Si::<Vec<Length>>")]
    pub translate: Vec<f64>,
}

/// The text that enters the identity of a scene.
impl fmt::Debug for Keyframe {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(&(self.time, &self.translate), f)
    }
}

impl Keyframe {
    /// Checks the keyframes of the table at `path`.
    ///
    /// # Errors
    /// [`SceneError`] at the value.
    pub(super) fn validate(path: &str, keyframes: &[Self], v: &Validator) -> Result<(), SceneError> {
        let mut previous: Option<&Self> = None;
        for (i, keyframe) in keyframes.iter().enumerate() {
            let (time, translate) =
                (format!("{path}.keyframes.{i}.time"), format!("{path}.keyframes.{i}.translate"));
            if previous.is_some_and(|before| before.time >= keyframe.time) {
                let message = "the time of this keyframe is not later than that of the previous one";
                return Err(v.error(&time, message, "sort the keyframes by time"));
            }
            v.dimension(&translate, &keyframe.translate)?;
            if let Some(before) = previous {
                let moves = keyframe.translate.iter().zip(&before.translate);
                let distance = moves.map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
                v.prescribed_speed(&translate, distance / (keyframe.time - before.time))?;
            }
            previous = Some(keyframe);
        }
        Ok(())
    }

    /// Checks a motion that is prescribed by keyframes or by a velocity and an angular velocity, which are zero by default.
    ///
    /// # Errors
    /// [`SceneError`] at the value.
    pub(super) fn validate_or_velocities(
        path: &str,
        keyframes: &[Self],
        [velocity, angular_velocity]: [&mut Vec<f64>; 2],
        v: &Validator,
    ) -> Result<(), SceneError> {
        let at = |key: &str| format!("{path}.{key}");
        let (linear, angular) = (at("velocity"), at("angular_velocity"));
        let components = if v.dim == 2 { 1 } else { 3 };
        if !v.source.has(&angular) {
            *angular_velocity = vec![0.0; components];
        }
        if angular_velocity.len() != components {
            let message = format!("found {} entries in the angular velocity", angular_velocity.len());
            let help = format!("give {components} in a scene of {} dimensions", v.dim);
            return Err(v.error(&angular, message, help));
        }
        Self::validate(path, keyframes, v)?;
        if !keyframes.is_empty() && (v.source.has(&linear) || v.source.has(&angular)) {
            return Err(v.error(path, "both a velocity and keyframes are given", "remove one of them"));
        }
        v.vector_or_zero(&linear, velocity)?;
        v.prescribed_speed(&linear, velocity.iter().map(|v| v * v).sum::<f64>().sqrt())
    }
}
