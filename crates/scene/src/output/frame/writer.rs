//! The interface of a format of frames.

use super::{Frame, FrameParts};
use crate::output::{FileError, Folder};
use std::fmt::Debug;
use std::path::PathBuf;

/// A format of frames. A run calls each writer of its [`Job`](crate::job::Job) with each frame that it writes.
pub trait FrameWriter: Debug + Send + Sync {
    /// Writes a frame and returns the main file, that of the liquid's surface if there is one; the folder if the format has nothing to
    /// write of this frame.
    ///
    /// Files go through [`write_atomically`](crate::output::atomic_file::write_atomically) to paths of [`Folder::frame_file`]:
    /// so they are whole or not there, and a resumed run removes those that it writes again.
    ///
    /// # Errors
    /// [`FileError`] of the file that could not be written.
    fn write(&self, folder: &Folder, number: u64, frame: &Frame) -> Result<PathBuf, FileError>;

    /// What the format needs of a frame beside surfaces and contact line; nothing by default.
    fn parts(&self) -> FrameParts {
        FrameParts::default()
    }
}
