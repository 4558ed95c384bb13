//! An output format of one's own: each frame's contact line as a CSV table, beside the PLY files of the run.
//! It runs a drop on a plate into `out/own-frame-writer`; run it with `cargo run --release --example own_frame_writer`.

use meniscus_scene::build::AnySetup;
use meniscus_scene::file::{LoadOptions, Scene};
use meniscus_scene::output::atomic_file::write_atomically;
use meniscus_scene::output::frame::{Frame, FrameWriter};
use meniscus_scene::output::{FileError, Folder};
use meniscus_scene::run::{ExistingRun, Job, SilentObserver};
use std::error::Error;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

const SCENE: &str = r#"
format = 1
name = "own-frame-writer"
domain = { dimension = 2, size = ["20 mm", "7 mm"], resolution = 80 }
liquid.density = "1 g/cm^3"
liquid.kinematic_viscosity = "0.5 cm^2/s"
liquid.gravity = [0, "-9.81 m/s^2"]
liquid.body = [{ shape.ball = { center = ["10 mm", "2.9 mm"], radius = "2 mm" } }]
solid = [{ name = "plate", shape.half_space = { point = ["10 mm", "1 mm"], normal = [0, 1] }, material.rigid.fixed = true }]
tension = { liquid_air = "1.4142 mN/cm", plate.contact_angle = "60 deg" }
contact_line.friction = "0.5 Pa s"
output = { duration = "20 ms", frame_interval = "5 ms" }
"#;

/// Writes `contact_line_NNNN.csv`: positions and all attributes, with their units in the first row.
#[derive(Debug)]
struct LineTable;

impl FrameWriter for LineTable {
    fn write(&self, folder: &Folder, number: u64, frame: &Frame) -> Result<PathBuf, FileError> {
        let path = folder.frame_file("contact_line", number, "csv");
        let line = frame.contact_line.clone().unwrap_or_default();
        write_atomically(&path, |file| {
            write!(file, "x (m),y (m),z (m)")?;
            line.attributes.iter().try_for_each(|a| write!(file, ",{} ({})", a.name, a.unit))?;
            for (vertex, [x, y, z]) in line.positions.iter().enumerate() {
                write!(file, "\n{x},{y},{z}")?;
                line.attributes.iter().try_for_each(|a| write!(file, ",{}", a.values[vertex]))?;
            }
            writeln!(file)
        })?;
        Ok(path)
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let scene = Scene::from_text("own-frame-writer.toml", SCENE, Path::new(""), &LoadOptions::default())?;
    let mut job = Job::of(&scene, scene.to_toml()?);
    job.writers.push(Arc::new(LineTable));
    let folder = Folder::at(Path::new("out/own-frame-writer"));
    AnySetup::of(&scene)?.run(&job, &folder, ExistingRun::Replace, &|| None, &mut SilentObserver)?;
    let table = folder.frame_file("contact_line", job.last_frame(), "csv");
    println!("{}:\n{}", table.display(), std::fs::read_to_string(&table)?);
    Ok(())
}
