//! Drawing until the program takes the scene: what it refuses is drawn again.

use crate::soak::{CaseSet, Subject};
use meniscus_scene::build::AnySetup;
use meniscus_scene::error::SceneError;
use meniscus_scene::file::{LoadOptions, Scene, ensure_runnable};
use std::path::Path;

/// Draws of a case before it is given up.
const MAX_ATTEMPTS: u64 = 200;

/// A scene that the program takes.
pub struct AcceptedScene {
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
pub fn accepted_scene(subject: &Subject, tell: &mut dyn FnMut(&str)) -> Result<AcceptedScene, String> {
    let mut refused = Vec::new();
    match subject {
        Subject::File(path, _) => {
            let text =
                std::fs::read_to_string(path).map_err(|e| format!("cannot read {}: {e}", path.display()))?;
            tell(&text);
            let base = path.parent().unwrap_or(Path::new(""));
            let (scene, setup) = parse_and_set_up(&text, base).map_err(|e| e.message)?;
            Ok(AcceptedScene { text, scene, setup, refused })
        }
        Subject::Case(wish, case) => {
            for attempt in 0..MAX_ATTEMPTS {
                let text = match wish.set {
                    CaseSet::Random => crate::soak::draw::scene::scene(wish, *case, attempt),
                    CaseSet::DropTest => crate::soak::draw::drop_test::scene(wish, *case),
                };
                tell(&text);
                match parse_and_set_up(&text, Path::new("")) {
                    Ok((scene, setup)) => return Ok(AcceptedScene { text, scene, setup, refused }),
                    Err(error) if wish.set == CaseSet::DropTest => return Err(error.message),
                    Err(error) => refused.push(error.message),
                }
            }
            Err(format!(
                "{MAX_ATTEMPTS} draws were refused, the last as {}",
                refused.last().map_or("", |r| r)
            ))
        }
    }
}

/// The scene of a text, as `run` would take it.
fn parse_and_set_up(text: &str, base: &Path) -> Result<(Scene, AnySetup), SceneError> {
    let scene = Scene::from_text("drawn.toml", text, base, &LoadOptions::default())?;
    ensure_runnable(&scene)?;
    let setup = AnySetup::of(&scene)?;
    Ok((scene, setup))
}

/// A scene that was changed, as the program takes it.
pub fn round_tripped(scene: &Scene) -> Option<(Scene, AnySetup)> {
    parse_and_set_up(&scene.to_toml().ok()?, Path::new("")).ok()
}
