//! Runs that are read from their folders.

use crate::arrays::{Kind, array};
use crate::errors::{OrRaise, exception};
use crate::frame::{Frame, Snapshot};
use meniscus_cli::{DEFAULT_PAGE_MB, Failure, make_page, stored_frame};
use meniscus_scene::output::frame::Frame as FrameContent;
use meniscus_scene::output::time_series::TimeSeries;
use meniscus_scene::output::{FileError, Folder};
use meniscus_view::RunFolder;
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::{Path, PathBuf};

/// Exit status of failed input or output.
const OUTPUT: u8 = 4;

/// A run that is read from its folder; made by ``meniscus.open``.
///
/// ``len(run)`` is the number of its frames, ``run[k]`` is the k-th of them, and ``for frame in run`` reads them one after another. Frames
/// from files have surfaces and contact lines, but no fields, elements and sums.
#[pyclass(frozen, module = "meniscus", name = "Run")]
pub struct StoredRun {
    path: PathBuf,
    run: RunFolder,
}

/// Opens the output folder of a run, for reading.
#[pyfunction]
#[pyo3(name = "open")]
pub fn open_run(py: Python<'_>, folder: PathBuf) -> PyResult<StoredRun> {
    let run = py.detach(|| RunFolder::open(&folder)).map_err(|error| {
        let failure = Failure::new(OUTPUT, error.to_string());
        exception(py, &failure.help("give the output folder of a run, such as out/my-scene"))
    })?;
    Ok(StoredRun { path: folder, run })
}

#[pymethods]
impl StoredRun {
    /// The folder.
    #[getter]
    fn folder(&self) -> &Path {
        &self.path
    }

    /// 2 or 3.
    #[getter]
    fn dimension(&self) -> usize {
        self.run.dimension
    }

    /// The content of ``summary.json``, a dict.
    #[getter]
    fn summary(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        stored_summary(py, &Folder::at(&self.path))
    }

    /// The time series: a dict of arrays (steps,) of float64 by the name of the column, nan where a row has no value.
    #[getter]
    fn series<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        series(py, &Folder::at(&self.path))
    }

    /// Numbers of the frames, as in the names of their files.
    #[getter]
    fn frame_numbers(&self) -> Vec<u32> {
        self.run.frame_numbers.clone()
    }

    /// Writes the page of the run, ``page/index.html``, and returns its path.
    fn page(&self, py: Python<'_>) -> PyResult<PathBuf> {
        py.detach(|| make_page(&self.path, 1, DEFAULT_PAGE_MB)).or_raise(py)
    }

    fn __len__(&self) -> usize {
        self.run.frame_numbers.len()
    }

    fn __getitem__(&self, py: Python<'_>, index: isize) -> PyResult<Frame> {
        let all = &self.run.frame_numbers;
        let at = if index < 0 { all.len().checked_add_signed(index) } else { usize::try_from(index).ok() };
        let number = at.and_then(|at| all.get(at)).copied();
        let number =
            number.ok_or_else(|| PyIndexError::new_err(format!("the run has {} frames", all.len())))?;
        let content = py.detach(|| stored_frame(&self.run, number)).or_raise(py)?;
        let angles = mean_angles(&content);
        Ok(Snapshot { content, number: Some(u64::from(number)), step: None, ledger: None, angles }.into())
    }

    fn __repr__(&self) -> String {
        format!("<meniscus.Run in {}: {} frames>", self.path.display(), self.run.frame_numbers.len())
    }
}

/// Mean contact angle on each solid, degrees, each point of the line with half the length of the edges next to it.
fn mean_angles(frame: &FrameContent) -> Vec<Option<f64>> {
    let Some(line) = &frame.contact_line else { return vec![None; frame.solids.len()] };
    let mut lengths = vec![if line.edges.is_empty() { 1.0 } else { 0.0 }; line.positions.len()];
    for [a, b] in line.edges.iter().map(|edge| edge.map(|v| v as usize)) {
        let (p, q) = (line.positions[a], line.positions[b]);
        let length = (0..3).map(|k| (p[k] - q[k]).powi(2)).sum::<f64>().sqrt();
        lengths[a] += 0.5 * length;
        lengths[b] += 0.5 * length;
    }
    let (Some(angles), Some(solids)) = (line.values("angle"), line.values("solid")) else {
        return vec![None; frame.solids.len()];
    };
    let mean = |solid: usize| {
        let (mut sum, mut length) = (0.0, 0.0);
        for (v, weight) in lengths.iter().enumerate().filter(|(v, _)| solids[*v] as usize == solid) {
            sum += weight * angles[v];
            length += weight;
        }
        (length > 0.0).then(|| sum / length)
    };
    (0..frame.solids.len()).map(mean).collect()
}

/// The text of JSON as Python has it. Python's own reader keeps the last bit of every number.
pub fn json_value(py: Python<'_>, text: &str) -> PyResult<Py<PyAny>> {
    Ok(py.import("json")?.call_method1("loads", (text,))?.unbind())
}

/// The summary in a folder.
pub fn stored_summary(py: Python<'_>, folder: &Folder) -> PyResult<Py<PyAny>> {
    let path = folder.summary();
    let text = std::fs::read_to_string(&path).map_err(FileError::of("read", &path)).or_raise(py)?;
    json_value(py, &text)
}

/// The time series of a folder, by the names of its columns in their order.
pub fn series<'py>(py: Python<'py>, folder: &Folder) -> PyResult<Bound<'py, PyDict>> {
    let path = folder.series();
    let read = py.detach(|| std::fs::read_to_string(&path).map_err(FileError::of("read", &path)));
    let text = read.or_raise(py)?;
    let parsed = py.detach(|| TimeSeries::parse(&text));
    let columns = PyDict::new(py);
    for name in text.lines().next().unwrap_or_default().split(',') {
        let values = parsed.column(name);
        columns.set_item(name, array(py, values, Kind::Float, vec![values.len()])?)?;
    }
    Ok(columns)
}
