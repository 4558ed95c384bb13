//! The built-in scenes.

mod entry;
mod list;

pub use entry::Builtin;
pub use list::BUILTINS;

use crate::error::{ErrorKind, SceneError, nearest};
use crate::file::{LoadOptions, Scene};
use std::path::Path;

/// Finds the built-in scene of this name.
pub fn find(name: &str) -> Option<&'static Builtin> {
    BUILTINS.iter().find(|b| b.name == name)
}

/// Opens a scene: the path of a `.toml` file, or the name of a built-in scene.
///
/// # Errors
/// [`SceneError`] if there is no such scene (with the nearest name) or if the scene is invalid.
pub fn open(scene: &str, options: &LoadOptions) -> Result<Scene, SceneError> {
    if let Some(b) = find(scene) {
        return Scene::from_text(&format!("{}.toml", b.name), b.text, Path::new(""), options);
    }
    let path = Path::new(scene);
    if path.extension().is_some() || path.exists() || path.components().count() > 1 {
        return Scene::load(path, options);
    }
    let near = nearest(scene, BUILTINS.iter().map(|b| b.name));
    let near = near.map_or_else(String::new, |n| format!("did you mean `{n}`? "));
    let help =
        format!("{near}`meniscus scenes` lists the built-in scenes; the name of a scene file ends in .toml");
    let error = SceneError::new(format!("there is no built-in scene `{}`", scene.escape_debug()));
    Err(SceneError { kind: ErrorKind::Io, ..error.with_help(help) })
}
