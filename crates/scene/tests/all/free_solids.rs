//! Scenes with rigid solids that move freely, from the text to the verdicts; resumed, the same bits.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use meniscus_scene::build::{self, AnySetup};
use meniscus_scene::expect;
use meniscus_scene::file::{LoadOptions, Scene, ensure_runnable};
use meniscus_scene::output::Folder;
use meniscus_scene::output::time_series::TimeSeries;
use meniscus_scene::run::{ExistingRun, Job, Outcome, SilentObserver};
use meniscus_sim::{Simulation, State};
use std::path::Path;

/// A tank with a light ball and a heavy one; the heavy one meets the floor.
const TANK: &str = r#"format = 1
name = "tank"
[domain]
dimension = 2
size = ["4 cm", "3 cm"]
resolution = 32
[liquid]
density = "1 g/cm^3"
kinematic_viscosity = "0.5 cm^2/s"
gravity = ["0 m/s^2", "-9.81 m/s^2"]
[[liquid.body]]
shape.box = { lower = [0, 0], upper = ["4 cm", "1.5 cm"] }
[[solid]]
name = "cork"
density = "0.3 g/cm^3"
shape.ball = { center = ["1 cm", "1.7 cm"], radius = "4 mm" }
material.rigid = {}
[[solid]]
name = "stone"
density = "3 g/cm^3"
shape.ball = { center = ["2.8 cm", "1 cm"], radius = "4 mm" }
material.rigid = {}
collision = { restitution = 0.1 }
[tension]
liquid_air = "10 mN/m"
[output]
duration = "0.6 s"
frame_interval = "0.6 s"
[expect]
floats = ["cork"]
sinks = ["stone"]
"#;

fn scene() -> Scene {
    let scene = Scene::from_text("tank.toml", TANK, Path::new("."), &LoadOptions::default());
    let scene = scene.unwrap_or_else(|e| panic!("{}", e.render()));
    ensure_runnable(&scene).unwrap();
    scene
}

#[test]
fn a_cork_floats_and_a_stone_sinks() {
    let scene = scene();
    assert_eq!(
        (
            scene.solids[0].collision.restitution,
            scene.solids[1].collision.restitution,
            scene.solids[1].collision.friction
        ),
        (0.3, 0.1, 0.3)
    );
    let folder = std::env::temp_dir().join(format!("meniscus-free-{}", std::process::id()));
    let job = Job::of(&scene, String::new());
    let setup = AnySetup::of(&scene).unwrap();
    let done =
        setup.run(&job, &Folder::at(&folder), ExistingRun::Replace, &|| None, &mut SilentObserver).unwrap();
    std::fs::remove_dir_all(&folder).unwrap();
    let Outcome::Finished(summary) = done else { panic!("it did not finish") };
    let verdicts = expect::evaluate(&scene, &summary, &TimeSeries::default());
    assert_eq!(verdicts.len(), 2);
    assert!(verdicts.iter().all(|v| v.pass), "{verdicts:#?} {:#?}", summary.solids);
    let mut turned = scene.clone();
    (turned.expect.sinks, turned.expect.floats) = (vec!["cork".into()], vec!["stone".into()]);
    assert!(expect::evaluate(&turned, &summary, &TimeSeries::default()).iter().all(|v| !v.pass));
    let (weight, stone) = (3000.0 * 9.81 * std::f64::consts::PI * 0.004f64.powi(2), &summary.solids[1]);
    let held = (stone.contact_force[1] + stone.net_force[1]) / weight;
    assert!((held - 1.0).abs() < 0.02, "{held} of its weight is held");
}

fn same<const D: usize>(a: &State<D>, b: &State<D>) -> bool {
    let bits = |s: &State<D>| {
        let fields =
            s.phi.data.iter().chain(&s.pressure_impulse.data).chain(s.velocity.axes.iter().flatten());
        fields.map(|v| v.to_bits()).collect::<Vec<u64>>()
    };
    bits(a) == bits(b)
        && a.solids == b.solids
        && a.elastic_slips == b.elastic_slips
        && a.components == b.components
}

#[test]
fn resumed_before_and_after_a_hit_it_is_the_same_run() {
    let mut whole: Simulation<2> = build::setup(&scene()).unwrap().simulation();
    let mut met = false;
    for step in 0..80 {
        let mut again = Simulation::resume(whole.model.clone(), whole.state.clone());
        whole.step(5e-3, &mut |_| {}).unwrap();
        again.step(5e-3, &mut |_| {}).unwrap();
        assert!(same(&whole.state, &again.state), "step {step}");
        met |=
            whole.state.solids[1].contact_acceleration.norm() > 0.0 && !whole.state.elastic_slips.is_empty();
    }
    assert!(met, "nothing was hit: {:?}", whole.state.solids[1]);
}
