//! Mesh files that are built in: `builtin:NAME` where a scene names a file.
//!
//! So the scenes that need them run from any folder, what they write as `scene.toml` too, and `--resume` finds the same file.

use crate::error::nearest;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// What comes before the name of a mesh file that is built in.
const PREFIX: &str = "builtin:";

/// The files: name and content.
const MESHES: [(&str, &[u8]); 2] = [
    ("duck.obj", include_bytes!("../../../../scenes/meshes/duck.obj")),
    ("leaf.msh", include_bytes!("../../../../scenes/meshes/leaf.msh")),
];

/// The name of a built-in file after its prefix; none for any other file.
pub(crate) fn builtin_name(file: &str) -> Option<&str> {
    file.strip_prefix(PREFIX)
}

/// Why there is no such built-in file, and what there is; none if there is.
pub(crate) fn unknown_mesh_message(name: &str) -> Option<(String, String)> {
    if MESHES.iter().any(|(known, _)| *known == name) {
        return None;
    }
    let names = MESHES.map(|(known, _)| format!("{PREFIX}{known}")).join(", ");
    let near = nearest(name, MESHES.iter().map(|(known, _)| *known));
    let near = near.map_or_else(String::new, |n| format!("did you mean `{PREFIX}{n}`? "));
    Some((format!("there is no built-in mesh `{}`", name.escape_debug()), format!("{near}built in: {names}")))
}

/// Reads a mesh file, built in or not, by what reads files. Readers take paths, as formats of several files need them: a
/// built-in file is there for them only while they read.
pub(crate) fn read<T, E: ToString>(
    path: &Path,
    reader: impl FnOnce(&Path) -> Result<T, E>,
) -> Result<T, String> {
    let name = path.to_str().and_then(builtin_name);
    let Some((name, bytes)) = MESHES.iter().find(|(known, _)| Some(*known) == name) else {
        return reader(path).map_err(|e| e.to_string());
    };
    let copy = unpack(name, bytes).map_err(|e| format!("{}: cannot be unpacked: {e}", path.display()))?;
    let found = reader(&copy).map_err(|e| e.to_string());
    let _ = std::fs::remove_file(&copy);
    found
}

/// A new file of this content among the system's temporary ones; it ends in `name`.
fn unpack(name: &str, bytes: &[u8]) -> io::Result<PathBuf> {
    static NEXT: AtomicU64 = AtomicU64::new(0);
    loop {
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let path = std::env::temp_dir().join(format!("meniscus-{}-{number}-{name}", std::process::id()));
        match std::fs::File::create_new(&path) {
            Err(e) if e.kind() == io::ErrorKind::AlreadyExists => {}
            Err(e) => return Err(e),
            Ok(mut file) => return file.write_all(bytes).map(|()| path),
        }
    }
}
