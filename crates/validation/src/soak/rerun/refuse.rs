//! Drawing until the program takes the scene: what it refuses is drawn again.

use crate::soak::{Set, Subject};
use meniscus_scene::build::AnySetup;
use meniscus_scene::error::SceneError;
use meniscus_scene::file::{LoadOptions, Scene, runnable};
use std::path::Path;

/// Draws of a case before it is given up.
const ATTEMPTS: u64 = 200;

/// A scene that the program takes.
pub struct Taken {
    /// Its text.
    pub text: String,
    /// The scene.
    pub scene: Scene,
    /// Its start.
    pub setup: AnySetup,
    /// Why earlier draws were refused.
    pub refused: Vec<String>,
}

/// The scene of a subject. `tell` sees every text before it is tried: one may take for ever.
///
/// # Errors
/// Why there is none, in words.
pub fn taken(subject: &Subject, tell: &mut dyn FnMut(&str)) -> Result<Taken, String> {
    let mut refused = Vec::new();
    match subject {
        Subject::File(path, _) => {
            let text =
                std::fs::read_to_string(path).map_err(|e| format!("cannot read {}: {e}", path.display()))?;
            tell(&text);
            let base = path.parent().unwrap_or(Path::new(""));
            let (scene, setup) = taken_from(&text, base).map_err(|e| e.message)?;
            Ok(Taken { text, scene, setup, refused })
        }
        Subject::Case(wish, case) => {
            for attempt in 0..ATTEMPTS {
                let text = match wish.set {
                    Set::Random => crate::soak::draw::scene::scene(wish, *case, attempt),
                    Set::Drops => crate::soak::draw::drops::scene(wish, *case),
                };
                tell(&text);
                match taken_from(&text, Path::new("")) {
                    Ok((scene, setup)) => return Ok(Taken { text, scene, setup, refused }),
                    Err(error) if wish.set == Set::Drops => return Err(error.message),
                    Err(error) => refused.push(error.message),
                }
            }
            Err(format!("{ATTEMPTS} draws were refused, the last as {}", refused.last().map_or("", |r| r)))
        }
    }
}

/// The scene of a text, as `run` would take it.
fn taken_from(text: &str, base: &Path) -> Result<(Scene, AnySetup), SceneError> {
    let scene = Scene::from_text("drawn.toml", text, base, &LoadOptions::default())?;
    runnable(&scene)?;
    let setup = AnySetup::of(&scene)?;
    Ok((scene, setup))
}

/// A scene that was changed, as the program takes it.
pub fn changed(scene: &Scene) -> Option<(Scene, AnySetup)> {
    taken_from(&scene.to_toml().ok()?, Path::new("")).ok()
}
