//! What can go wrong while pictures and pages are made.

use std::io;
use std::path::{Path, PathBuf};

use meniscus_numerics::mesh::ply::PlyError;

/// An error of this crate; each names the file or folder it is about.
#[derive(Debug, thiserror::Error)]
pub enum ViewError {
    /// A file or folder could not be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A mesh file could not be read.
    #[error(transparent)]
    Ply(#[from] PlyError),
    /// A file has content that this crate cannot use.
    #[error("{}: {what}", path.display())]
    Content {
        /// The file or folder.
        path: PathBuf,
        /// What is wrong with it.
        what: String,
    },
    /// A time lies beyond the frames.
    #[error("{}: there is no frame near {at} s: its frames go from {first} s to {last} s", path.display())]
    Time {
        /// The folder.
        path: PathBuf,
        /// The time that was asked for (s).
        at: f64,
        /// The first frame's time (s).
        first: f64,
        /// The last frame's time (s).
        last: f64,
    },
    /// An image could not be encoded.
    #[error("{}: {source}", path.display())]
    Png {
        /// The image.
        path: PathBuf,
        /// What the encoder said.
        source: png::EncodingError,
    },
}

impl ViewError {
    /// A function that turns an i/o error about `path` into an error of this crate.
    pub(crate) fn io(path: &Path) -> impl FnOnce(io::Error) -> Self + '_ {
        move |source| Self::Io { path: path.into(), source }
    }

    /// An error about the content of `path`.
    pub(crate) fn content(path: &Path, what: impl Into<String>) -> Self {
        Self::Content { path: path.into(), what: what.into() }
    }
}

/// A result of this crate.
pub type Result<T> = std::result::Result<T, ViewError>;
