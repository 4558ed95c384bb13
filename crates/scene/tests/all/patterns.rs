//! Patterns of the contact angle in scenes: what is refused and how, images, and what solids are made of them.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use meniscus_numerics::Vector;
use meniscus_scene::build::{self, AnySetup};
use meniscus_scene::error::SceneError;
use meniscus_scene::file::{LoadOptions, Scene, ensure_runnable};
use meniscus_sim::{SolidSurfaces, Solids};
use std::path::{Path, PathBuf};

const SCENE: &str = r#"format = 1
name = "test"
domain = { dimension = 3, size = ["4 mm", "4 mm", "4 mm"], resolution = 32 }
[liquid]
density = "1 g/cm^3"
kinematic_viscosity = "0.01 cm^2/s"
[[liquid.body]]
shape.ball = { center = ["2 mm", "2 mm", "2 mm"], radius = "1 mm" }
[[solid]]
name = "plate"
shape.box = { lower = ["1 mm", "1 mm", 0], upper = ["3 mm", "3 mm", "0.5 mm"] }
material.rigid = { fixed = true }
[output]
duration = "10 ms"
[tension]
liquid_air = "72.8 mN/m"
"#;

fn load(plate: &str, line: &str, base: &Path) -> Result<Scene, SceneError> {
    let text = format!("{SCENE}plate = {plate}\n{line}\n");
    let scene = Scene::from_text("test.toml", &text, base, &LoadOptions::default())?;
    ensure_runnable(&scene)?;
    let again = Scene::from_text("again.toml", &scene.to_toml()?, Path::new(""), &LoadOptions::default())?;
    assert_eq!(scene, again);
    AnySetup::of(&scene)?;
    Ok(scene)
}

/// An empty folder of the test's own, in the place for temporary files.
fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("meniscus-{name}-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// The angle, degrees, on top of the plate.
fn angle_at(scene: &Scene, x: f64, y: f64) -> f64 {
    let setup = build::setup::<3>(scene).unwrap_or_else(|e| panic!("{}", e.render()));
    let (model, states) = (&setup.model, &setup.model.initial_solids());
    let solids = Solids { model, states, surfaces: &SolidSurfaces::new(&model.solids, states) };
    let cosine = solids.get(0).young_cosine_near(&Vector::<3>::new(x, y, 5e-4), 1e-5);
    cosine.acos().to_degrees()
}

#[test]
fn what_makes_no_sense_is_refused_where_it_stands() {
    let patch = |inside: &str| format!("{{ contact_angle = \"90 deg\", patches = [{{ {inside} }}] }}");
    let block = "shape.box = { lower = [0, 0, 0], upper = [\"2 mm\", \"2 mm\", \"2 mm\"] }";
    let image = |inside: &str| format!("{{ contact_angle = \"90 deg\", image = {{ {inside} }} }}");
    let end =
        |key: &str, angle: &str| format!("{key} = {{ point = [0, 0, 0], contact_angle = \"{angle} deg\" }}");
    for (plate, message, marked) in [
        (patch(block), "`contact_angle` is missing", ""),
        (patch(&format!("{block}, contact_angle = \"190 deg\"")), "out of range", "\"190 deg\""),
        (patch(&format!("{block}, contact_angle = \"1 m\"")), "is a length", "\"1 m\""),
        (
            patch("shape.ball = { center = [0, 0, \"3 mm\"], radius = \"1 mm\" }, contact_angle = \"9 deg\""),
            "does not reach the solid",
            "center",
        ),
        (
            patch(
                "shape.wave = { level = 0, amplitude = 0, wavelength = \"1 mm\" }, contact_angle = \"9 deg\"",
            ),
            "does not support patches of this shape",
            "shape",
        ),
        (
            image("file = \"a.jpg\", lower = [0, 0], upper = [0, 0], black = 0, white = 0"),
            "not a supported image file",
            "\"a.jpg\"",
        ),
        (
            image("file = \"a.png\", lower = [0, 0], upper = [0, 0], black = 0, white = 0"),
            "there is no image `a.png`",
            "\"a.png\"",
        ),
        (
            format!("{{ gradient = {{ {}, {} }} }}", end("from", "10"), end("to", "20")),
            "points of the gradient are the same",
            "[0, 0, 0]",
        ),
        (
            format!("{{ gradient = {{ {}, {} }} }}", end("from", "10"), end("to", "200")),
            "out of range",
            "\"200 deg\"",
        ),
        ("{ patches = [] }".to_owned(), "no tension is given for this solid", "{ patches = [] }"),
        ("{ contact_angle = \"9 deg\", patch = [] }".to_owned(), "unknown key `patch`", "patch"),
    ] {
        let e = load(&plate, "", Path::new("/nowhere")).expect_err(&plate);
        assert_eq!(e.exit_status(), 3);
        assert!(e.message.contains(message), "{}", e.render());
        let found = &e.source_text[e.span.clone().expect("a span")];
        assert!(found.contains(marked), "{found}: {}", e.render());
    }
}

#[test]
fn lines_on_patterns_rest_around_youngs_angle() {
    let plate = "{ contact_angle = \"90 deg\", patches = [{ shape.ball = { center = [\"2 mm\", \"2 mm\", 0], radius \
                 = \"1 mm\" }, contact_angle = \"30 deg\" }] }";
    let line = |inside: &str| format!("[contact_line]\nhysteresis = {{ {inside} }}");
    let load = |inside: &str| load(plate, &line(inside), Path::new(""));
    let e = load("advancing = \"100 deg\", receding = \"20 deg\"").unwrap_err();
    assert!(e.message.contains("`plate` varies") && e.render().contains("above ="), "{}", e.render());
    let e = load("advancing = \"100 deg\", below = \"20 deg\"").unwrap_err();
    assert!(e.message.contains("do not define the hysteresis"), "{}", e.render());
    let scene = load("above = \"10 deg\", below = \"5 deg\"").unwrap_or_else(|e| panic!("{}", e.render()));
    let setup = build::setup::<3>(&scene).unwrap();
    let bounds = setup.model.solids[0].hysteresis.unwrap().cosine_bounds(30f64.to_radians().cos());
    let [advancing, receding] = bounds.map(|c| c.acos().to_degrees());
    assert!((advancing - 40.0).abs() < 1e-9 && (receding - 25.0).abs() < 1e-9, "{advancing} {receding}");
}

#[test]
fn patches_and_gradients_become_angles() {
    let scene = load(
        "{ gradient = { from = { point = [\"1 mm\", 0, 0], contact_angle = \"0 deg\" }, to = { point = [\"3 mm\", 0, \
         0], contact_angle = \"180 deg\" } }, patches = [{ shape.box = { lower = [0, 0, 0], upper = [\"4 mm\", \
         \"1.5 mm\", \"0.5 mm\"] }, contact_angle = \"40 deg\" }] }",
        "",
        Path::new(""),
    );
    let scene = scene.unwrap_or_else(|e| panic!("{}", e.render()));
    for (x, y, angle) in [(2e-3, 2e-3, 90.0), (1.5e-3, 2e-3, 60.0), (1.5e-3, 1.2e-3, 40.0)] {
        assert!((angle_at(&scene, x, y) - angle).abs() < 1e-6, "{}", angle_at(&scene, x, y));
    }
}

#[test]
fn images_become_angles() {
    let folder = folder("image");
    let rgba = [[0, 0, 0, 255], [255, 255, 255, 255], [255, 255, 255, 255], [0, 0, 0, 0]];
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, 2, 2);
    encoder.set_color(png::ColorType::Rgba);
    encoder.write_header().unwrap().write_image_data(&rgba.concat()).unwrap();
    std::fs::write(folder.join("a.png"), file).unwrap();
    std::fs::write(folder.join("bad.png"), "no image").unwrap();
    let plate = |name: &str| {
        format!(
            "{{ contact_angle = \"120 deg\", image = {{ file = \"{name}\", lower = [\"1 mm\", \"1 mm\"], upper = \
             [\"2 mm\", \"2 mm\"], black = \"60 deg\", white = \"90 deg\" }} }}"
        )
    };
    let scene = load(&plate("a.png"), "", &folder).unwrap_or_else(|e| panic!("{}", e.render()));
    // Black is upper left, the clear pixel lower right.
    for (x, y, angle) in [(1.2e-3, 1.8e-3, 60.0), (1.8e-3, 1.8e-3, 90.0), (1.2e-3, 1.2e-3, 90.0)] {
        assert!((angle_at(&scene, x, y) - angle).abs() < 1e-6, "{x} {y}: {}", angle_at(&scene, x, y));
    }
    let between = angle_at(&scene, 1.5e-3, 1.8e-3).to_radians().cos();
    assert!((between - 0.25).abs() < 1e-3, "{between}");
    for (x, y) in [(1.8e-3, 1.2e-3), (2.5e-3, 2.5e-3)] {
        assert!((angle_at(&scene, x, y) - 120.0).abs() < 1e-6, "{x} {y}: {}", angle_at(&scene, x, y));
    }
    let e = load(&plate("bad.png"), "", &folder).unwrap_err();
    assert!(e.message.contains("the image cannot be read"), "{}", e.render());
    assert!(e.render().contains("file = \"bad.png\""), "{}", e.render());
    std::fs::remove_dir_all(&folder).unwrap();
}
