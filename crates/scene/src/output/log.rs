//! `log.jsonl`: the events of a run, one JSON object per line.

use super::atomic_file::FileError;
use serde_json::Value;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Longest time for which [`super::Folder::is_busy`] holds the lock, with a wide margin.
const GLANCE: Duration = Duration::from_millis(100);

/// The log, open for appending, so that a resumed run continues it. While open it is locked, which marks the folder as in use.
pub struct Log {
    path: PathBuf,
    file: File,
}

impl Log {
    /// Opens or creates the file and locks it; none if another process has locked it.
    ///
    /// # Errors
    /// [`FileError`].
    pub(super) fn lock(path: &Path) -> Result<Option<Self>, FileError> {
        let file = OpenOptions::new().append(true).create(true).open(path);
        let file = file.map_err(FileError::of("write", path))?;
        // Some file systems have no locks; then two runs in one folder are not noticed.
        let is_locked = || matches!(file.try_lock(), Err(TryLockError::WouldBlock));
        // Whoever only looks whether the folder is in use holds a lock for an instant.
        let is_taken = is_locked() && {
            std::thread::sleep(GLANCE);
            is_locked()
        };
        Ok((!is_taken).then(|| Self { path: path.to_path_buf(), file }))
    }

    /// Removes all lines.
    pub(super) fn clear(&self) -> Result<(), FileError> {
        self.file.set_len(0).map_err(FileError::of("write", &self.path))
    }

    /// The same file for another thread; none if the system has no more handles.
    pub fn try_clone(&self) -> Option<Self> {
        Some(Self { path: self.path.clone(), file: self.file.try_clone().ok()? })
    }

    /// Appends a line.
    ///
    /// # Errors
    /// [`FileError`].
    pub fn write(&mut self, line: &Value) -> Result<(), FileError> {
        // A single write, because another thread may write too.
        let text = format!("{line}\n");
        self.file.write_all(text.as_bytes()).map_err(FileError::of("write", &self.path))
    }
}
