//! The files that a scene names, meshes and images: the content of each is read once. `builtin:NAME` is a mesh that comes with the program.
//!
//! Scenes with built-in meshes run from any folder, also from the `scene.toml` of a run and with `--resume`.

use crate::error::nearest;
use meniscus_numerics::mesh::VolumeMesh;
use meniscus_numerics::mesh::volume::read;
use meniscus_numerics::shape::MeshShape;
use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Prefix of the name of a built-in mesh file.
const PREFIX: &str = "builtin:";

/// The built-in meshes: name and content.
const MESHES: [(&str, &[u8]); 3] = [
    ("box-net.msh", include_bytes!("../../../../scenes/meshes/box-net.msh")),
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

/// Contents of the files by path.
type Contents = BTreeMap<PathBuf, Arc<[u8]>>;

/// The files that a scene names. A file is read when its content is first needed; clones share the contents.
#[derive(Clone, Debug, Default)]
pub struct SceneFiles(Arc<Mutex<Contents>>);

/// Scenes are compared by the paths of their files, so all collections of files compare equal.
impl PartialEq for SceneFiles {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl SceneFiles {
    /// The content of a file.
    ///
    /// # Errors
    /// Those of the operating system.
    pub fn content(&self, path: &Path) -> io::Result<Arc<[u8]>> {
        if let Some(content) = self.contents().get(path) {
            return Ok(Arc::clone(content));
        }
        let builtin = path.to_str().and_then(builtin_name);
        let content: Arc<[u8]> = match MESHES.iter().find(|(known, _)| Some(*known) == builtin) {
            Some((_, content)) => Arc::from(*content),
            None => std::fs::read(path)?.into(),
        };
        self.contents().insert(path.to_owned(), Arc::clone(&content));
        Ok(content)
    }

    /// The closed surface of a mesh file, in the file's coordinates; the error is a message.
    pub(crate) fn surface<const D: usize>(&self, path: &Path) -> Result<MeshShape<D>, String> {
        MeshShape::load(path, &|file| self.content(file)).map_err(|e| e.to_string())
    }

    /// The elements of a volume mesh file, in the file's coordinates; the error is a message.
    pub(crate) fn volume<const D: usize>(&self, path: &Path) -> Result<VolumeMesh<D>, String> {
        read::load(path, &|file| self.content(file)).map_err(|e| e.to_string())
    }

    /// The files read so far.
    pub fn paths(&self) -> Vec<PathBuf> {
        self.contents().keys().cloned().collect()
    }

    /// Frees the memory of all contents; a file that is needed later is read again.
    pub fn forget(&self) {
        self.contents().clear();
    }

    fn contents(&self) -> MutexGuard<'_, Contents> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_read_once() {
        let path = std::env::temp_dir().join(format!("meniscus-files-{}.obj", std::process::id()));
        std::fs::write(&path, "v 0 0\nv 1 0\nv 0 1\nl 1 2 3 1\n").unwrap();
        let files = SceneFiles::default();
        assert!(files.surface::<2>(&path).is_ok());
        std::fs::remove_file(&path).unwrap();
        assert!(files.clone().surface::<2>(&path).is_ok());
        assert!(files.content(&path).is_ok() && SceneFiles::default().content(&path).is_err());
    }
}
