//! The commands, one file per family.

pub mod bench;
pub mod check;
pub mod info;
pub mod measure;
pub mod run;
pub mod scenes;
pub mod soak;
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

/// Uses so many threads; as many as the machine has if none are asked for.
pub fn set_threads(threads: Option<usize>) -> Result<()> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0));
    pool.build_global().map_err(|e| Failure::new(1, format!("cannot start the threads: {e}")))
}
