//! Time averages of a solid's force and of its other columns in the time series.
//!
//! The force of a single step fluctuates by up to a third of a drop's weight even when the drop is at rest. Both the value of the
//! last step and the mean over a window that ends with the frame are reported.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::page::time_series::TimeSeries;

/// Default length of a window as a share of the simulated time.
const DEFAULT_WINDOW_SHARE: f64 = 0.1;
/// Relative difference of two times attributed to rounding to seven digits.
const TIME_TOLERANCE: f64 = 1e-6;

/// The rows of the time series in a time window.
#[derive(Clone, Debug, Serialize)]
pub struct TimeWindow {
    /// Start, excluded, s.
    pub from: f64,
    /// End, included, s; the time of the frame.
    pub to: f64,
    /// Number of steps.
    pub steps: usize,
    /// Indices of the rows in the series.
    #[serde(skip)]
    rows: Vec<usize>,
}

/// Statistics of a quantity over a window, in its own unit, weighted by the step lengths.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TimeStatistics {
    /// Mean.
    pub mean: f64,
    /// Standard deviation.
    pub std: f64,
    /// Smallest.
    pub least: f64,
    /// Largest.
    pub largest: f64,
}

impl TimeWindow {
    /// The window of the given length (s; default a tenth of the simulated time) that ends at time `to` of a frame. `None` if it
    /// contains no step.
    pub(super) fn of(series: &TimeSeries, to: f64, length: Option<f64>) -> Option<Self> {
        let times = series.column("time")?;
        let end = times.iter().flatten().copied().fold(0.0, f64::max);
        let from = (to - length.unwrap_or(DEFAULT_WINDOW_SHARE * end)).max(0.0);
        let within = |t: f64| t > from && t <= to + TIME_TOLERANCE * to.abs();
        let rows: Vec<usize> = (0..times.len()).filter(|row| times[*row].is_some_and(within)).collect();
        (!rows.is_empty()).then_some(Self { from, to, steps: rows.len(), rows })
    }

    /// The statistics of a column; `None` without values in the window.
    pub(super) fn mean(&self, series: &TimeSeries, column: &str) -> Option<TimeStatistics> {
        let (values, steps) = (series.column(column)?, series.column("dt"));
        let weight = |row: usize| steps.and_then(|dt| dt[row]).unwrap_or(1.0);
        let known: Vec<(f64, f64)> =
            self.rows.iter().filter_map(|row| Some((weight(*row), values[*row]?))).collect();
        let all: f64 = known.iter().map(|(w, _)| w).sum();
        if all <= 0.0 {
            return None;
        }
        let mean = known.iter().map(|(w, v)| w * v).sum::<f64>() / all;
        let square = known.iter().map(|(w, v)| w * (v - mean).powi(2)).sum::<f64>() / all;
        let values = || known.iter().map(|k| k.1);
        Some(TimeStatistics {
            mean,
            std: square.sqrt(),
            least: values().fold(f64::INFINITY, f64::min),
            largest: values().fold(f64::NEG_INFINITY, f64::max),
        })
    }

    /// The statistics of all columns of a solid, without its name in the keys: `force_x`, `angle_left`, `base_radius`, ….
    pub(super) fn of_solid(&self, series: &TimeSeries, solid: &str) -> BTreeMap<String, TimeStatistics> {
        let own = |column: &String| Some((quantity(column, solid)?, self.mean(series, column)?));
        series.names.iter().filter_map(own).collect()
    }
}

/// The row of a time in the series.
pub(super) fn row_at(series: &TimeSeries, time: f64) -> Option<usize> {
    series
        .column("time")?
        .iter()
        .position(|t| t.is_some_and(|t| (t - time).abs() <= TIME_TOLERANCE * time.abs()))
}

/// The quantity of a column `QUANTITY_SOLID` or `QUANTITY_SOLID_PART` of this solid; `None` for other columns.
fn quantity(column: &str, solid: &str) -> Option<String> {
    let parts = |quantity: &'static str, parts: &'static [&'static str]| {
        let rest = column.strip_prefix(quantity)?.strip_prefix('_')?.strip_prefix(solid)?;
        let part = if rest.is_empty() { rest } else { rest.strip_prefix('_')? };
        parts.contains(&part).then(|| format!("{quantity}{}{part}", if part.is_empty() { "" } else { "_" }))
    };
    let axes = &["x", "y", "z"][..];
    parts("force", axes)
        .or_else(|| parts("tip", axes))
        .or_else(|| parts("angle", &["left", "right", "mean", "least", "largest"]))
        .or_else(|| parts("base_radius", &[""]))
        .or_else(|| parts("wetted", &[""]))
        .or_else(|| parts("deflection", &[""]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_belong_to_their_solid() {
        assert_eq!(quantity("force_a_x", "a").as_deref(), Some("force_x"));
        assert_eq!(quantity("force_a_b_x", "a"), None, "that of the solid `a_b`");
        assert_eq!(quantity("base_radius_a", "a").as_deref(), Some("base_radius"));
        assert_eq!(quantity("angle_a_left", "a").as_deref(), Some("angle_left"));
        assert_eq!(quantity("angle_a_left", "b"), None);
    }

    #[test]
    fn steps_count_by_their_length() {
        let text = "time,dt,force_a_x\n0,0,9\n1,1,9\n2,1,2\n4,2,5\n4.5,0.5,\n";
        let series = TimeSeries::parse(text, 100);
        let window = TimeWindow::of(&series, 4.5, Some(3.5)).unwrap_or_else(|| panic!("no window"));
        assert_eq!(window.steps, 3);
        let mean = TimeStatistics { mean: 4.0, std: 2f64.sqrt(), least: 2.0, largest: 5.0 };
        assert_eq!(window.of_solid(&series, "a"), BTreeMap::from([("force_x".to_owned(), mean)]));
        assert!(TimeWindow::of(&series, 0.0, Some(3.5)).is_none(), "no step has been done");
        assert!(TimeWindow::of(&series, 4.5, None).is_some_and(|w| (w.from - 4.05).abs() < 1e-12));
    }
}
