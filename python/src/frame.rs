//! A frame as Python sees it.

use crate::arrays::{Cache, Kind, array, array_first_axis_fastest};
use crate::errors::OrRaise;
use crate::mesh::{Mesh, Part, Solid};
use meniscus_cli::Failure;
use meniscus_scene::output::frame::{Format, Frame as FrameContent, FrameFields};
use meniscus_scene::output::{FileError, Folder, atomic_file};
use meniscus_sim::Diagnostics;
use pyo3::exceptions::{PyAttributeError, PyKeyError};
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use std::path::Path;
use std::sync::Arc;

/// Sums over the liquid and the solids at the time of a frame, in SI units; in 2D per metre of depth.
#[pyclass(frozen, get_all, module = "meniscus")]
#[derive(Clone, Debug)]
pub struct Ledger {
    /// Volume of the liquid, m^3 (2D: m^2).
    pub volume: f64,
    /// Sum of the absolute errors of the volumes of all drops over the volume of the liquid, with the sign of the net error.
    pub volume_error: f64,
    /// Centre of mass of the liquid, m: a tuple of 2 or 3 numbers.
    pub centroid: Vec<f64>,
    /// Momentum of the liquid, kg m/s (2D: kg/s).
    pub momentum: Vec<f64>,
    /// Kinetic energy of the liquid and of the solids that move freely, J (2D: J/m).
    pub kinetic_energy: f64,
    /// Surface energy, J (2D: J/m).
    pub surface_energy: f64,
    /// Elastic energy, J (2D: J/m).
    pub elastic_energy: f64,
    /// Potential energy in the field of gravity, J (2D: J/m).
    pub potential_energy: f64,
    /// Largest speed of the liquid along an axis, m/s.
    pub max_speed: f64,
    /// Largest divergence in a liquid cell, 1/s.
    pub max_divergence: f64,
}

impl<const D: usize> From<Diagnostics<D>> for Ledger {
    fn from(of: Diagnostics<D>) -> Self {
        Self {
            volume: of.volume,
            volume_error: of.volume_error,
            centroid: of.centroid.iter().copied().collect(),
            momentum: of.momentum.iter().copied().collect(),
            kinetic_energy: of.kinetic_energy,
            surface_energy: of.surface_energy,
            elastic_energy: of.elastic_energy,
            potential_energy: of.potential_energy,
            max_speed: of.max_speed,
            max_divergence: of.divergence_max,
        }
    }
}

/// The data of a frame, before it becomes a [`Frame`] of Python.
pub struct Snapshot {
    /// Its content.
    pub content: FrameContent,
    /// Number among the frames of the run; none between two.
    pub number: Option<u64>,
    /// Steps done, where they are known.
    pub step: Option<u64>,
    /// Sums, where they are known.
    pub ledger: Option<Ledger>,
    /// Mean contact angle on each solid, degrees; none without a contact line on it.
    pub angles: Vec<Option<f64>>,
}

/// The surfaces, the contact line, the fields and the sums of a run at one time.
///
/// A frame does not change when its run goes on. All numbers are in SI units, angles in degrees; vectors have three components, the third
/// of which is 0 in 2D. Arrays are read-only.
#[pyclass(frozen, module = "meniscus")]
pub struct Frame {
    content: Arc<FrameContent>,
    number: Option<u64>,
    step: Option<u64>,
    ledger: Option<Ledger>,
    angles: Vec<Option<f64>>,
    cache: Cache,
}

impl From<Snapshot> for Frame {
    fn from(of: Snapshot) -> Self {
        let Snapshot { content, number, step, ledger, angles } = of;
        Self { content: Arc::new(content), number, step, ledger, angles, cache: Cache::default() }
    }
}

impl Frame {
    fn solid_number(&self, name: &str) -> PyResult<usize> {
        self.content.solids.iter().position(|(own, _)| own == name).ok_or_else(|| {
            let names: Vec<&str> = self.content.solids.iter().map(|s| s.0.as_str()).collect();
            PyKeyError::new_err(format!("there is no solid `{name}`; there are: {}", names.join(", ")))
        })
    }

    fn fields(&self) -> PyResult<&FrameFields> {
        let message = "a frame that was read from files has no fields, since files of surfaces have none";
        self.content.fields.as_ref().ok_or_else(|| PyAttributeError::new_err(message))
    }

    /// Numbers of cells along the axes, two in 2D.
    fn extent(&self) -> PyResult<Vec<usize>> {
        Ok(self.fields()?.extent[..self.dimension()].to_vec())
    }

    fn field<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let (fields, mut shape) = (self.fields()?, self.extent()?);
        let found = fields.attributes.iter().find(|a| a.name == name);
        let Some(found) = found else { return Err(PyAttributeError::new_err(format!("no field `{name}`"))) };
        let cells: usize = shape.iter().product();
        self.cache.get(py, name, || {
            if found.values.len() == cells {
                return array_first_axis_fastest(py, &found.values, Kind::Float, shape);
            }
            shape.insert(0, found.values.len() / cells.max(1));
            let all = array_first_axis_fastest(py, &found.values, Kind::Float, shape)?;
            py.import("numpy")?.call_method1("moveaxis", (all, 0, -1))
        })
    }
}

#[pymethods]
impl Frame {
    /// Time, s.
    #[getter]
    fn time(&self) -> f64 {
        self.content.time
    }

    /// Number among the frames of the run, as in the names of its files; None for the state between two frames.
    #[getter]
    fn number(&self) -> Option<u64> {
        self.number
    }

    /// Number of steps done; None in a frame that was read from files.
    #[getter]
    fn step(&self) -> Option<u64> {
        self.step
    }

    /// 2 or 3.
    #[getter]
    fn dimension(&self) -> usize {
        self.content.up_axis + 1
    }

    /// Names of the solids, in the order of the scene.
    #[getter]
    fn solids(&self) -> Vec<String> {
        self.content.solids.iter().map(|(name, _)| name.clone()).collect()
    }

    /// The solid of this name.
    fn solid(&self, name: &str) -> PyResult<Solid> {
        Ok(Solid::new(&self.content, self.solid_number(name)?))
    }

    /// A surface: that of the ``"liquid"``, of the ``"contact_line"``, or of the solid of this name.
    fn mesh(&self, name: &str) -> PyResult<Mesh> {
        let part = match (name, self.solid_number(name)) {
            (_, Ok(number)) => Part::Solid(number),
            ("liquid", _) => Part::Liquid,
            ("contact_line", _) if self.content.contact_line.is_some() => Part::Line,
            ("contact_line", _) => {
                return Err(PyKeyError::new_err("nothing is wetted in this frame: it has no contact line"));
            }
            (_, Err(error)) => return Err(error),
        };
        Ok(Mesh::new(&self.content, part))
    }

    /// The contact line with ``angle`` (deg), ``speed`` (m/s), ``fx``, ``fy``, ``fz`` (N/m) and ``solid`` (number) at its vertices; None
    /// where nothing is wetted. In 2D it consists of points.
    #[getter]
    fn contact_line(&self) -> Option<Mesh> {
        self.content.contact_line.as_ref().map(|_| Mesh::new(&self.content, Part::Line))
    }

    /// Mean contact angle through the liquid on a solid, degrees, along its contact line; nan without one.
    fn angle(&self, solid: &str) -> PyResult<f64> {
        let number = self.solid_number(solid)?;
        Ok(self.angles.get(number).copied().flatten().unwrap_or(f64::NAN))
    }

    /// Signed distance to the liquid's surface at the centres of the cells, m, negative in the liquid: array (nx, ny[, nz]) of float64. It
    /// is a distance within five cells of the surface only.
    #[getter]
    fn phi<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.field(py, "phi")
    }

    /// Velocity at the centres of the cells, m/s: array (nx, ny[, nz], 3) of float64, valid in the liquid and a few cells around it, half
    /// a step ahead of the positions.
    #[getter]
    fn velocity<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.field(py, "velocity")
    }

    /// Pressure at the centres of the cells, Pa (2D: N/m): array (nx, ny[, nz]) of float64; 0 outside the liquid and before the first step.
    #[getter]
    fn pressure<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.field(py, "pressure")
    }

    /// Centres of the cells along each axis, m: a tuple of 2 or 3 arrays of float64.
    #[getter]
    fn axes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let fields = self.fields()?;
        let along = |(axis, count): (usize, usize)| {
            let at: Vec<f64> = (0..count).map(|i| fields.first[axis] + i as f64 * fields.dx).collect();
            array(py, &at, Kind::Float, vec![count])
        };
        let all = self.extent()?.into_iter().enumerate().map(along).collect::<PyResult<Vec<_>>>()?;
        PyTuple::new(py, all)
    }

    /// Size of a cell, m.
    #[getter]
    fn dx(&self) -> PyResult<f64> {
        Ok(self.fields()?.dx)
    }

    /// Volume, momentum and energies.
    #[getter]
    fn ledger(&self) -> PyResult<Ledger> {
        let message = "a frame that was read from files has no sums; the time series of its run has them";
        self.ledger.clone().ok_or_else(|| PyAttributeError::new_err(message))
    }

    /// Writes the whole frame into one file: ``.usda`` or ``.glb``; also ``.vti`` (fields), and of 3D scenes ``.vdb`` (fields).
    fn save(&self, py: Python<'_>, path: std::path::PathBuf) -> PyResult<()> {
        let name = if ["vti", "vdb"].iter().any(|e| path.extension().is_some_and(|own| own == *e)) {
            self.fields()?;
            "fields"
        } else {
            "frame"
        };
        py.detach(|| save(&self.content, name, &path)).or_raise(py)
    }

    fn __repr__(&self) -> String {
        let number = self.number.map_or_else(String::new, |n| format!(" {n}"));
        format!("<meniscus.Frame{number} at {} s, solids {}>", self.content.time, self.solids().join(", "))
    }
}

/// Exit status of wrong usage.
const USAGE: u8 = 2;

/// Writes a frame by the writer of the path's ending, and keeps the file of the part `name`.
///
/// # Errors
/// A failure of status 2 for an ending without a writer, 4 if the file cannot be written.
pub fn save(frame: &FrameContent, name: &str, path: &Path) -> Result<(), Failure> {
    let ending = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_lowercase();
    let wanted = match ending.as_str() {
        "usda" => "usd",
        "vtp" => "vtk",
        other => other,
    };
    let writer = Format::ALL.into_iter().find(|f| f.name() == wanted).and_then(Format::frame_writer);
    let unknown = || {
        Failure::new(USAGE, format!("there is no such file of `{name}`: `{}`", path.display()))
            .help("a mesh is saved as .ply, .vtp, .obj, .glb, .usda or, a contact line, .csv; a frame as .usda, .glb, .vti or .vdb")
    };
    let writer = writer.ok_or_else(unknown)?;
    let mut beside = path.as_os_str().to_owned();
    beside.push(format!(".{}.parts", std::process::id()));
    let folder = Folder::of_frames(Path::new(&beside));
    atomic_file::create_folder(folder.root())?;
    let part = if ["usd", "glb"].contains(&wanted) { "frame" } else { name };
    let file = folder.frame_file(part, 0, &ending);
    let done = writer.write(&folder, 0, frame).map_err(Failure::from).and_then(|_| {
        if !file.is_file() {
            return Err(unknown());
        }
        std::fs::rename(&file, path).map_err(|e| FileError::of("write", path)(e).into())
    });
    // The writer may also have made files for a sequence of frames, such as `run.usda`; they are deleted.
    let _ = std::fs::remove_dir_all(folder.root());
    done
}
