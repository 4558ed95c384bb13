//! The scenes that are built in.

use crate::error::{ErrorKind, SceneError, nearest};
use crate::file::{LoadOptions, Scene};
use serde::Serialize;
use std::path::Path;

/// A built-in scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Builtin {
    /// Name.
    pub name: &'static str,
    /// 2 or 3.
    pub dimension: u32,
    /// The paper's figure that it follows, if any.
    pub figure: Option<&'static str>,
    /// What it shows, in one line.
    pub line: &'static str,
    /// What it takes to run, roughly, on two cores.
    pub cost: &'static str,
    /// The scene file.
    #[serde(skip)]
    pub text: &'static str,
}

macro_rules! scene {
    ($name:literal, $dimension:literal, $line:literal, $cost:literal) => {
        Builtin {
            name: $name,
            dimension: $dimension,
            figure: None,
            line: $line,
            cost: $cost,
            text: include_str!(concat!("../../../scenes/", $name, ".toml")),
        }
    };
}

/// Every built-in scene, cheap ones first.
pub const BUILTINS: [Builtin; 9] = [
    scene!("oscillating-drop-2d", 2, "A disc of water of 1 mm swings in its second mode", "a few seconds"),
    scene!("capillary-wave-2d", 2, "A standing capillary wave of 1 cm on water", "a few seconds"),
    scene!("dam-break-2d", 2, "Martin and Moyce's collapsing column of water", "a few seconds"),
    scene!(
        "static-drop",
        3,
        "A water drop of 1 mm radius at rest; whatever moves is an error",
        "about half a minute"
    ),
    scene!(
        "oscillating-drop",
        3,
        "A water drop of 1 mm swings in its second mode with Rayleigh's period",
        "one to two minutes"
    ),
    scene!("colliding-drops", 3, "Two water drops meet slowly (We = 10), merge and wobble", "a few minutes"),
    scene!("filament-breakup", 3, "A thread of water bulges, necks and breaks into drops", "a few minutes"),
    scene!(
        "colliding-drops-fast",
        3,
        "Two water drops meet fast and off centre (We = 61), merge and tear apart again",
        "two to ten minutes"
    ),
    scene!(
        "crown-splash",
        3,
        "A drop falls into a deep tank and throws up a crown (We = 1100)",
        "one to two hours; --quality draft: a few minutes"
    ),
];

/// The built-in scene of this name.
pub fn find(name: &str) -> Option<&'static Builtin> {
    BUILTINS.iter().find(|b| b.name == name)
}

/// Opens a scene: the path of a `.toml` file, or the name of a built-in scene.
///
/// # Errors
/// [`SceneError`]: there is no such scene (with the nearest name), or what is wrong in it.
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
    let help = format!("{near}`meniscus scenes` lists the built-in scenes; a file ends in .toml");
    let error = SceneError::new(format!("there is no built-in scene `{}`", scene.escape_debug()));
    Err(SceneError { kind: ErrorKind::Io, ..error.with_help(help) })
}
