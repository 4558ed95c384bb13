//! Reads `timeseries.csv` as columns of numbers.

use std::path::Path;

use serde::Serialize;

use crate::error::{Result, ViewError};

/// Largest number of rows for plots.
const MAX_PLOT_ROWS: usize = 4000;

/// The columns of a time series, in SI units and degrees; numbers are rounded to seven digits.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct TimeSeries {
    /// Names of the columns.
    pub names: Vec<String>,
    /// Values of the columns; `null` for an empty cell.
    pub columns: Vec<Vec<Option<f64>>>,
    /// Number of rows in the file.
    pub rows: usize,
    /// Stride of the kept rows.
    pub stride: usize,
}

impl TimeSeries {
    /// Reads a file, thinned for plots; a missing file gives no columns.
    pub(crate) fn load_for_plots(path: &Path) -> Result<Self> {
        Self::of_file(path, MAX_PLOT_ROWS)
    }

    /// Reads every row of a file; a missing file gives no columns.
    ///
    /// # Errors
    /// [`ViewError`] if the file cannot be read.
    pub fn load_all(path: &Path) -> Result<Self> {
        Self::of_file(path, usize::MAX)
    }

    fn of_file(path: &Path, most: usize) -> Result<Self> {
        if !path.is_file() {
            return Ok(Self { stride: 1, ..Self::default() });
        }
        Ok(Self::parse(&std::fs::read_to_string(path).map_err(ViewError::io(path))?, most))
    }

    /// The values of a column; `None` if there is no such column.
    pub fn column(&self, name: &str) -> Option<&[Option<f64>]> {
        let place = self.names.iter().position(|n| n == name)?;
        Some(&self.columns[place])
    }

    /// Parses a file, thinned to about `most` rows. Rows with a wrong number of cells, such as one being written, are skipped.
    pub(crate) fn parse(text: &str, most: usize) -> Self {
        let mut lines = text.lines();
        let names: Vec<String> = lines
            .next()
            .unwrap_or("")
            .split(',')
            .map(|c| c.trim().to_string())
            .filter(|c| !c.is_empty())
            .collect();
        let rows: Vec<Vec<&str>> =
            lines.map(|l| l.split(',').collect()).filter(|r: &Vec<&str>| r.len() == names.len()).collect();
        let stride = rows.len().div_ceil(most).max(1);
        let last = rows.len().saturating_sub(1);
        let kept: Vec<usize> = (0..rows.len()).filter(|i| i % stride == 0 || *i == last).collect();
        let column = |c: usize| kept.iter().map(|&r| parse_rounded(rows[r][c])).collect();
        Self { columns: (0..names.len()).map(column).collect(), names, rows: rows.len(), stride }
    }
}

/// Parses a number and rounds it to seven digits, enough for plots.
fn parse_rounded(cell: &str) -> Option<f64> {
    let x: f64 = cell.trim().parse().ok()?;
    if !x.is_finite() {
        return None;
    }
    format!("{x:.6e}").parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn empty_cells_and_cut_rows() {
        let s = TimeSeries::parse("step,time,angle\n0,0,\n1,0.1,89.5\n2,0.2,nan\n3,0.", MAX_PLOT_ROWS);
        assert_eq!(s.names, ["step", "time", "angle"]);
        assert_eq!(s.columns[2], [None, Some(89.5), None]);
        assert_eq!(s.rows, 3);
        assert_eq!(TimeSeries::parse("", MAX_PLOT_ROWS).names.len(), 0);
    }

    #[test]
    fn long_series_are_thinned_and_keep_the_end() {
        let text: String =
            std::iter::once("step\n".to_string()).chain((0..10_001).map(|i| format!("{i}\n"))).collect();
        let s = TimeSeries::parse(&text, MAX_PLOT_ROWS);
        assert_eq!(s.stride, 3);
        assert!(s.columns[0].len() <= MAX_PLOT_ROWS + 1);
        assert_eq!(s.columns[0].last(), Some(&Some(10_000.0)));
    }
}
