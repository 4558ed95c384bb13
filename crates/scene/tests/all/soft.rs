//! Solids that deform, from the scene's text: what fills them, what moves them.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use meniscus_elastic::Elastic;
use meniscus_numerics::Vector;
use meniscus_scene::build::{self, AnySetup};
use meniscus_scene::error::SceneError;
use meniscus_scene::file::{LoadOptions, Quality, Scene, runnable};
use std::path::{Path, PathBuf};

const SCENE: &str = r#"format = 1
name = "soft"
[domain]
dimension = DIM
size = SIZE
resolution = 32
[liquid]
density = "1 g/cm^3"
kinematic_viscosity = "0.1 cm^2/s"
[[liquid.body]]
shape.ball = { center = DROP, radius = "3 mm" }
[[solid]]
name = "body"
density = "1 g/cm^3"
SHAPE
material.corotated = { young_modulus = "10 kPa", poisson_ratio = 0.3 }
[tension]
liquid_air = "70 mN/m"
[output]
duration = "10 ms"
"#;

/// A scene of 4 cm with a soft solid of the given shape (and other keys of it).
fn text(dimension: usize, shape: &str) -> String {
    let all = |entry: &str| format!("[{}]", vec![format!("\"{entry}\""); dimension].join(", "));
    let scene = SCENE.replace("DIM", &dimension.to_string()).replace("SIZE", &all("4 cm"));
    scene.replace("DROP", &all("3.6 cm")).replace("SHAPE", shape)
}

fn load(text: &str, base: &Path) -> Result<Scene, SceneError> {
    Scene::from_text("soft.toml", text, base, &LoadOptions::default())
}

fn scene(dimension: usize, shape: &str, base: &Path) -> Scene {
    let scene = load(&text(dimension, shape), base).unwrap_or_else(|e| panic!("{}", e.render()));
    runnable(&scene).unwrap_or_else(|e| panic!("{}", e.render()));
    scene
}

/// What the solid of a scene is made of.
fn with_body<const D: usize, T>(scene: &Scene, tell: impl Fn(&Elastic<D>) -> T) -> T {
    let setup = build::setup::<D>(scene).unwrap_or_else(|e| panic!("{}", e.render()));
    tell(setup.model.solids[0].elastic().expect("a solid that deforms"))
}

/// A folder of its own with a file of the given content.
fn folder(file: &str, content: &str) -> PathBuf {
    let dir = std::env::temp_dir().join(format!("meniscus-soft-{}-{file}", std::process::id()));
    std::fs::create_dir_all(&dir).unwrap();
    std::fs::write(dir.join(file), content).unwrap();
    dir
}

/// Two tetrahedra, or two triangles, on a square or its half, in centimetres, in Gmsh's format.
fn msh(dimension: usize, turned: bool) -> String {
    let (kind, nodes, elements) = match dimension {
        2 => (2, "0 0 0|1 0 0|1 1 0|0 1 0", ["1 2 3", if turned { "1 4 3" } else { "1 3 4" }]),
        _ => (4, "0 0 0|1 0 0|0 1 0|0 0 1|1 1 1", ["1 2 3 4", if turned { "3 2 4 5" } else { "2 3 4 5" }]),
    };
    let nodes: Vec<String> = nodes.split('|').enumerate().map(|(i, x)| format!("{} {x}", i + 1)).collect();
    let elements: Vec<String> =
        elements.iter().enumerate().map(|(i, e)| format!("{} {kind} 2 1 1 {e}", i + 7)).collect();
    format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{}\n{}\n$EndNodes\n$Elements\n{}\n{}\n$EndElements\n",
        nodes.len(),
        nodes.join("\n"),
        elements.len(),
        elements.join("\n")
    )
}

const CUBE: &str = "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n\
    f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

/// Volume of a solid of a shape, m³ (2D: m²).
fn volume<const D: usize>(shape: &str, base: &Path) -> f64 {
    with_body::<D, f64>(&scene(D, shape, base), |body| body.mesh().volume())
}

#[test]
fn any_shape_is_filled() {
    let none = Path::new("/nowhere");
    let near = |found: f64, expected: f64, part: f64| {
        assert!((found / expected - 1.0).abs() < part, "{found} m³ for {expected}");
    };
    // Outlines of 2 cm, 4 mm thick; areas as in `meniscus_numerics::mesh::volume::outline`.
    let cross = (5.0 + 0.1) / 3.2f64.powi(2) * 4.0;
    for (name, area) in [
        ("square", 4.0),
        ("triangle", 3f64.sqrt()),
        ("petals-4", 1.646_55),
        ("petals-6", 1.646_55),
        ("cross", cross),
        ("leaf", 1.39795),
    ] {
        let shape = format!(
            "shape.extrusion = {{ outline = \"{name}\", size = \"2 cm\", thickness = \"4 mm\", \
             center = [\"1.6 cm\", \"1.6 cm\", \"0.6 cm\"] }}"
        );
        near(volume::<3>(&shape, none), area * 0.4e-6, 0.02);
    }
    // Two balls that just touch have a neck.
    let balls = r#"shape.smooth_union = { parts = [
        { ball = { center = ["1 cm", "2 cm"], radius = "6 mm" } },
        { ball = { center = ["2.2 cm", "2 cm"], radius = "6 mm" } },
    ], width = "4 mm" }"#;
    let discs = 2.0 * std::f64::consts::PI * 0.36e-4;
    let joined = volume::<2>(balls, none);
    assert!(joined > discs && joined < 1.05 * discs, "{joined} {discs}");
    let cow = r#"shape.cow = { at = ["2 cm", "0.5 cm"], length = "3 cm" }"#;
    near(volume::<2>(cow, none), 0.418 * 9e-4, 0.03);
    let obj = folder("cube.obj", CUBE);
    let shape = r#"shape.mesh = { file = "cube.obj", scale = "4 mm", translate = ["1 cm", "1 cm", "1 cm"] }"#;
    near(volume::<3>(shape, &obj), 0.512e-6, 0.05);
    let _ = std::fs::remove_dir_all(obj);
}

/// A mesh file's own elements are the solid's.
fn own_elements<const D: usize>() {
    let dir = folder(&format!("mesh{D}.msh"), &msh(D, false));
    let place = ["1 cm"; 3][..D].iter().map(|x| format!("\"{x}\"")).collect::<Vec<_>>().join(", ");
    let shape = format!("shape.mesh = {{ file = \"mesh{D}.msh\", scale = \"2 cm\", translate = [{place}] }}");
    let scene = scene(D, &shape, &dir);
    with_body::<D, ()>(&scene, |body| {
        assert_eq!(body.mesh().simplices.len(), 2);
        let (low, high) = body.mesh().surface().0.bounds();
        assert!((low - Vector::repeat(0.01)).norm() < 1e-15 && (high - Vector::repeat(0.03)).norm() < 1e-15);
        let expected = if D == 2 { 4e-4 } else { 8e-6 * (1.0 / 6.0 + 1.0 / 3.0) };
        assert!((body.mesh().volume() / expected - 1.0).abs() < 1e-12, "{}", body.mesh().volume());
    });
    // The scene as run is the same scene, though no edge is written.
    let again = load(&scene.to_toml().unwrap(), Path::new("/elsewhere")).unwrap();
    assert_eq!(scene, again);
    let e = load(&text(D, &format!("{shape}\nmesh = {{ edge = \"1 mm\" }}")), &dir).unwrap_err();
    assert!(e.message.contains("`edge` has no effect"), "{e}");
    // An element that is inverted is named as the file names it.
    std::fs::write(dir.join(format!("mesh{D}.msh")), msh(D, true)).unwrap();
    let e = AnySetup::of(&load(&text(D, &shape), &dir).unwrap()).err().unwrap();
    assert!(e.message.contains("1 of 2 elements are inverted, the first is element 8"), "{e}");
    assert!(e.line_column().is_some() && e.exit_status() == 3, "{}", e.render());
    let _ = std::fs::remove_dir_all(dir);
}

#[test]
fn mesh_files_bring_their_elements() {
    own_elements::<2>();
    own_elements::<3>();
}

#[test]
fn parts_go_as_told() {
    let shape = |moved: &str| {
        format!(
            "shape.box = {{ lower = [\"1 cm\", \"1 cm\"], upper = [\"3 cm\", \"1.4 cm\"] }}\nvelocity = [0, \"1 cm/s\"]\n\
             moved = [{{ shape.box = {{ lower = [\"0.9 cm\", \"0.9 cm\"], upper = [\"1.2 cm\", \"1.5 cm\"] }}, {moved} }}]"
        )
    };
    let nowhere = Path::new("/nowhere");
    for (moved, ahead) in [
        (r#"velocity = ["2 cm/s", "-1 cm/s"]"#, [0.02, -0.01]),
        (
            r#"keyframes = [{ time = 0, translate = [0, 0] }, { time = "1 s", translate = ["3 cm", 0] }]"#,
            [0.03, 0.0],
        ),
    ] {
        let scene = scene(2, &shape(moved), nowhere);
        assert_eq!(scene, load(&scene.to_toml().unwrap(), nowhere).unwrap());
        let setup = build::setup::<2>(&scene).unwrap();
        let mut simulation = setup.simulation();
        let start = simulation.state.solids[0].soft.clone().unwrap().body;
        let elastic = setup.model.solids[0].elastic().unwrap();
        let speed = |v: usize| start.velocities[v];
        assert!(
            (0..start.velocities.len()).all(|v| elastic.held()[v] || speed(v) == Vector::from([0.0, 0.01]))
        );
        for _ in 0..3 {
            simulation.step(1e-3, &mut |_| {}).unwrap();
        }
        let (now, time) = (simulation.state.solids[0].soft.clone().unwrap().body, simulation.state.time);
        for v in (0..now.positions.len()).filter(|v| elastic.held()[*v]) {
            let way = now.positions[v] - start.positions[v];
            assert!((way - Vector::from(ahead) * time).norm() < 1e-12, "{way} after {time} s");
        }
    }
    for (moved, what) in [
        ("", "not told how"),
        (r#"velocity = [0, 0], keyframes = [{ time = 0, translate = [0, 0] }]"#, "both a velocity"),
        (r#"keyframes = [{ time = 0, translate = ["1 mm", 0] }]"#, "start strained"),
        (r#"velocity = ["1 km/s", 0]"#, "faster than sound"),
    ] {
        let e = load(&text(2, &shape(moved).replace(",  }", " }")), nowhere).unwrap_err();
        assert!(e.message.contains(what), "{e}");
    }
    let rigid = text(2, &shape(r#"velocity = [0, "1 cm/s"]"#));
    let rigid = rigid.replace(
        r#"material.corotated = { young_modulus = "10 kPa", poisson_ratio = 0.3 }"#,
        "material.rigid = {}",
    );
    let e = runnable(&load(&rigid, nowhere).unwrap()).unwrap_err();
    assert!(e.message.contains("moved parts of a solid that does not deform"), "{e}");
}

#[test]
fn parts_that_melt_have_bounds() {
    let endless = r#"shape.smooth_union = { parts = [{ half_space = { point = [0, "1 cm"], normal = [1, 1] } }], width = "1 mm" }"#;
    let e = load(&text(2, endless), Path::new("/nowhere")).unwrap_err();
    assert!(e.message.contains("without bounds"), "{e}");
    let beyond = r#"shape.cow = { at = ["0.5 cm", "0.5 cm"], length = "3 cm" }"#;
    let e = load(&text(2, beyond), Path::new("/nowhere")).unwrap_err();
    assert!(e.message.contains("outside the domain"), "{e}");
}

/// Every scene file that lies in the folder, built in or not, is one, in whole cells at every quality.
#[test]
fn all_scene_files_are_scenes() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let mut count = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|e| e != "toml") {
            continue;
        }
        for quality in [Quality::Draft, Quality::Normal, Quality::Paper] {
            let scene = Scene::load(&path, &LoadOptions { quality, ..LoadOptions::default() });
            let scene = scene.unwrap_or_else(|e| panic!("{}", e.render()));
            runnable(&scene).unwrap_or_else(|e| panic!("{}", e.render()));
            assert_eq!(path.file_stem().unwrap().to_str().unwrap(), scene.name);
            let odd: Vec<_> =
                scene.warnings.0.iter().filter(|w| !w.message.contains("no Young angle")).collect();
            assert!(odd.is_empty(), "{}: {odd:?}", scene.name);
            count += 1;
        }
    }
    assert!(count >= 3 * 36);
}
