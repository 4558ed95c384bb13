//! The commands, one file per family.

pub mod bench;
pub mod check;
pub mod info;
pub mod measure;
pub mod run;
pub mod scenes;
pub mod soak;
pub mod step_bench;
mod table1;
pub mod verify;
pub mod view;

use crate::failure::{Failure, OUTPUT, Result};
use std::io::Write;
use std::path::Path;

/// Prints to standard output. A reader that has gone (`| head`) is no error.
pub fn print(text: &str) -> Result<()> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Failure::new(OUTPUT, format!("cannot write to standard output: {error}")))
        }
        _ => Ok(()),
    }
}

/// Writes a file of results.
pub fn save(path: &Path, text: &str) -> Result<()> {
    std::fs::write(path, text).map_err(Failure::file("write", path))
}

/// Stack of a thread, bytes: that which a main thread has, on which the work would run otherwise.
const THREAD_STACK_BYTES: usize = 8 << 20;

/// Runs `work` on one thread of a pool of so many, as many as the machine has if no number is given. A thread of the pool starts a
/// short parallel loop at less cost than one outside of it, which must hand the loop over and wait.
///
/// # Errors
/// The error of `work`, or one that says that the threads cannot be started.
pub fn with_threads<R: Send>(threads: Option<usize>, work: impl FnOnce() -> Result<R> + Send) -> Result<R> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads.unwrap_or(0))
        .stack_size(THREAD_STACK_BYTES)
        .build();
    pool.map_err(|e| Failure::new(1, format!("cannot start the threads: {e}")))?.install(work)
}
