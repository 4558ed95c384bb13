use super::draw::random::Random;
use super::judge::invariant_checks::InvariantChecks;
use super::rerun::accepted::accepted_scene;
use super::rerun::scene_transform::SceneTransform;
use super::{CaseOptions, CaseSet, Class, Subject};
use crate::soak::scheduled::ScheduledSimulation;
use meniscus_scene::build::setup;
use meniscus_scene::file::{LoadOptions, Scene};
use meniscus_sim::StepReport;
use std::path::Path;

fn wish(class: Option<Class>) -> CaseOptions {
    CaseOptions { set: CaseSet::Random, seed: 7, dimension: Some(2), class, quick: true }
}

const DROP: &str = r#"
format = 1
name = "drop"
[domain]
dimension = 2
size = ["4 mm", "4 mm"]
resolution = 32
[liquid]
density = "1000 kg/m^3"
dynamic_viscosity = "1 mPa s"
gravity = [0, "-9.81 m/s^2"]
[[liquid.body]]
shape.ball = { center = ["2 mm", "2.5 mm"], radius = "0.8 mm" }
velocity = ["0.1 m/s", 0]
[tension]
liquid_air = "70 mN/m"
[output]
duration = "4 ms"
frame_interval = "1 ms"
"#;

fn drop() -> Scene {
    Scene::from_text("drop.toml", DROP, Path::new(""), &LoadOptions::default()).unwrap()
}

/// The checks of a drop in flight, and the report of its third step.
fn books() -> (InvariantChecks<2>, ScheduledSimulation<2>, StepReport<2>) {
    let scene = drop();
    let mut walk = ScheduledSimulation::start(&setup::<2>(&scene).unwrap(), &scene);
    let mut books = InvariantChecks::at_start(&walk.simulation, &scene);
    for _ in 0..8 {
        let report = walk.step().unwrap();
        assert_eq!(books.check(&walk.simulation, &report), Vec::new());
    }
    let report = walk.step().unwrap();
    (books, walk, report)
}

#[test]
fn the_same_numbers_give_the_same_scene() {
    let (one, other) = (
        crate::soak::draw::scene::scene(&wish(None), 3, 0),
        crate::soak::draw::scene::scene(&wish(None), 3, 1),
    );
    assert_eq!(one, crate::soak::draw::scene::scene(&wish(None), 3, 0));
    assert_ne!(one, other);
    let mut random = Random::of(&[1, 2]);
    let mean = (0..10_000).map(|_| random.uniform_unit()).sum::<f64>() / 1e4;
    assert!((mean - 0.5).abs() < 0.01, "{mean}");
}

#[test]
fn drawn_scenes_are_of_their_class_and_run() {
    for class in Class::ALL {
        for case in 0..4 {
            let taken = accepted_scene(&Subject::Case(wish(Some(class)), case), &mut |_| ()).unwrap();
            assert_eq!(Class::of(&taken.scene), class);
            assert!(taken.refused.len() < 50, "{:?}", taken.refused);
        }
    }
}

#[test]
fn the_drop_test_runs_and_covers_its_factors() {
    for (dimension, cases) in [(2, 24), (3, 12)] {
        let wish = CaseOptions { set: CaseSet::DropTest, dimension: Some(dimension), ..wish(None) };
        for case in 0..cases {
            assert_eq!(
                crate::soak::draw::drop_test::scene(&wish, case),
                crate::soak::draw::drop_test::scene(&wish, case)
            );
            let taken = accepted_scene(&Subject::Case(wish.clone(), case), &mut |_| ());
            let words = taken.as_ref().map_or_else(String::clone, |_| String::new());
            assert!(taken.is_ok(), "{dimension}D {case}: {words}");
        }
    }
    let young = |case| {
        let text =
            crate::soak::draw::drop_test::scene(&CaseOptions { set: CaseSet::DropTest, ..wish(None) }, case);
        let words = text.split("young_modulus = \"").last().and_then(|rest| rest.split(' ').next());
        words.and_then(|word| word.parse::<f64>().ok()).unwrap()
    };
    let mut strata: Vec<u64> =
        (0..60).map(|case| (60.0 * (young(case) / 300.0f64).ln() / (1e7 / 300.0f64).ln()) as u64).collect();
    strata.sort_unstable();
    assert_eq!(strata, (0..60).collect::<Vec<_>>());
}

#[test]
fn what_is_mirrored_twice_is_as_it_was() {
    let scene = drop();
    let image = SceneTransform { mirrored: true, size: scene.domain.size[0], shift: 0.0 };
    let mirrored = image.scene(&scene).unwrap();
    assert_eq!(mirrored.liquid.bodies[0].velocity, [-0.1, 0.0]);
    assert_eq!(image.scene(&mirrored).unwrap(), scene);
}

#[test]
fn what_breaks_an_invariant_is_found() {
    type Spoil = fn(&mut StepReport<2>);
    let spoilt: [(&str, Spoil); 4] = [
        ("speed", |r| r.diagnostics.max_speed *= 100.0),
        ("energy", |r| r.diagnostics.surface_energy *= 1.1),
        ("momentum", |r| r.diagnostics.momentum *= 1.001),
        ("not-finite", |r| r.diagnostics.kinetic_energy = f64::NAN),
    ];
    for (kind, spoil) in spoilt {
        let (mut books, walk, mut report) = books();
        spoil(&mut report);
        let found = books.check(&walk.simulation, &report);
        assert!(found.iter().any(|v| v.kind == kind), "{kind}: {found:?}");
    }
}
