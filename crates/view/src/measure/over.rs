//! What a frame is measured over.

use crate::folder::Frame;
use crate::measure::window::Window;
use crate::page::series::Series;

/// The time series, and its window that ends with the frame.
pub(super) struct Over {
    pub series: Series,
    pub window: Option<Window>,
}

/// For each vertex of the liquid 0 liquid–air, 1 liquid–solid, 2 contact line.
pub(super) fn kinds(frame: &Frame) -> Vec<u8> {
    let kinds = frame.liquid.scalars.get("kind").map_or(&[][..], Vec::as_slice);
    kinds.iter().map(|&k| k as u8).collect()
}
