//! `[expect.series]`: bounds of a column of the time series.

use crate::error::SceneError;
use crate::file::text::{Si, Time};
use crate::file::validator::Validator;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// An expected value of a column of `timeseries.csv`: `min`, `max` or both, in the unit of the column.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SeriesBound {
    /// Name of the column, such as `wetted_plate`; docs/columns.md lists them.
    pub column: String,
    /// Which value of the column; `end` by default.
    #[serde(default)]
    pub of: SeriesValue,
    /// Time from which rows count; the start by default.
    #[serde(default, skip_serializing_if = "Option::is_none", with = "Si::<Option<Time>>")]
    pub from: Option<f64>,
    /// Time up to which rows count; the end by default.
    #[serde(default, skip_serializing_if = "Option::is_none", with = "Si::<Option<Time>>")]
    pub until: Option<f64>,
    /// Smallest accepted value, in the SI unit of the column.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub min: Option<f64>,
    /// Largest accepted value, in the SI unit of the column.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max: Option<f64>,
}

/// A value of a column of the time series, of the rows that count and have one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SeriesValue {
    /// The last one.
    #[default]
    End,
    /// The least one.
    Least,
    /// The largest one.
    Largest,
    /// The last one less the first one.
    Change,
    /// The last one over the first one.
    Ratio,
}

impl SeriesBound {
    /// Checks the bounds; `path` is the place of the entry.
    pub(super) fn validate(&self, path: &str, v: &Validator) -> Result<(), SceneError> {
        let [min, max] = [self.min, self.max];
        if min.is_none() && max.is_none() {
            return Err(v.error(path, "the value of the column is not bounded", "give `min`, `max` or both"));
        }
        for (key, bound) in [("min", min), ("max", max)] {
            if bound.is_some_and(|bound| !bound.is_finite()) {
                return Err(v.error(&format!("{path}.{key}"), "this bound is no finite number", "give one"));
            }
        }
        if let (Some(min), Some(max)) = (min, max)
            && min > max
        {
            let message = format!("`max` ({max}) is below `min` ({min})");
            return Err(v.error(&format!("{path}.max"), message, "swap them"));
        }
        for (key, time) in [("from", self.from), ("until", self.until)] {
            time.map_or(Ok(()), |time| v.not_negative(&format!("{path}.{key}"), "a time", time))?;
        }
        if let (Some(from), Some(until)) = (self.from, self.until)
            && from > until
        {
            let message = format!("`until` ({until} s) is before `from` ({from} s)");
            return Err(v.error(&format!("{path}.until"), message, "swap them"));
        }
        Ok(())
    }
}
