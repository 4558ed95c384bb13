//! A scene as Python sees it.

use crate::errors::OrRaise;
use crate::simulation::{Simulation, StartOptions};
use crate::stored::json_value;
use meniscus_cli::{Failure, Quality, SceneArgs, load};
use meniscus_scene::estimate::check::check;
use meniscus_scene::estimate::memory;
use meniscus_scene::file::Scene as SceneFile;
use pyo3::exceptions::{PyKeyError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple, PyType};
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Most keyframes of a motion.
const MAX_KEYFRAMES: f64 = 100_000.0;

/// A scene: a built-in one by its name, or a ``.toml`` file, with settings.
///
/// ``scene["PATH"] = value`` changes a value; paths, units and errors are those of ``--set``: strings with units such as ``"110 deg"``, or
/// bare numbers where a number has no unit. Every change is checked at once, and one that is refused is not kept. ``scene["PATH"]``
/// is the value as used, a string in SI units, a number, or a list or dict of them.
#[pyclass(frozen, module = "meniscus")]
pub struct Scene {
    args: Mutex<SceneArgs>,
}

fn quality(name: &str) -> PyResult<Option<Quality>> {
    match name {
        "draft" => Ok(Some(Quality::Draft)),
        "normal" => Ok(None),
        "paper" => Ok(Some(Quality::Paper)),
        _ => Err(PyValueError::new_err(format!(
            "there is no quality `{name}`\n  help: use \"draft\", \"normal\" or \"paper\""
        ))),
    }
}

impl Scene {
    fn args(&self) -> MutexGuard<'_, SceneArgs> {
        self.args.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The scene and its settings now.
    pub fn arguments(&self) -> SceneArgs {
        self.args().clone()
    }

    fn loaded(&self, py: Python<'_>) -> PyResult<SceneFile> {
        let args = self.arguments();
        Ok(py.detach(|| load(&args, &[])).or_raise(py)?.scene)
    }

    /// The scene as used, as a tree of values.
    fn tree(&self, py: Python<'_>) -> PyResult<toml::Table> {
        let text = self.toml(py)?;
        text.parse().map_err(|e| PyValueError::new_err(format!("the scene cannot be read again: {e}")))
    }

    /// Adds settings, and keeps them if the scene is valid with them.
    fn set(&self, py: Python<'_>, settings: Vec<String>) -> PyResult<()> {
        let mut args = self.arguments();
        args.set.extend(settings);
        py.detach(|| load(&args, &[])).or_raise(py)?;
        *self.args() = args;
        Ok(())
    }
}

/// The entry of a word in a tree: a key, or in a list a number or a name.
fn entry<'a>(tree: &'a toml::Value, word: &str) -> Option<&'a toml::Value> {
    match tree {
        toml::Value::Table(table) => table.get(word),
        toml::Value::Array(all) => {
            let named = |v: &&toml::Value| v.get("name").and_then(toml::Value::as_str) == Some(word);
            word.parse::<usize>().ok().and_then(|i| all.get(i)).or_else(|| all.iter().find(named))
        }
        _ => None,
    }
}

/// A Python value as the text of a setting: strings as they are, all else as TOML.
fn setting(value: &Bound<'_, PyAny>) -> PyResult<String> {
    if let Ok(text) = value.extract::<String>() {
        return Ok(text);
    }
    inline(value)
}

/// A Python value as TOML on one line.
fn inline(value: &Bound<'_, PyAny>) -> PyResult<String> {
    if let Ok(is) = value.extract::<bool>() {
        return Ok(is.to_string());
    }
    if let Ok(number) = value.extract::<i64>() {
        return Ok(number.to_string());
    }
    if let Ok(number) = value.extract::<f64>() {
        return Ok(format!("{number:?}"));
    }
    if let Ok(text) = value.extract::<String>() {
        return Ok(toml::Value::String(text).to_string());
    }
    if let Ok(dict) = value.cast::<PyDict>() {
        let pair = |(key, value): (Bound<'_, PyAny>, Bound<'_, PyAny>)| {
            Ok(format!("{} = {}", key.extract::<String>()?, inline(&value)?))
        };
        let pairs = dict.iter().map(pair).collect::<PyResult<Vec<_>>>()?;
        return Ok(format!("{{ {} }}", pairs.join(", ")));
    }
    let items = value.try_iter()?.map(|item| inline(&item?)).collect::<PyResult<Vec<_>>>()?;
    Ok(format!("[{}]", items.join(", ")))
}

#[pymethods]
impl Scene {
    #[new]
    #[pyo3(signature = (source, quality = "normal", settings = Vec::new()))]
    fn new(py: Python<'_>, source: PathBuf, quality: &str, settings: Vec<String>) -> PyResult<Self> {
        let args = SceneArgs {
            scene: source.display().to_string(),
            set: settings,
            quality: self::quality(quality)?,
            cells: None,
        };
        py.detach(|| load(&args, &[])).or_raise(py)?;
        Ok(Self { args: Mutex::new(args) })
    }

    /// The built-in name or the path that the scene was made from.
    #[getter]
    fn source(&self) -> String {
        self.args().scene.clone()
    }

    /// ``draft``, ``normal`` or ``paper``.
    #[getter]
    fn quality(&self) -> &'static str {
        match self.args().quality {
            Some(Quality::Draft) => "draft",
            Some(Quality::Paper) => "paper",
            Some(Quality::Normal) | None => "normal",
        }
    }

    /// The settings so far, each ``PATH=VALUE`` as of ``--set``.
    #[getter]
    fn settings(&self) -> Vec<String> {
        self.args().set.clone()
    }

    /// Name of the scene.
    #[getter]
    fn name(&self, py: Python<'_>) -> PyResult<String> {
        Ok(self.loaded(py)?.name)
    }

    /// 2 or 3.
    #[getter]
    fn dimension(&self, py: Python<'_>) -> PyResult<usize> {
        Ok(self.loaded(py)?.domain.dimension)
    }

    /// The scene as it would run, as the text of a scene file with all defaults, in SI units.
    fn toml(&self, py: Python<'_>) -> PyResult<String> {
        self.loaded(py)?.to_toml().or_raise(py)
    }

    fn __setitem__(&self, py: Python<'_>, path: &str, value: &Bound<'_, PyAny>) -> PyResult<()> {
        self.set(py, vec![format!("{path}={}", setting(value)?)])
    }

    fn __getitem__(&self, py: Python<'_>, path: &str) -> PyResult<Py<PyAny>> {
        let mut at = &toml::Value::Table(self.tree(py)?);
        for word in path.split('.') {
            at = entry(at, word.trim()).ok_or_else(|| {
                PyKeyError::new_err(format!("the scene has no value `{path}`: there is no `{word}` in it"))
            })?;
        }
        let json = serde_json::to_string(at).map_err(|e| PyValueError::new_err(e.to_string()))?;
        json_value(py, &json)
    }

    /// Moves a rigid solid along a function of time: ``function(t)``, t in s, returns its displacement from the place at the start, m, 2 or 3
    /// numbers.
    ///
    /// The function is called now, at times ``every`` (s) apart from 0 to ``until`` (s), and written into the scene as keyframes, between
    /// which the solid moves at constant velocity; it stands still after the last. So the scene file repeats the run.
    #[pyo3(signature = (solid, function, until, every))]
    fn move_solid(
        &self,
        py: Python<'_>,
        solid: &str,
        function: &Bound<'_, PyAny>,
        until: f64,
        every: f64,
    ) -> PyResult<()> {
        let count = (until / every).ceil();
        if !(every > 0.0 && (1.0..=MAX_KEYFRAMES).contains(&count)) {
            let message =
                format!("`until` and `every` give {count} keyframes; 1 to {MAX_KEYFRAMES} are possible");
            return Err(PyValueError::new_err(message));
        }
        let mut keyframes = Vec::new();
        for k in 0..=count as usize {
            let time = (k as f64 * every).min(until);
            let at: Vec<f64> = function.call1((time,))?.extract()?;
            let at: Vec<String> = at.iter().map(|x| format!("\"{x:?} m\"")).collect();
            keyframes.push(format!("{{ time = \"{time:?} s\", translate = [{}] }}", at.join(", ")));
        }
        let material = format!("{{ kinematic = {{ keyframes = [{}] }} }}", keyframes.join(", "));
        self.set(py, vec![format!("solid.{solid}.material={material}")])
    }

    /// The report of ``meniscus check``: dimensionless numbers, lengths, cells, memory, time, warnings. See ``Check``.
    fn check(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let scene = self.loaded(py)?;
        let found = py.detach(|| {
            let threads = std::thread::available_parallelism().map_or(1, usize::from);
            let report = check(&scene, threads);
            if let Some(error) = report.error {
                return Err(Failure::from(error));
            }
            memory::check_liquid_memory(&scene, memory::machine_memory())?;
            Ok((report.render(), serde_json::json!(report).to_string()))
        });
        let (text, values) = found.or_raise(py)?;
        let values = json_value(py, &values)?;
        Ok(py.import("meniscus._cases")?.call_method1("Check", (text, values))?.unbind())
    }

    /// Opens an output folder (by default ``out/NAME``) for a run, which is the same as that of ``meniscus run``. See ``Simulation``.
    ///
    /// ``resume=True`` goes on from the last checkpoint of the folder, or begins where there is none; ``force=True`` replaces a run;
    /// otherwise a folder that holds a run is refused. ``until`` (such as ``"32 ms"``) replaces the duration of the scene; ``threads`` is
    /// their number, by default all (results do not depend on it). ``gravity(t)``, t in s, returns the acceleration of gravity, m/s^2, 2 or 3
    /// numbers; it is called before each step and holds during it.
    #[pyo3(
        signature = (out = None, **options),
        text_signature = "($self, out=None, *, resume=False, force=False, until=None, threads=None, gravity=None)"
    )]
    fn start(
        &self,
        py: Python<'_>,
        out: Option<PathBuf>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Simulation> {
        let options = StartOptions::of(options)?;
        Simulation::start(py, self.arguments(), out, options)
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyType>, Bound<'py, PyTuple>)> {
        let this = slf.get();
        let state = (this.source(), this.quality(), this.settings()).into_pyobject(slf.py())?;
        Ok((slf.get_type(), state))
    }

    fn __repr__(&self) -> String {
        let args = self.args();
        let sets = args.set.iter().map(|set| format!(", {set}")).collect::<String>();
        format!("<meniscus.Scene {}{sets}>", args.scene)
    }
}
