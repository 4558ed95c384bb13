//! The output folder of a run: its paths, its lock.

use super::atomic_file::{self, FileError};
use super::log::Log;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// The output folder of a run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Folder {
    root: PathBuf,
    frames: PathBuf,
}

/// Why a folder cannot be used.
#[derive(Debug, Error)]
pub enum FolderError {
    /// The folder holds a run.
    #[error("the folder `{}` already holds a run", .0.display())]
    Taken(PathBuf),
    /// Another process writes into it.
    #[error("another run is writing into the folder `{}`", .0.display())]
    Busy(PathBuf),
    /// The folder could not be made, emptied or written.
    #[error(transparent)]
    File(#[from] FileError),
}

/// Names of everything that a run writes, except its log; nothing else in the folder is removed.
const ENTRIES: &[&str] =
    &["scene.toml", "summary.json", "timeseries.csv", "frames", "checkpoints", "render", "page", "export"];

impl Folder {
    /// The folder at a path; nothing is read or written.
    pub fn at(root: &Path) -> Self {
        Self { root: root.to_path_buf(), frames: root.join("frames") }
    }

    /// A folder that holds frames only, directly; nothing is read or written.
    pub fn of_frames(root: &Path) -> Self {
        Self { root: root.to_path_buf(), frames: root.to_path_buf() }
    }

    /// The folder itself.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// `scene.toml`: the scene as run.
    pub fn scene(&self) -> PathBuf {
        self.root.join("scene.toml")
    }

    /// `summary.json`.
    pub fn summary(&self) -> PathBuf {
        self.root.join("summary.json")
    }

    /// `timeseries.csv`.
    pub fn series(&self) -> PathBuf {
        self.root.join("timeseries.csv")
    }

    /// `log.jsonl`.
    pub fn log(&self) -> PathBuf {
        self.root.join("log.jsonl")
    }

    /// `frames/`.
    pub fn frames(&self) -> PathBuf {
        self.frames.clone()
    }

    /// File of a part of a frame, such as `liquid`, `contact_line` or `solid_NAME`: `frames/PART_NNNN.EXTENSION`.
    pub fn frame_file(&self, part: &str, frame: u64, extension: &str) -> PathBuf {
        self.frames.join(format!("{part}_{frame:04}.{extension}"))
    }

    /// `export/`: one folder for each format to which frames were exported.
    pub fn exports(&self) -> PathBuf {
        self.root.join("export")
    }

    /// `checkpoints/`.
    pub fn checkpoints(&self) -> PathBuf {
        self.root.join("checkpoints")
    }

    /// Whether the folder holds a run.
    pub fn holds_a_run(&self) -> bool {
        ["scene.toml", "summary.json", "timeseries.csv", "frames", "checkpoints"]
            .iter()
            .any(|name| self.root.join(name).exists())
    }

    /// Locks the folder and prepares it for a new run. `force` removes an earlier run. The folder is locked as long as the log is open.
    ///
    /// # Errors
    /// [`FolderError`].
    pub fn prepare(&self, force: bool) -> Result<Log, FolderError> {
        let log = self.lock()?;
        if self.holds_a_run() && !force {
            return Err(FolderError::Taken(self.root.clone()));
        }
        self.renew(&log)?;
        Ok(log)
    }

    /// Removes an earlier run from a folder whose log this process has locked, and makes the missing folders.
    ///
    /// # Errors
    /// [`FolderError::File`].
    pub fn renew(&self, log: &Log) -> Result<(), FolderError> {
        self.clear()?;
        log.clear()?;
        self.make()
    }

    /// Opens the log and locks it. A process does so before it reads or changes anything in the folder, so no two can write into it.
    ///
    /// # Errors
    /// [`FolderError::Busy`] if another process has locked it, [`FolderError::File`].
    pub fn lock(&self) -> Result<Log, FolderError> {
        atomic_file::create_folder(&self.root)?;
        Log::lock(&self.log())?.ok_or_else(|| FolderError::Busy(self.root.clone()))
    }

    /// Whether another process writes into the folder. The answer may be outdated at once; only [`Folder::lock`] decides.
    pub fn is_busy(&self) -> bool {
        let locked = std::fs::File::open(self.log()).map(|log| log.try_lock_shared());
        matches!(locked, Ok(Err(std::fs::TryLockError::WouldBlock)))
    }

    /// Makes the missing folders.
    ///
    /// # Errors
    /// [`FolderError::File`].
    pub fn make(&self) -> Result<(), FolderError> {
        atomic_file::create_folder(&self.frames())?;
        atomic_file::create_folder(&self.checkpoints())?;
        Ok(())
    }

    fn clear(&self) -> Result<(), FileError> {
        for name in ENTRIES {
            let path = self.root.join(name);
            let removed = match std::fs::symlink_metadata(&path) {
                Err(_) => Ok(()),
                Ok(entry) if entry.is_dir() => std::fs::remove_dir_all(&path),
                Ok(_) => std::fs::remove_file(&path),
            };
            removed.map_err(FileError::of("remove", &path))?;
        }
        Ok(())
    }

    /// Removes the frames from number `from` on; a resumed run writes them again.
    ///
    /// # Errors
    /// [`FileError`].
    pub fn remove_frames_from(&self, from: u64) -> Result<(), FileError> {
        let Ok(entries) = std::fs::read_dir(self.frames()) else { return Ok(()) };
        for path in entries.flatten().map(|entry| entry.path()) {
            if frame_number(&path).is_none_or(|number| number >= from) {
                std::fs::remove_file(&path).map_err(FileError::of("remove", &path))?;
            }
        }
        Ok(())
    }
}

/// The number at the end of a frame's name: 12 of `liquid_0012.ply`. None for an unfinished file.
fn frame_number(path: &Path) -> Option<u64> {
    if path.extension()? == "part" {
        return None;
    }
    path.file_stem()?.to_str()?.rsplit('_').next()?.parse().ok()
}
