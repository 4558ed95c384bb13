//! File input and output of surface meshes.

use std::io;
use std::path::Path;
use std::sync::Arc;

pub mod import;
pub mod ply;

/// Gives the content of a file: the system's, or one that is already in memory.
pub type ReadFile<'a> = &'a dyn Fn(&Path) -> io::Result<Arc<[u8]>>;

/// The content of a file on disk.
///
/// # Errors
/// Those of the operating system.
pub fn read_from_disk(path: &Path) -> io::Result<Arc<[u8]>> {
    std::fs::read(path).map(Arc::from)
}
