//! The Python package of Meniscus: scenes, runs that are stepped from frame to frame, their frames as numpy arrays, and sweeps.
//!
//! Runs are those of `scene::run` and of the command, with the same folders and bits. What is in Rust here converts; what is convenience
//! is in Python (`python/meniscus`).

mod arrays;
mod errors;
mod frame;
mod mesh;
mod scene;
mod session;
mod simulation;
mod stored;
mod sweep;

use pyo3::prelude::*;
use std::ffi::OsString;

/// Runs the command `meniscus` with its arguments and returns its exit status. `program` are the words that start it again.
#[pyfunction]
fn command(py: Python<'_>, arguments: Vec<OsString>, program: Vec<OsString>) -> u8 {
    let all = std::iter::once(OsString::from("meniscus")).chain(arguments).collect::<Vec<_>>();
    py.detach(|| meniscus_cli::main(all, Some(program)))
}

/// Name, dimension, one line and cost of every built-in scene, as JSON.
#[pyfunction]
fn builtin_scenes() -> String {
    serde_json::json!(meniscus_scene::builtin::BUILTINS[..]).to_string()
}

/// The part of the package that is written in Rust.
#[pymodule]
mod _meniscus {
    #[pymodule_export]
    use super::errors::{MeniscusError, OutputError, SceneError, SolverError};
    #[pymodule_export]
    use super::frame::{Frame, Ledger};
    #[pymodule_export]
    use super::mesh::{Elements, Mesh, Solid};
    #[pymodule_export]
    use super::scene::Scene;
    #[pymodule_export]
    use super::simulation::{Frames, Simulation};
    #[pymodule_export]
    use super::stored::{StoredRun, open_run};
    #[pymodule_export]
    use super::sweep::sweep;
    #[pymodule_export]
    use super::{builtin_scenes, command};

    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
