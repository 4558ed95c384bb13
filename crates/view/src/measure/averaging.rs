//! Time series and vertex kinds of a measured frame.

use crate::folder::Frame;
use crate::measure::time_window::TimeWindow;
use crate::page::time_series::TimeSeries;

/// The time series, and the averaging window that ends with the frame.
pub(super) struct Averaging {
    pub series: TimeSeries,
    pub window: Option<TimeWindow>,
}

/// Kind of each vertex of the liquid: 0 liquid–air, 1 liquid–solid, 2 contact line.
pub(super) fn vertex_kinds(frame: &Frame) -> Vec<u8> {
    let kinds = frame.liquid.scalars.get("kind").map_or(&[][..], Vec::as_slice);
    kinds.iter().map(|&k| k as u8).collect()
}
