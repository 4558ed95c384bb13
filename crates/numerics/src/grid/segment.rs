//! Stretches of cells of a row.

/// Part of a row: cells `start..end` of row `row`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Segment {
    /// Row number.
    pub row: usize,
    /// First cell of the row.
    pub start: usize,
    /// One past the last.
    pub end: usize,
}
