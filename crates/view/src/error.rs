//! Errors of pictures, pages and measurements.

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
        /// Error of the operating system.
        source: io::Error,
    },
    /// A mesh file could not be read.
    #[error(transparent)]
    Ply(#[from] PlyError),
    /// A file has unusable content.
    #[error("{}: {what}", path.display())]
    Content {
        /// The file or folder.
        path: PathBuf,
        /// What is wrong with it.
        what: String,
    },
    /// A requested time lies outside the frames.
    #[error("{}: there is no frame near {at} s: the frames range from {first} s to {last} s", path.display())]
    Time {
        /// The folder.
        path: PathBuf,
        /// The requested time, s.
        at: f64,
        /// Time of the first frame, s.
        first: f64,
        /// Time of the last frame, s.
        last: f64,
    },
    /// An image could not be encoded.
    #[error("{}: {source}", path.display())]
    Png {
        /// The image.
        path: PathBuf,
        /// Error of the encoder.
        source: png::EncodingError,
    },
}

impl ViewError {
    /// Returns a function that converts an i/o error about `path` to an error of this crate.
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
