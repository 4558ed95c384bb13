//! Keyframes of a prescribed motion, as written in a scene file.

use super::quantity::{Length, Time};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Prescribed displacement at one time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct KeyframeFile {
    /// Time; it increases from one keyframe to the next.
    pub time: Time,
    /// Displacement from the position at the start.
    pub translate: Vec<Length>,
}

impl KeyframeFile {
    /// Keyframes of times, s, and displacements, m.
    pub fn list(keyframes: &[(f64, Vec<f64>)]) -> Vec<Self> {
        let of = |(time, translate): &(f64, Vec<f64>)| Self {
            time: Time(*time),
            translate: translate.iter().map(|&x| Length::metres(x)).collect(),
        };
        keyframes.iter().map(of).collect()
    }
}
