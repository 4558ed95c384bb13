//! The files that a scene names, meshes and images: each is read once. `builtin:NAME` is a mesh that comes with the program.
//!
//! Scenes with built-in meshes run from any folder, also from the `scene.toml` of a run and with `--resume`.

use crate::error::nearest;
use meniscus_numerics::mesh::VolumeMesh;
use meniscus_numerics::mesh::volume::read;
use meniscus_numerics::shape::MeshShape;
use std::any::Any;
use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Prefix of the name of a built-in mesh file.
const PREFIX: &str = "builtin:";

/// The built-in meshes: name and content.
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

/// The files that a scene names. Each is read when it is first asked for, and its mesh is made once; clones share what is read.
#[derive(Clone, Debug, Default)]
pub struct SceneFiles(Arc<Mutex<Loaded>>);

#[derive(Debug, Default)]
struct Loaded {
    contents: BTreeMap<PathBuf, Arc<[u8]>>,
    /// Meshes in the coordinates of their file, by its path.
    meshes: BTreeMap<PathBuf, Arc<dyn Any + Send + Sync>>,
}

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
        if let Some(content) = self.loaded().contents.get(path) {
            return Ok(Arc::clone(content));
        }
        let builtin = path.to_str().and_then(builtin_name);
        let content: Arc<[u8]> = match MESHES.iter().find(|(known, _)| Some(*known) == builtin) {
            Some((_, content)) => Arc::from(*content),
            None => std::fs::read(path)?.into(),
        };
        self.loaded().contents.insert(path.to_owned(), Arc::clone(&content));
        Ok(content)
    }

    /// The closed surface of a mesh file, in the file's coordinates; the error is a message.
    pub(crate) fn surface<const D: usize>(&self, path: &Path) -> Result<Arc<MeshShape<D>>, String> {
        self.mesh(path, || MeshShape::load(path, &|file| self.content(file)))
    }

    /// The elements of a volume mesh file, in the file's coordinates; the error is a message.
    pub(crate) fn volume<const D: usize>(&self, path: &Path) -> Result<Arc<VolumeMesh<D>>, String> {
        self.mesh(path, || read::load(path, &|file| self.content(file)))
    }

    /// Frees the memory of what has been read. What is asked for again is read again.
    pub fn forget(&self) {
        *self.loaded() = Loaded::default();
    }

    fn mesh<M: Send + Sync + 'static, E: ToString>(
        &self,
        path: &Path,
        load: impl FnOnce() -> Result<M, E>,
    ) -> Result<Arc<M>, String> {
        let known = self.loaded().meshes.get(path).cloned();
        if let Some(mesh) = known.and_then(|mesh| mesh.downcast().ok()) {
            return Ok(mesh);
        }
        let mesh = Arc::new(load().map_err(|e| e.to_string())?);
        self.loaded().meshes.insert(path.to_owned(), Arc::<M>::clone(&mesh));
        Ok(mesh)
    }

    fn loaded(&self) -> MutexGuard<'_, Loaded> {
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
        let first = files.surface::<2>(&path).unwrap();
        std::fs::remove_file(&path).unwrap();
        assert!(Arc::ptr_eq(&first, &files.clone().surface::<2>(&path).unwrap()));
        assert!(files.content(&path).is_ok() && SceneFiles::default().content(&path).is_err());
    }
}
