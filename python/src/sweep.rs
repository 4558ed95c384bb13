//! Sweeps: those of `meniscus sweep`, each case in a process of its own.

use crate::errors::OrRaise;
use crate::scene::Scene;
use meniscus_cli::{Ended, Failure, Runner, Sweep, Table, Vary};
use meniscus_scene::run::Stop;
use pyo3::prelude::*;
use std::cell::RefCell;
use std::ffi::OsString;
use std::path::PathBuf;

/// How the cases of a sweep run.
#[derive(FromPyObject)]
pub struct SweepOptions {
    /// The folder.
    #[pyo3(item)]
    out: Option<PathBuf>,
    /// Processes at the same time.
    #[pyo3(item)]
    jobs: usize,
    /// Threads of each.
    #[pyo3(item)]
    threads: Option<usize>,
    /// Words that start the command.
    #[pyo3(item)]
    program: Vec<OsString>,
}

/// Runs all combinations of values. Returns the folder, and as JSON `ended`, the number and the exit status of each case, and `columns`, the
/// table.
#[pyfunction]
#[pyo3(name = "_sweep")]
pub fn sweep(
    py: Python<'_>,
    scene: &Scene,
    vary: Vec<(String, Vec<String>)>,
    options: SweepOptions,
) -> PyResult<(PathBuf, String)> {
    let vary = vary.into_iter().map(|(path, values)| Vary { path, values }).collect();
    let (args, SweepOptions { out, jobs, threads, program }) = (scene.arguments(), options);
    let made = py.detach(|| Sweep::new(&args, vary, out.as_deref())).or_raise(py)?;
    let (jobs, mut interrupt) = (jobs.max(1), None);
    let ended = py.detach(|| {
        let error = RefCell::new(None);
        let stop = || {
            if let Err(new) = Python::attach(|py| py.check_signals()) {
                error.borrow_mut().get_or_insert(new);
            }
            error.borrow().as_ref().map(|_| Stop::Signal)
        };
        let threads = threads.unwrap_or_else(|| Runner::threads_of_each(jobs));
        let runner = Runner { folder: made.folder(), jobs, threads, program, stop: &stop };
        let cases: Vec<usize> = (0..made.plan().cases().len()).collect();
        let ended = runner.run(&cases, &mut |_: &Ended| ());
        interrupt = error.into_inner();
        ended
    });
    let table = py.detach(|| Ok::<_, Failure>((ended?, made.collect()?))).or_raise(py);
    if let Some(interrupt) = interrupt {
        return Err(interrupt);
    }
    let (ended, table) = table?;
    let ended: Vec<(usize, u8)> = ended.into_iter().map(|end| (end.case, end.status)).collect();
    let result = serde_json::json!({ "ended": ended, "columns": columns(&table) });
    Ok((made.folder().root().to_path_buf(), result.to_string()))
}

/// The table column by column: parameters, state, checks and measures.
fn columns(table: &Table) -> Vec<serde_json::Value> {
    let mut columns = Vec::new();
    let mut add = |name: &str, unit: &str, values: serde_json::Value| {
        columns.push(serde_json::json!({ "name": name, "unit": unit, "values": values }));
    };
    add("case", "", table.rows.iter().map(|row| row.case).collect());
    for (k, parameter) in table.parameters.iter().enumerate() {
        let values = table.rows.iter().map(|row| row.values.get(k).cloned().unwrap_or_default());
        add(&parameter.path, &parameter.unit, values.collect());
    }
    add("state", "", table.rows.iter().map(|row| row.state.clone()).collect());
    add("met", "", table.rows.iter().map(|row| serde_json::json!(row.met)).collect());
    for (name, unit) in &table.quantities {
        let cells = || table.rows.iter().map(|row| row.cell(name));
        add(name, unit, cells().map(|c| serde_json::json!(c.and_then(|c| c.value))).collect());
        if table.is_check(name) {
            let met = cells().map(|c| serde_json::json!(c.and_then(|c| c.met)));
            add(&format!("{name} met"), "", met.collect());
        }
    }
    columns
}
