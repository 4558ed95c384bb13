//! `timeseries.csv`: one row per step.

use super::SolidMeasures;
use super::atomic_file::FileError;
use crate::job::padded_to_3d;
use meniscus_sim::{ContactLine, Simulation, StepReport};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs::{File, OpenOptions};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// The columns: first those of the format's contract, then those of Meniscus.
pub const COLUMNS: &[&str] = &[
    "step",
    "time",
    "dt",
    "cfl",
    "liquid_volume",
    "kinetic_energy",
    "surface_energy",
    "elastic_energy",
    "potential_energy",
    "max_speed",
    "momentum_x",
    "momentum_y",
    "momentum_z",
    "contact_points",
    "contact_length",
    "contact_angle_mean",
    "contact_angle_std",
    "divergence_max",
    "solve_iterations",
    "wall_seconds",
    "volume_error",
    "momentum_error",
    "angular_momentum_x",
    "angular_momentum_y",
    "angular_momentum_z",
    "centroid_x",
    "centroid_y",
    "centroid_z",
    "drops",
    "drop_lower_x",
    "drop_lower_y",
    "drop_lower_z",
    "drop_upper_x",
    "drop_upper_y",
    "drop_upper_z",
    "redone",
    "residual",
    "line_distance",
    "least_element",
    "volume_shift",
    "deleted_volume",
    "momentum_restored",
    "clamped_curvatures",
    "unconverged",
    "outflow_volume",
    "outflow_kinetic_energy",
    "outflow_stored_energy",
    "newton_iterations",
];

/// Columns of the liquid's force on a solid, N (2D: N/m).
pub fn force_columns(solid: &str) -> impl Iterator<Item = String> {
    ["x", "y", "z"].into_iter().map(move |axis| format!("force_{solid}_{axis}"))
}

/// Values of a row that depend on the whole run so far, not on its step alone.
pub struct RunValues {
    /// Relative momentum error at the end of the step.
    pub momentum_error: f64,
    /// Wall time of the run so far, s.
    pub wall_seconds: f64,
}

/// A row: the state after a step, the step's report, what the run adds, and the measures of the named solids. Numbers round-trip bit for bit.
pub fn row<const D: usize>(
    simulation: &Simulation<D>,
    report: &StepReport<D>,
    line: &ContactLine<D>,
    run: &RunValues,
    measures: &SolidMeasures,
) -> String {
    let state = &simulation.state;
    let ledger = &report.diagnostics;
    let mut row = state.step.to_string();
    put(&mut row, &[state.time, report.dt, report.cfl]);
    put(&mut row, &[ledger.volume, ledger.kinetic_energy, ledger.surface_energy, ledger.elastic_energy]);
    put(&mut row, &[ledger.potential_energy, ledger.max_speed]);
    put(&mut row, &padded_to_3d(&ledger.momentum));
    put_line(&mut row, line);
    put(&mut row, &[ledger.divergence_max]);
    let _ = write!(row, ",{},{:.3}", report.iterations(), run.wall_seconds);
    put(&mut row, &[ledger.volume_error, run.momentum_error]);
    put(&mut row, &ledger.angular_momentum);
    put(&mut row, &padded_to_3d(&ledger.centroid));
    let _ = write!(row, ",{}", state.components.len());
    match state.components.iter().max_by(|a, b| a.volume.total_cmp(&b.volume)) {
        Some(largest) => {
            put(&mut row, &padded_to_3d(&largest.lower));
            put(&mut row, &padded_to_3d(&largest.upper));
        }
        None => row.push_str(",,,,,,"),
    }
    let _ = write!(row, ",{}", report.repairs.redone);
    put(&mut row, &[report.solves.pressure[1].residual]);
    put_known(&mut row, line.line_distance_cells);
    put_known(&mut row, ledger.least_element);
    let repairs = &report.repairs;
    put(&mut row, &[repairs.volume_shift, repairs.deleted_volume, repairs.momentum_restored]);
    let _ = write!(row, ",{},{}", repairs.clamped_curvatures, repairs.unconverged());
    put(&mut row, &[state.outflow_volume, state.outflow_kinetic_energy, state.outflow_stored_energy]);
    let _ = write!(row, ",{}", report.newton_iterations);
    for now in &state.solids[..measures.solids()] {
        put(&mut row, &padded_to_3d(&(now.pressure_force + now.contact_line_force)));
    }
    row += &measures.cells(simulation, line);
    row.push('\n');
    row
}

/// Columns of the contact line; empty without one.
fn put_line<const D: usize>(row: &mut String, line: &ContactLine<D>) {
    row.push(',');
    if !line.points.is_empty() {
        let _ = write!(row, "{}", line.points.len());
    }
    put_known(row, line.length());
    let angle = line.angle_statistics(None);
    put_known(row, angle.map(|a| a.0));
    put_known(row, angle.map(|a| a.1));
}

fn put_known(row: &mut String, value: Option<f64>) {
    match value {
        Some(value) => put(row, &[value]),
        None => row.push(','),
    }
}

fn put(row: &mut String, values: &[f64]) {
    for value in values {
        let _ = write!(row, ",{value:?}");
    }
}

/// The file, open for appending.
pub struct TimeSeriesWriter {
    path: PathBuf,
    writer: BufWriter<File>,
    bytes: u64,
}

impl TimeSeriesWriter {
    /// Creates the file with its header row: [`COLUMNS`], the force on each solid of these names, and the columns of their measures.
    ///
    /// # Errors
    /// [`FileError`].
    pub fn create<'a>(
        path: &Path,
        solids: impl Iterator<Item = &'a str>,
        measures: &[String],
    ) -> Result<Self, FileError> {
        let file = File::create(path).map_err(FileError::of("write", path))?;
        let mut series = Self { path: path.to_path_buf(), writer: BufWriter::new(file), bytes: 0 };
        let names = COLUMNS.iter().map(|c| (*c).to_owned()).chain(solids.flat_map(force_columns));
        let names = names.chain(measures.iter().cloned());
        series.append(&(names.collect::<Vec<_>>().join(",") + "\n"))?;
        Ok(series)
    }

    /// Opens the file of an earlier run and cuts it to its length at a checkpoint; `None` if it is shorter.
    ///
    /// # Errors
    /// [`FileError`].
    pub fn reopen(path: &Path, bytes: u64) -> Result<Option<Self>, FileError> {
        let fail = |source| FileError { action: "write", path: path.to_path_buf(), source };
        if std::fs::metadata(path).map_or(0, |m| m.len()) < bytes {
            return Ok(None);
        }
        let file = OpenOptions::new().append(true).open(path).map_err(fail)?;
        file.set_len(bytes).map_err(fail)?;
        Ok(Some(Self { path: path.to_path_buf(), writer: BufWriter::new(file), bytes }))
    }

    /// Appends a row.
    ///
    /// # Errors
    /// [`FileError`].
    pub fn append(&mut self, row: &str) -> Result<(), FileError> {
        self.writer.write_all(row.as_bytes()).map_err(FileError::of("write", &self.path))?;
        self.bytes += row.len() as u64;
        Ok(())
    }

    /// Syncs all rows to the disk. Returns the length of the file, bytes.
    ///
    /// # Errors
    /// [`FileError`].
    pub fn sync(&mut self) -> Result<u64, FileError> {
        let synced = self.writer.flush().and_then(|()| self.writer.get_ref().sync_data());
        synced.map_err(FileError::of("write", &self.path))?;
        Ok(self.bytes)
    }
}

/// A time series as columns of numbers; an empty cell is NaN.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TimeSeries {
    columns: BTreeMap<String, Vec<f64>>,
}

impl TimeSeries {
    /// Reads a file.
    ///
    /// # Errors
    /// [`FileError`].
    pub fn read(path: &Path) -> Result<Self, FileError> {
        Ok(Self::parse(&std::fs::read_to_string(path).map_err(FileError::of("read", path))?))
    }

    /// Parses the text of a file. Truncated rows are left out.
    pub fn parse(text: &str) -> Self {
        let mut lines = text.lines();
        let names: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
        let mut columns = vec![Vec::new(); names.len()];
        for line in lines {
            let cells: Vec<f64> = line.split(',').map(|c| c.parse().unwrap_or(f64::NAN)).collect();
            if cells.len() == names.len() {
                columns.iter_mut().zip(cells).for_each(|(column, cell)| column.push(cell));
            }
        }
        Self { columns: names.into_iter().map(String::from).zip(columns).collect() }
    }

    /// A column by name; empty if there is none.
    pub fn column(&self, name: &str) -> &[f64] {
        self.columns.get(name).map_or(&[], Vec::as_slice)
    }
}
