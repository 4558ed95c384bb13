//! Files that are there whole or not at all.

use crate::error::{Result, ViewError};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

/// Writes a file under a temporary name, then renames it. After a failure or a kill at any moment the old file, or none, is still there.
///
/// # Errors
/// That of `fill`, or of the system; the temporary file is removed.
pub(crate) fn write(path: &Path, fill: impl FnOnce(&mut BufWriter<File>) -> Result<()>) -> Result<()> {
    let mut name = path.as_os_str().to_owned();
    name.push(".part");
    let beside = Path::new(&name);
    let written = File::create(beside).map_err(ViewError::io(path)).and_then(|file| {
        let mut file = BufWriter::new(file);
        fill(&mut file)?;
        file.flush().and_then(|()| std::fs::rename(beside, path)).map_err(ViewError::io(path))
    });
    if written.is_err() {
        let _ = std::fs::remove_file(beside);
    }
    written
}
