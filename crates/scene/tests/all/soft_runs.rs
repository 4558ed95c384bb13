//! What runs with solids that deform write and judge.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use meniscus_scene::build::{self, AnySetup};
use meniscus_scene::estimate::check::check;
use meniscus_scene::expect;
use meniscus_scene::file::{LoadOptions, Scene};
use meniscus_scene::output::Folder;
use meniscus_scene::output::summary::Summary;
use meniscus_scene::output::time_series::TimeSeries;
use meniscus_scene::run::{ExistingRun, Job, Outcome, SilentObserver};
use std::path::Path;

/// A soft block of 1 cm by 4 mm over the floor of a bath.
const SCENE: &str = r#"format = 1
name = "soft-runs"
[domain]
dimension = 2
size = ["3 cm", "2 cm"]
resolution = 30
[liquid]
density = "1 g/cm^3"
kinematic_viscosity = "0.2 cm^2/s"
gravity = [0, "-9.81 m/s^2"]
[[liquid.body]]
shape.box = { lower = [0, 0], upper = ["3 cm", LEVEL] }
[[solid]]
name = "block"
density = "2 g/cm^3"
shape.box = { lower = ["1 cm", "0.5 mm"], upper = ["2 cm", "4.5 mm"] }
material.neo_hookean = { young_modulus = "4 kPa", poisson_ratio = 0.3, damping_ratio = 0.5 }
[tension]
liquid_air = "20 mN/m"
block = { contact_angle = "90 deg" }
[output]
duration = "0.3 s"
frame_interval = "0.1 s"
[expect]
floats = ["block"]
"#;

fn scene(level: &str, more: &str) -> Scene {
    let text = format!("{}{more}", SCENE.replace("LEVEL", &format!("\"{level}\"")));
    Scene::from_text("runs.toml", &text, Path::new("/nowhere"), &LoadOptions::default())
        .unwrap_or_else(|e| panic!("{}", e.render()))
}

fn run(scene: &Scene, name: &str) -> (Summary, TimeSeries) {
    let out = std::env::temp_dir().join(format!("meniscus-{name}-{}", std::process::id()));
    let setup = AnySetup::of(scene).unwrap_or_else(|e| panic!("{}", e.render()));
    let job = Job::of(scene, String::new());
    let done =
        setup.run(&job, &Folder::at(&out), ExistingRun::Replace, &|| None, &mut SilentObserver).unwrap();
    let series = TimeSeries::read(&Folder::at(&out).series()).unwrap();
    std::fs::remove_dir_all(&out).unwrap();
    let Outcome::Finished(summary) = done else { panic!("it did not finish") };
    (summary, series)
}

/// A block that sticks out of shallow liquid rests on the floor: it does not float, and the floor bears the rest of its weight.
#[test]
fn what_rests_on_the_floor_does_not_float() {
    let scene = scene("2 mm", "");
    let (summary, series) = run(&scene, "rests");
    let block = &summary.solids[0];
    let weight = 2000.0 * 0.01 * 0.004 * 9.81;
    let (carried, borne) = (block.net_force[1], block.contact_force[1]);
    println!(
        "wetted {:.2}, the liquid carries {carried:.3} and the floor {borne:.3} of {weight:.3} N/m",
        block.wetted
    );
    assert!(block.wetted > 0.1 && block.wetted < 0.9);
    assert!((carried + borne - weight).abs() < 0.02 * weight && borne > 0.4 * weight);
    let verdicts = expect::evaluate(&scene, &summary, &series);
    let floats = verdicts.iter().find(|v| v.quantity.contains("which floats")).unwrap();
    assert!(!floats.pass, "{floats:?}");
    // The last line of the series has the force that the summary has.
    for (axis, force) in ["x", "y"].into_iter().zip(&block.net_force) {
        let last = series.column(&format!("force_block_{axis}")).last().unwrap();
        assert!((last - force).abs() <= 1e-9 * weight, "{axis}: {last} for {force}");
    }
}

#[test]
fn newton_iterations_are_asked_for() {
    let with = |count: u32| format!("[numerics]\nnewton_iterations = {count}\n");
    let scene = scene("2 mm", &with(3));
    assert_eq!(build::setup::<2>(&scene).unwrap().model.numerics.newton_iterations, 3);
    let again = Scene::from_text(
        "again.toml",
        &scene.to_toml().unwrap(),
        Path::new("/nowhere"),
        &LoadOptions::default(),
    );
    assert_eq!(again.unwrap(), scene);
    let load =
        |text: &str| Scene::from_text("runs.toml", text, Path::new("/nowhere"), &LoadOptions::default());
    let text = SCENE.replace("LEVEL", "\"2 mm\"");
    let e = load(&format!("{text}{}", with(50))).unwrap_err();
    assert!(e.message.contains("Newton iterations is 50"), "{e}");
    let warns = |material: &str| {
        let law =
            "material.neo_hookean = { young_modulus = \"4 kPa\", poisson_ratio = 0.3, damping_ratio = 0.5 }";
        let warnings = load(&format!("{}{}", text.replace(law, material), with(2))).unwrap().warnings.0;
        warnings.iter().any(|w| w.message.contains("no solid moves freely or deforms"))
    };
    assert!(warns("material.rigid.fixed = true") && !warns("material.rigid = {}"));
}

/// The energy of the surface of the block at rest, over its perimeter, N/m.
fn dry_tension(own: &str) -> f64 {
    let text = SCENE.replace("LEVEL", "\"6 mm\"").replace("block = { contact_angle = \"90 deg\" }", own);
    let scene = Scene::from_text("soft-runs.toml", &text, Path::new(""), &LoadOptions::default());
    let scene = scene.unwrap_or_else(|e| panic!("{}", e.render()));
    let setup = build::setup::<2>(&scene).unwrap_or_else(|e| panic!("{}", e.render()));
    let body = setup.model.solids[0].elastic().expect("a solid that deforms");
    body.elastic_energy(&body.rest_mesh().positions) / 28e-3
}

/// The tension of a wetted surface, that of the dry one less `γ cos θ`, is zero below 90 degrees and positive above.
#[test]
fn no_tension_of_a_solid_is_negative() {
    for (own, tension) in [
        ("block = { contact_angle = \"60 deg\" }", 0.01),
        ("block = { contact_angle = \"120 deg\" }", 0.0),
        ("block = { liquid_solid = \"10 mN/m\", solid_air = \"24 mN/m\" }", 0.014),
        ("block = { liquid_solid = \"10 mN/m\", solid_air = \"94 mN/m\" }", 0.02),
        ("block = { contact_angle = \"60 deg\" }\n[contact_line]\nenabled = false", 0.0),
    ] {
        let found = dry_tension(own);
        assert!((found - tension).abs() < 1e-12, "{own}: {found}");
    }
}

/// A contact line adds energy to soft solids without damping; `check` warns of these, not of damped or stiff ones.
#[test]
fn check_warns_of_soft_solids_without_damping() {
    let warned = |damping: &str, modulus: &str, line: &str| {
        let text = SCENE.replace("LEVEL", "\"2 mm\"").replace("0.5 }", damping).replace("4 kPa", modulus);
        let scene = Scene::from_text(
            "runs.toml",
            &text.replace("[tension]", line),
            Path::new("/nowhere"),
            &LoadOptions::default(),
        );
        let warnings = check(&scene.unwrap(), 1).warnings;
        warnings
            .into_iter()
            .filter(|w| w.message.contains("without damping"))
            .map(|w| w.path)
            .collect::<Vec<_>>()
    };
    assert_eq!(warned("0 }", "4 kPa", "[tension]"), ["solid.0.material"]);
    assert!(warned("0.05 }", "4 kPa", "[tension]").is_empty());
    // The cells are 1 mm: γ/Δ is 20 Pa, and 10⁴ times that 0.2 MPa.
    assert!(warned("0 }", "0.3 MPa", "[tension]").is_empty());
    assert!(warned("0 }", "4 kPa", "[contact_line]\nenabled = false\n[tension]").is_empty());
}
