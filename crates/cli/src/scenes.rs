//! Finding and loading scenes: files, built-in names, output folders.

use crate::args::{Quality, SceneArgs};
use crate::failure::{Failure, OUTPUT, Result};
use meniscus_scene::SceneError;
use meniscus_scene::builtin;
use meniscus_scene::file::{LoadOptions, Scene};
use std::path::{Path, PathBuf};

/// A loaded scene and where it came from.
pub struct Loaded {
    /// The scene.
    pub scene: Scene,
    /// The output folder that it was found in, if it was the scene of a run.
    pub folder: Option<PathBuf>,
}

/// Loads the scene of a command, with what the command line changes in it.
pub fn load(args: &SceneArgs, more: &[String]) -> Result<Loaded> {
    let options = LoadOptions {
        sets: args.set.iter().chain(more).cloned().collect(),
        quality: match args.quality {
            Some(Quality::Draft) => meniscus_scene::file::Quality::Draft,
            Some(Quality::Paper) => meniscus_scene::file::Quality::Paper,
            Some(Quality::Normal) | None => meniscus_scene::file::Quality::Normal,
        },
    };
    let path = Path::new(&args.scene);
    let of_run = path.join("scene.toml");
    if path.is_dir() && of_run.is_file() {
        return Ok(Loaded { scene: Scene::load(&of_run, &options)?, folder: Some(path.to_path_buf()) });
    }
    if path.is_file() {
        return Ok(Loaded { scene: Scene::load(path, &options)?, folder: None });
    }
    match builtin::find(&args.scene) {
        Some(found) => Ok(Loaded { scene: builtin::load(found, &options)?, folder: None }),
        None => Err(missing(&args.scene)),
    }
}

/// There is neither a file nor a built-in scene of that name.
fn missing(name: &str) -> Failure {
    let names = builtin::all().iter().map(|b| b.name);
    let looks_like_a_path = name.ends_with(".toml") || name.contains(['/', '\\']);
    let near = meniscus_scene::error::nearest(name, names);
    let help = match near.filter(|_| !looks_like_a_path) {
        Some(near) => format!("did you mean `{near}`? `meniscus scenes` shows them all"),
        None => "give the path of a .toml file, or a name that `meniscus scenes` shows".to_string(),
    };
    Failure::new(OUTPUT, format!("there is no scene `{name}`")).help(help)
}

/// The JSON Schema of scene files.
pub fn schema() -> String {
    meniscus_scene::schema::json_schema()
}

/// What is wrong with an `--until` is told like what is wrong with `--set output.duration`.
pub fn until(time: &str) -> String {
    format!("output.duration=\"{}\"", time.replace('"', ""))
}

/// An error of a scene that stands before everything else.
pub fn check_runnable(scene: &Scene) -> std::result::Result<(), SceneError> {
    meniscus_scene::file::runnable(scene)
}
