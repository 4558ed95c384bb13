//! Evidence of a violation: the scene as a file, and an output folder with the checkpoint before it, from which `meniscus run SCENE --out
//! FOLDER --resume` continues.

use meniscus_scene::file::Scene;
use meniscus_scene::output::time_series::TimeSeriesWriter;
use meniscus_scene::output::{FileError, Folder, SolidMeasures, atomic_file};
use meniscus_scene::run::{Job, RunStatistics, checkpoint};
use meniscus_sim::{Compiled, Model, Simulation, State};
use std::io::Write as _;
use std::path::Path;

/// Writes `NAME.toml` and the folder `NAME` into `out`.
///
/// # Errors
/// [`FileError`].
pub fn write<const D: usize>(
    out: &Path,
    scene: &Scene,
    text: &str,
    model: &Model<D>,
    state: &State<D>,
    tally: &RunStatistics,
) -> Result<(), FileError>
where
    Simulation<D>: Compiled<D>,
{
    write_scene(out, &scene.name, text)?;
    let folder = Folder::at(&out.join(&scene.name));
    let _ = std::fs::remove_dir_all(folder.root());
    atomic_file::create_folder(&folder.frames())?;
    atomic_file::create_folder(&folder.checkpoints())?;
    let job = Job::of(scene, text.to_owned());
    let names = || scene.solids.iter().map(|s| s.name.as_str());
    let simulation = Simulation::resume(model.clone(), state.clone());
    let measures = SolidMeasures::new(&simulation, scene.solids.len()).columns::<D>(names());
    let mut series = TimeSeriesWriter::create(&folder.series(), names(), &measures)?;
    let tally = RunStatistics { series_bytes: series.sync()?, ..tally.clone() };
    checkpoint::write(&folder.checkpoints(), job.identity, state, &tally)?;
    Ok(())
}

/// Writes `NAME.toml` into `out`.
///
/// # Errors
/// [`FileError`].
pub fn write_scene(out: &Path, name: &str, text: &str) -> Result<(), FileError> {
    atomic_file::create_folder(out)?;
    atomic_file::write_atomically(&out.join(format!("{name}.toml")), |w| w.write_all(text.as_bytes()))
}

/// Writes a state to a checkpoint in a folder and reads it back.
///
/// # Errors
/// A message if it fails.
pub fn checkpoint_round_trip<const D: usize>(folder: &Path, state: &State<D>) -> Result<State<D>, String> {
    atomic_file::create_folder(folder).map_err(|e| e.to_string())?;
    let path = checkpoint::write(folder, 0, state, &RunStatistics::default()).map_err(|e| e.to_string())?;
    let read = checkpoint::read(&path, 0, state.phi.grid).map_err(|e| e.to_string());
    let _ = std::fs::remove_dir_all(folder);
    read.map(|(state, _)| state)
}
