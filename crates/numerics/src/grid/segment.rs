//! Segments of grid rows.

/// Part of a row: cells `start..end` of row `row`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Segment {
    /// Row number.
    pub row: usize,
    /// First cell, counted along the row.
    pub start: usize,
    /// One past the last cell.
    pub end: usize,
}
