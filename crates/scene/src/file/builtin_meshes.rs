//! Built-in mesh files: `builtin:NAME` where a scene names a file.
//!
//! Scenes that use them run from any folder, also from the `scene.toml` of a run and with `--resume`.

use crate::error::nearest;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// Prefix of the name of a built-in mesh file.
const PREFIX: &str = "builtin:";

/// The files: name and content.
const MESHES: [(&str, &[u8]); 2] = [
    ("duck.obj", include_bytes!("../../../../scenes/meshes/duck.obj")),
    ("leaf.msh", include_bytes!("../../../../scenes/meshes/leaf.msh")),
];

/// The name of a built-in file after its prefix; `None` for any other file.
pub(crate) fn builtin_name(file: &str) -> Option<&str> {
    file.strip_prefix(PREFIX)
}

/// Message and help for an unknown built-in file; `None` if the file exists.
pub(crate) fn unknown_mesh_message(name: &str) -> Option<(String, String)> {
    if MESHES.iter().any(|(known, _)| *known == name) {
        return None;
    }
    let names = MESHES.map(|(known, _)| format!("{PREFIX}{known}")).join(", ");
    let near = nearest(name, MESHES.iter().map(|(known, _)| *known));
    let near = near.map_or_else(String::new, |n| format!("did you mean `{PREFIX}{n}`? "));
    Some((
        format!("there is no built-in mesh `{}`", name.escape_debug()),
        format!("{near}built-in meshes: {names}"),
    ))
}

/// Reads a mesh file, built in or not, with `reader`. Readers take paths because some formats consist of several files; a
/// built-in file therefore exists as a temporary file while it is read.
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

/// Writes the content to a new temporary file whose name ends in `name`.
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
