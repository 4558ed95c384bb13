//! Scenes with walls that wet, from the text to what is written.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use meniscus_numerics::mesh::ply::PlyMesh;
use meniscus_scene::build::{self, AnySetup};
use meniscus_scene::error::SceneError;
use meniscus_scene::estimate::check::check;
use meniscus_scene::expect;
use meniscus_scene::file::{LoadOptions, Scene, ensure_runnable};
use meniscus_scene::output::Folder;
use meniscus_scene::output::time_series::TimeSeries;
use meniscus_scene::run::{ExistingRun, Job, Outcome, SilentObserver};
use std::path::Path;

/// A drop on the bottom, and a ball that no liquid touches; its liquid ends at the bottom.
const DROP: &str = r#"format = 1
name = "puddle"
[domain]
dimension = 2
size = ["4 mm", "2 mm"]
resolution = 32
walls.top = "open"
wall_contact_angle = "60 deg"
[liquid]
density = "1 g/cm^3"
kinematic_viscosity = "20 mm^2/s"
[[liquid.body]]
shape.box = { lower = ["1.2 mm", 0], upper = ["2.5 mm", "1 mm"] }
[[solid]]
name = "bead"
density = "1 g/cm^3"
shape.ball = { center = ["3.5 mm", "1.5 mm"], radius = "0.3 mm" }
material.rigid = { fixed = true }
[tension]
liquid_air = "72 mN/m"
[contact_line]
friction = "0.01 Pa s"
[output]
duration = "60 ms"
frame_interval = "30 ms"
[expect]
contact_angle = [{ solid = "walls", value = "60 deg", tolerance = "1.5 deg" }]
"#;

fn load(text: &str) -> Result<Scene, SceneError> {
    let scene = Scene::from_text("puddle.toml", text, Path::new("."), &LoadOptions::default())?;
    ensure_runnable(&scene).map(|()| scene)
}

fn scene(text: &str) -> Scene {
    load(text).unwrap_or_else(|e| panic!("{}", e.render()))
}

#[test]
fn a_drop_wets_the_bottom() {
    let scene = scene(DROP);
    let dir = std::env::temp_dir().join(format!("meniscus-walls-{}", std::process::id()));
    let folder = Folder::at(&dir);
    let job = Job::of(&scene, String::new());
    let setup = AnySetup::of(&scene).unwrap();
    let done = setup.run(&job, &folder, ExistingRun::Replace, &|| None, &mut SilentObserver).unwrap();
    let Outcome::Finished(summary) = done else { panic!("{done:?}") };
    let verdicts = expect::evaluate(&scene, &summary, &TimeSeries::read(&folder.series()).unwrap());
    println!("{verdicts:?}");
    assert!(verdicts.iter().all(|v| v.pass) && verdicts.len() == 1);
    // The domain is told as the scene has it, the walls are no solid among the others but the one after them.
    assert_eq!((summary.cells.as_slice(), summary.solids.len()), ([32, 16].as_slice(), 1));
    assert!((summary.domain[0] - 4e-3).abs() < 1e-15 && summary.drops[0].lower[1] == 0.0);
    let files = std::fs::read_dir(dir.join("frames")).unwrap().map(|f| f.unwrap().file_name());
    let solids = files.filter(|f| f.to_str().is_some_and(|f| f.starts_with("solid_"))).count();
    let line = PlyMesh::load(&folder.frame_file("contact_line", 2, "ply")).unwrap();
    assert_eq!((solids, line.positions.len()), (3, 2));
    assert!(line.positions.iter().all(|x| x[1].abs() < 1e-9) && line.scalars["solid"] == [1.0, 1.0]);
    std::fs::remove_dir_all(dir).unwrap();
}

#[test]
fn walls_take_the_line_s_friction_and_hysteresis() {
    let window = "hysteresis = { advancing = \"70 deg\", receding = \"50 deg\" }\n[output]";
    let bead = "liquid_air = \"72 mN/m\"\nbead = { contact_angle = \"55 deg\" }";
    let text = DROP.replace("[output]", window).replace("liquid_air = \"72 mN/m\"", bead);
    let model = build::setup::<2>(&scene(&text)).unwrap().model;
    let walls = &model.solids[model.wetting_wall_solid().unwrap()];
    assert!((walls.young_cosine - 0.5).abs() < 1e-12 && walls.line_friction == 0.01);
    assert!(walls.hysteresis.is_some());
    let e = load(&text.replace("60 deg", "80 deg")).unwrap_err();
    assert!(e.message.contains("`walls`, 80.0 deg, is not between"), "{e}");
}

#[test]
fn walls_of_90_degrees_are_mirrors() {
    let mirrors = DROP.replace("wall_contact_angle = \"60 deg\"", "wall_contact_angle = \"90 deg\"");
    assert!(load(&mirrors).unwrap_err().message.contains("there is no solid `walls`"));
    let mirrors = scene(mirrors.split("[expect]").next().unwrap());
    let off = DROP.replace("friction = \"0.01 Pa s\"", "enabled = false");
    let off = scene(off.split("[expect]").next().unwrap());
    let wet = scene(DROP);
    let (margin, open) = (meniscus_sim::WETTING_WALL_MARGIN_CELLS, meniscus_sim::OPEN_SIDE_MARGIN_CELLS);
    for scene in [&mirrors, &off] {
        let model = build::setup::<2>(scene).unwrap().model;
        // Cells beyond the open side.
        assert_eq!((model.solids.len(), model.grid.cells), (1, [32, 16 + open]));
    }
    // Cells beyond three closed sides cost memory.
    let [mirrors, wet] = [mirrors, wet].map(|s| check(&s, 1));
    let more = wet.memory_bytes - mirrors.memory_bytes;
    let more_cells = (32 + 2 * margin) * (16 + margin + open) - 32 * (16 + open);
    assert_eq!(more, 200.0 * more_cells as f64);
    assert_eq!(mirrors.cells, wet.cells);
}
