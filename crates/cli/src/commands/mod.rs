//! The commands, one file per family.

pub mod bench;
pub mod check;
pub mod export;
pub mod info;
pub mod measure;
pub mod run;
pub mod scenes;
pub mod soak;
pub mod sweep;
pub mod verify;
pub mod view;

use crate::failure::{Failure, OUTPUT, Result};
use meniscus_scene::output::atomic_file::write_atomically;
use std::io::Write;
use std::path::Path;

/// Prints to standard output. A closed pipe (`| head`) is no error.
pub fn print(text: &str) -> Result<()> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Failure::new(OUTPUT, format!("cannot write to standard output: {error}")))
        }
        _ => Ok(()),
    }
}

/// Prints a row as it comes: to standard error where standard output is for a page of Markdown.
pub fn show_progress(text: &str, as_markdown: bool) -> Result<()> {
    if as_markdown {
        eprint!("{text}");
        return Ok(());
    }
    print(text)
}

/// The version of this program, and the commit if the environment variable `MENISCUS_COMMIT` named it at compilation.
pub fn version() -> String {
    let version = env!("CARGO_PKG_VERSION");
    option_env!("MENISCUS_COMMIT").map_or(version.to_owned(), |commit| format!("{version}, commit {commit}"))
}

/// Cells along the axes, such as `192³` or `96 × 96 × 80`.
pub fn grid_text(cells: &[usize]) -> String {
    match cells {
        [n, m] if n == m => format!("{n}²"),
        [n, m, k] if n == m && n == k => format!("{n}³"),
        _ => cells.iter().map(ToString::to_string).collect::<Vec<_>>().join(" × "),
    }
}

/// Writes a file of results; if it fails or is killed, the old file is kept.
pub fn save(path: &Path, text: &str) -> Result<()> {
    // A pipe or a terminal cannot be replaced by another file.
    if path.exists() && !path.is_file() {
        return std::fs::write(path, text).map_err(Failure::file("write", path));
    }
    Ok(write_atomically(path, |file| file.write_all(text.as_bytes()))?)
}

/// Stack of a thread, bytes; that of a main thread.
const THREAD_STACK_BYTES: usize = 8 << 20;

/// Runs `work` on a thread of a pool with `threads` threads, by default one per core. A thread of the pool starts a short parallel loop
/// at less cost than an outside thread, which must hand the loop over and wait.
///
/// # Errors
/// The error of `work`, or one if the threads cannot be started.
pub fn with_threads<R: Send>(threads: Option<usize>, work: impl FnOnce() -> Result<R> + Send) -> Result<R> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads.unwrap_or(0))
        .stack_size(THREAD_STACK_BYTES)
        .build();
    pool.map_err(|e| Failure::new(1, format!("cannot start the threads: {e}")))?.install(work)
}
