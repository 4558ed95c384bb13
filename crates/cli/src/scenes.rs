//! Finding and loading scenes: files, built-in names, output folders; preparing them for a run.

use crate::args::{self, SceneArgs};
use crate::failure::Result;
use meniscus_scene::build::{AnySetup, displaced_liquid};
use meniscus_scene::builtin;
use meniscus_scene::estimate::memory;
use meniscus_scene::expect::ensure_columns;
use meniscus_scene::file::{LoadOptions, Quality, Scene, ensure_runnable};
use meniscus_scene::run::Job;
use std::path::{Path, PathBuf};

/// A loaded scene and its origin.
pub struct Loaded {
    /// The scene.
    pub scene: Scene,
    /// The output folder, if the scene is that of an earlier run.
    pub folder: Option<PathBuf>,
}

/// Loads the scene of a command with the settings of the command line. Those in `more` take precedence.
pub fn load(args: &SceneArgs, more: &[String]) -> Result<Loaded> {
    let options = LoadOptions {
        sets: args.set.iter().chain(more).cloned().collect(),
        quality: match (args.cells, args.quality) {
            (Some(cells), _) => Quality::Cells(cells),
            (None, Some(args::Quality::Draft)) => Quality::Draft,
            (None, Some(args::Quality::Paper)) => Quality::Paper,
            (None, Some(args::Quality::Normal) | None) => Quality::Normal,
        },
    };
    let path = Path::new(&args.scene);
    let of_run = path.join("scene.toml");
    if builtin::find(&args.scene).is_none() && of_run.is_file() {
        return Ok(Loaded { scene: Scene::load(&of_run, &options)?, folder: Some(path.to_path_buf()) });
    }
    Ok(Loaded { scene: builtin::open(&args.scene, &options)?, folder: None })
}

/// Refuses a scene that this version or this machine cannot run.
pub fn check_runnable(scene: &Scene) -> Result<()> {
    ensure_runnable(scene)?;
    ensure_columns(scene)?;
    memory::check_liquid_memory(scene, memory::machine_memory())?;
    Ok(())
}

/// The setup and the job of a scene that can run.
///
/// # Errors
/// The error of the scene, also if its solids need more memory than this machine has.
pub fn prepare(scene: &Scene) -> Result<(AnySetup, Job)> {
    let mut job = Job::of(scene, scene.to_toml()?);
    let setup = AnySetup::of(scene)?;
    let cut = displaced_liquid::check_displaced(scene, &displaced_liquid::displaced_bodies(scene, &setup))?;
    job.warnings = cut.into_iter().map(|w| format!("{}: {}", w.path, w.message)).collect();
    memory::check_solid_memory(scene, &setup, memory::machine_memory())?;
    scene.files.forget();
    Ok((setup, job))
}
