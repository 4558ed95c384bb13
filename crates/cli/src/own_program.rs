//! The words that start this program again, for commands that start processes of their own.

use crate::failure::{Failure, Result, USAGE};
use std::ffi::OsString;
use std::path::PathBuf;
use std::process::Command;
use std::sync::OnceLock;

static WORDS: OnceLock<Vec<OsString>> = OnceLock::new();

/// Sets the words, such as those of `python -m meniscus`. Only the first call has an effect.
pub fn set(words: Vec<OsString>) {
    let _ = WORDS.set(words);
}

/// The words: those that were set, else the path of the executable file.
pub fn words() -> Result<Vec<OsString>> {
    if let Some(words) = WORDS.get() {
        return Ok(words.clone());
    }
    let path = std::env::current_exe()
        .map_err(|e| Failure::new(1, format!("cannot find the path of this program: {e}")))?;
    Ok(vec![path.into_os_string()])
}

/// The path of the executable file, for commands that hand it on alone.
pub fn executable() -> Result<PathBuf> {
    match &words()?[..] {
        [path] => Ok(path.into()),
        _ => Err(Failure::new(
            USAGE,
            "this command starts processes of the program `meniscus`, which the Python package is not",
        )
        .help("build the program with cargo (README.md)")),
    }
}

/// A command that begins with such words.
pub fn command(words: &[OsString]) -> Command {
    let mut command = Command::new(words.first().cloned().unwrap_or_default());
    command.args(words.iter().skip(1));
    command
}
