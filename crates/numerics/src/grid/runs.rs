//! Runs: the cells of one kind as a sorted list of stretches along the first axis.

/// A stretch of consecutive cells of one row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Run {
    /// Row number: `index / cells[0]`.
    pub row: u32,
    /// First cell of the row that belongs to the run.
    pub start: u32,
    /// One past the last.
    pub end: u32,
    /// Connected component it belongs to.
    pub component: u32,
}

/// A set of cells as runs, sorted by row, then by start; runs of a row do not touch.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Runs {
    /// The runs.
    pub runs: Vec<Run>,
    /// Number of connected components (face neighbours).
    pub components: u32,
}

impl Runs {
    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.runs.iter().map(|r| (r.end - r.start) as usize).sum()
    }
}
