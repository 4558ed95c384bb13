//! Generates scenes until the program accepts one.

use crate::soak::{CaseSet, Subject};
use meniscus_scene::build::AnySetup;
use meniscus_scene::error::SceneError;
use meniscus_scene::file::{LoadOptions, Scene, ensure_runnable};
use std::path::Path;

/// Most attempts of a case.
const MAX_ATTEMPTS: u64 = 200;

/// A scene accepted by the program.
pub struct AcceptedScene {
    /// Its text.
    pub text: String,
    /// The scene.
    pub scene: Scene,
    /// The setup of the scene.
    pub setup: AnySetup,
    /// Reasons why earlier attempts were refused.
    pub refused: Vec<String>,
}

/// The scene of a subject. `tell` receives every text before it is tried, because a trial may hang.
///
/// # Errors
/// A message if there is no scene.
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
                "all {MAX_ATTEMPTS} generated scenes were refused, the last one because {}",
                refused.last().map_or("", |r| r)
            ))
        }
    }
}

/// Parses a scene and sets it up as `run` does.
fn parse_and_set_up(text: &str, base: &Path) -> Result<(Scene, AnySetup), SceneError> {
    let scene = Scene::from_text("drawn.toml", text, base, &LoadOptions::default())?;
    ensure_runnable(&scene)?;
    let setup = AnySetup::of(&scene)?;
    Ok((scene, setup))
}

/// A modified scene after a round trip through its text.
pub fn round_tripped(scene: &Scene) -> Option<(Scene, AnySetup)> {
    parse_and_set_up(&scene.to_toml().ok()?, Path::new("")).ok()
}
