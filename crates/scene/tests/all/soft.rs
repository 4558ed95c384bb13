//! Solids that deform, from the scene's text: what fills them, what moves them.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use meniscus_elastic::Elastic;
use meniscus_numerics::{Vector, mesh::ply::PlyMesh};
use meniscus_scene::build::{self, AnySetup};
use meniscus_scene::file::{LoadOptions, Quality, Scene, ensure_runnable};
use meniscus_scene::output::Folder;
use meniscus_scene::output::time_series::{COLUMNS, TimeSeries};
use meniscus_scene::run::{ExistingRun, Job, Outcome, Schedule, SilentObserver};
use meniscus_scene::{error::SceneError, expect};
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
    ensure_runnable(&scene).unwrap_or_else(|e| panic!("{}", e.render()));
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
    with_body::<D, f64>(&scene(D, shape, base), |body| body.rest_mesh().volume())
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
        // Each is a quadratic one of as many parts.
        assert_eq!(body.rest_mesh().simplices.len(), 2 << D);
        let (low, high) = body.rest_mesh().surface().0.bounds();
        assert!((low - Vector::repeat(0.01)).norm() < 1e-15 && (high - Vector::repeat(0.03)).norm() < 1e-15);
        let expected = if D == 2 { 4e-4 } else { 8e-6 * (1.0 / 6.0 + 1.0 / 3.0) };
        assert!((body.rest_mesh().volume() / expected - 1.0).abs() < 1e-12, "{}", body.rest_mesh().volume());
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
        let start = simulation.state.solids[0].as_deformable().unwrap().vertices.clone();
        let elastic = setup.model.solids[0].elastic().unwrap();
        let speed = |v: usize| start.velocities[v];
        assert!(
            (0..start.velocities.len())
                .all(|v| elastic.anchored()[v] || speed(v) == Vector::from([0.0, 0.01]))
        );
        for _ in 0..3 {
            simulation.step(1e-3, &mut |_| {}).unwrap();
        }
        let (body, time) = (simulation.state.solids[0].as_deformable().unwrap(), simulation.state.time);
        let now = &body.vertices;
        for v in (0..now.positions.len()).filter(|v| elastic.anchored()[*v]) {
            let way = now.positions[v] - start.positions[v];
            assert!((way - Vector::from(ahead) * time).norm() < 1e-12, "{way} after {time} s");
        }
    }
    for (moved, what) in [
        ("", "motion of this part is not given"),
        (r#"velocity = [0, 0], keyframes = [{ time = 0, translate = [0, 0] }]"#, "both a velocity"),
        (r#"keyframes = [{ time = 0, translate = ["1 mm", 0] }]"#, "strained at the start"),
        (r#"keyframes = [{ time = "1 s", translate = ["1 mm", 0] }]"#, "strained at the start"),
        (
            r#"keyframes = [{ time = "-1 s", translate = [0, 0] }, { time = "1 s", translate = ["1 mm", 0] }]"#,
            "strained at the start",
        ),
        (r#"velocity = ["1 km/s", 0]"#, "above the speed of sound"),
    ] {
        let e = load(&text(2, &shape(moved).replace(",  }", " }")), nowhere).unwrap_err();
        assert!(e.message.contains(what), "{e}");
    }
    let (region, half) = (
        r#"lower = ["0.9 cm", "0.9 cm"], upper = ["1.2 cm", "1.5 cm"]"#,
        r#"lower = ["0.9 cm", "0.9 cm"], upper = ["1.1 cm", "1.5 cm"]"#,
    );
    let refused = |moved: &str, fixed: &str| {
        let text = text(2, &format!("{}\nfixed = [{fixed}]", shape(moved)));
        build::setup::<2>(&load(&text, nowhere).unwrap()).err().unwrap()
    };
    let slow = r#"velocity = [0, "1 cm/s"]"#;
    let e = refused(slow, &format!("{{ box = {{ {half} }} }}"));
    assert!(e.message.contains("belong to an earlier region of `fixed`"), "{e}");
    let e = refused(slow, &format!("{{ box = {{ {region} }} }}, {{ box = {{ {half} }} }}"));
    assert!(e.message.contains("belong to earlier regions"), "{e}");
    let e = refused(r#"velocity = [0, "-10 m/s"]"#, "");
    assert!(e.message.contains("has left the domain") && e.line_column().is_some(), "{e}");
    let rigid = text(2, &shape(r#"velocity = [0, "1 cm/s"]"#));
    let rigid = rigid.replace(
        r#"material.corotated = { young_modulus = "10 kPa", poisson_ratio = 0.3 }"#,
        "material.rigid = {}",
    );
    let e = ensure_runnable(&load(&rigid, nowhere).unwrap()).unwrap_err();
    assert!(e.message.contains("moved parts of a solid that does not deform"), "{e}");
}

#[test]
fn parts_that_melt_have_bounds() {
    let endless = r#"shape.smooth_union = { parts = [{ half_space = { point = [0, "1 cm"], normal = [1, 1] } }], width = "1 mm" }"#;
    let e = load(&text(2, endless), Path::new("/nowhere")).unwrap_err();
    assert!(e.message.contains("smooth union is unbounded"), "{e}");
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
            ensure_runnable(&scene).unwrap_or_else(|e| panic!("{}", e.render()));
            assert_eq!(path.file_stem().unwrap().to_str().unwrap(), scene.name);
            let odd: Vec<_> =
                scene.warnings.0.iter().filter(|w| !w.message.contains("no Young angle")).collect();
            assert!(odd.is_empty(), "{}: {odd:?}", scene.name);
            count += 1;
        }
    }
    assert!(count >= 3 * 36);
}

/// A plate of 2 cm, `thickness` cm thick and of cells of 1.25 mm, of a material.
fn plate(thickness: f64, material: &str) -> String {
    let upper = 1.0 + thickness;
    let shape = format!("shape.box = {{ lower = [\"1 cm\", \"1 cm\"], upper = [\"3 cm\", \"{upper} cm\"] }}");
    let old = r#"corotated = { young_modulus = "10 kPa", poisson_ratio = 0.3 }"#;
    text(2, &shape).replace(old, material)
}

/// Why a scene is refused, and what of the scene is marked.
fn refused(text: &str, base: &Path) -> (SceneError, String) {
    let e = load(text, base).and_then(|s| AnySetup::of(&s).map(drop)).expect_err(text);
    assert_eq!(e.exit_status(), 3);
    let marked = e.source_text[e.span.clone().expect("a span")].to_owned();
    (e, marked)
}

#[test]
fn what_cannot_deform_is_refused() {
    let none = Path::new("/nowhere");
    let gel = r#"corotated = { young_modulus = "10 kPa", poisson_ratio = 0.3 }"#;
    // 1.5 cells are 1.875 mm.
    assert!(AnySetup::of(&load(&plate(0.1875, gel), none).unwrap()).is_ok());
    let (e, marked) = refused(&plate(0.15, gel), none);
    assert!(e.message.contains("1.2") && e.message.contains("cells (1.5"), "{e}");
    let help = e.help.clone().unwrap_or_default();
    assert!(help.contains("1.875e-3 m thick") && help.contains("resolution = 4"), "{help}");
    assert!(marked.contains("lower"), "{marked}");
    // A rigid one of that thickness is seen well enough.
    assert!(AnySetup::of(&load(&plate(0.15, "rigid = {}"), none).unwrap()).is_ok());

    let (e, marked) = refused(&plate(0.4, &gel.replace("10 kPa", "1e15 GPa")), none);
    assert!(e.message.contains("too stiff for the time step"), "{e}");
    assert!(e.help.clone().unwrap_or_default().contains("times softer"), "{}", e.render());
    assert!(marked.contains("GPa"), "{marked}");
    let stiff = r#"springs = { stiffness = "1e20 N/m" }"#;
    assert!(refused(&plate(0.4, stiff), none).0.message.contains("too stiff"));
    // Steel is not.
    assert!(AnySetup::of(&load(&plate(0.4, &gel.replace("10 kPa", "200 GPa")), none).unwrap()).is_ok());

    for (material, what, at) in [
        (gel.replace("0.3", "0.5"), "must be below 0.5", "0.5"),
        (gel.replace("10 kPa", "-10 kPa"), "the Young modulus must be above zero", "\"-10 kPa\""),
        (stiff.replace("1e20", "-3"), "the stiffness must be above zero", "\"-3 N/m\""),
        (stiff.replace(" }", ", damping_ratio = -1 }"), "the damping ratio is -1", "-1"),
    ] {
        let (e, marked) = refused(&plate(0.4, &material), none);
        assert!(e.message.contains(what) && marked == at, "{e} at {marked}");
    }
}

#[test]
fn elements_need_an_end_and_room() {
    let none = Path::new("/nowhere");
    let endless = text(2, r#"shape.half_space = { point = ["1 cm", "1 cm"], normal = [0, 1] }"#);
    let (e, marked) = refused(&endless, none);
    assert!(e.message.contains("is unbounded") && marked.contains("point"), "{e} at {marked}");
    let edge = |length: &str| {
        let shape = r#"shape.box = { lower = ["1 cm", "1 cm"], upper = ["2 cm", "1.5 cm"] }"#;
        load(&text(2, &format!("{shape}\nmesh = {{ edge = \"{length}\" }}")), none).unwrap().warnings.0
    };
    assert!(edge("3 cm").iter().any(|w| w.message.contains("exceeds the thickness of `body`")));
    assert!(!edge("5 mm").iter().any(|w| w.message.contains("thick")));
}

#[test]
fn meshes_that_are_none_are_refused() {
    // Two squares that share a corner only, an element twice, and one without area.
    for (name, elements, what) in [
        ("corner", "1 2 2 1 1 1 2 3\n2 2 2 1 1 3 4 5", "the boundary touches itself at vertex"),
        ("twice", "1 2 2 1 1 1 2 3\n2 2 2 1 1 2 3 1", "overlap"),
        ("flat", "1 2 2 1 1 1 2 3\n2 2 2 1 1 1 3 6", "the first is element 2"),
        ("twin", "1 2 2 1 1 1 2 3\n2 2 2 1 1 1 1 3", "element 2 has a vertex that does not exist"),
    ] {
        let file = format!("{name}.msh");
        let nodes = "1 0 0 0\n2 1 0 0\n3 1 1 0\n4 2 1 0\n5 2 2 0\n6 0.5 0.5 0";
        let content = format!(
            "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n6\n{nodes}\n$EndNodes\n$Elements\n2\n{elements}\n$EndElements\n"
        );
        let dir = folder(&file, &content);
        let shape = format!(
            "shape.mesh = {{ file = \"{file}\", scale = \"1 cm\", translate = [\"1 cm\", \"1 cm\"] }}"
        );
        let (e, marked) = refused(&text(2, &shape), &dir);
        assert!(e.message.contains(what) && e.message.contains(&file), "{name}: {e}");
        assert!(marked.contains("msh"), "{marked}");
        let _ = std::fs::remove_dir_all(dir);
    }
    // A surface with a hole.
    let dir = folder("open.obj", CUBE.trim_end().rsplit_once('\n').unwrap().0);
    let shape = r#"shape.mesh = { file = "open.obj", scale = "4 mm", translate = ["1 cm", "1 cm", "1 cm"] }"#;
    let (e, _) = refused(&text(3, shape), &dir);
    assert!(e.message.contains("not closed"), "{e}");
    let _ = std::fs::remove_dir_all(dir);
    // What lies beyond the domain.
    let dir = folder("cube.obj", CUBE);
    let beyond = shape.replace("open", "cube").replacen("1 cm", "3.9 cm", 1);
    let (e, marked) = refused(&text(3, &beyond), &dir);
    assert!(e.message.contains("outside the domain: it reaches from x = 0.03"), "{e}");
    assert!(marked.contains("cube.obj"), "{marked}");
    let _ = std::fs::remove_dir_all(dir);
}

#[test]
fn deflections_are_expected_and_reported() {
    let gel = r#"corotated = { young_modulus = "10 kPa", poisson_ratio = 0.3, damping_ratio = 0.1 }"#;
    let with = |expect: &str| format!("{}[expect]\n{expect}\n", plate(0.4, gel));
    let none = Path::new("/nowhere");
    let scene = load(&with(r#"deflection = { solid = "body", max = "1 mm" }"#), none).unwrap();
    assert_eq!(scene, load(&scene.to_toml().unwrap(), none).unwrap());
    for (expect, what) in [
        (r#"deflection = { solid = "body" }"#, "not bounded"),
        (r#"deflection = { solid = "bodi", max = "1 mm" }"#, "no solid `bodi`"),
        (r#"deflection = { solid = "body", min = "2 mm", max = "1 mm" }"#, "below `min`"),
    ] {
        let e = load(&with(expect), none).unwrap_err();
        assert!(e.message.contains(what), "{e}");
    }
    let rigid = with(r#"deflection = { solid = "body", max = "1 mm" }"#).replace(gel, "rigid = {}");
    assert!(load(&rigid, none).unwrap_err().message.contains("does not deform"));

    let report = meniscus_scene::estimate::check::check(&scene, 2);
    let [soft] = report.soft.as_slice() else { panic!("{report:?}") };
    let (young, nu, t) = (1e4, 0.3, 0.004);
    let wave = (young * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu)) / 1e3f64).sqrt();
    assert!((soft.wave_speed.unwrap() / wave - 1.0).abs() < 1e-12);
    assert!((soft.mass / (1e3 * 0.02 * t) - 1.0).abs() < 1e-12 && soft.held == 0);
    assert!((soft.thickness_cells.unwrap() - 3.2).abs() < 1e-9);
    let bending = young * t.powi(3) / 12.0 / (1.0 - nu * nu);
    assert!((soft.bending_stiffness.unwrap() / bending - 1.0).abs() < 1e-12);
    assert!((soft.bending_elastocapillary_length.unwrap() / (bending / 0.07f64).sqrt() - 1.0).abs() < 1e-9);
    // A free beam, plane strain: f = 22.373 / (2π L²) √(B / ρ t), less by shear and turning for one as short as this.
    let beam = 22.373 / std::f64::consts::TAU / 4e-4 * (bending / (1e3 * t)).sqrt();
    let f = soft.frequency.unwrap();
    assert!(f < beam && f > 0.75 * beam, "{f} Hz, {beam} Hz");
    assert!(soft.smallest_angle > 35.0 && soft.largest_angle < 105.0, "{soft:?}");
    let text = report.render();
    assert!(text.contains("body deforms") && text.contains("a plate of 3.20 cells"), "{text}");
}

#[test]
fn the_summary_tells_the_deflection() {
    let held = "shape.box = { lower = [\"1 cm\", \"1 cm\"], upper = [\"3 cm\", \"1.4 cm\"] }\nvelocity = [0, \"10 cm/s\"]\nHELD";
    for (fixed, bent) in [
        ("", false),
        ("fixed = [{ box = { lower = [\"0.9 cm\", \"0.9 cm\"], upper = [\"1.2 cm\", \"1.5 cm\"] } }]", true),
    ] {
        let scene = scene(2, &held.replace("HELD", fixed), Path::new("/nowhere"));
        let mut simulation = build::setup::<2>(&scene).unwrap().simulation();
        for _ in 0..5 {
            simulation.step(1e-3, &mut |_| {}).unwrap();
        }
        let way = meniscus_scene::output::summary::deflection(&simulation.solid(0)).unwrap();
        // A free plate flies as it is; one that is held bends.
        assert!(if bent { way > 1e-4 } else { way < 1e-9 }, "{way} m");
    }
}

#[test]
fn runs_tell_of_inverted_elements_and_overlaps() {
    let shape = r#"shape.box = { lower = ["1 cm", "1 cm"], upper = ["3 cm", "1.4 cm"] }"#;
    let scene = scene(2, shape, Path::new("/nowhere"));
    let mut job = Job::of(&scene, String::new());
    job.schedule = Schedule::new(1e-3, 2e-3);
    let out = std::env::temp_dir().join(format!("meniscus-sound-{}", std::process::id()));
    let setup = AnySetup::of(&scene).unwrap();
    let done =
        setup.run(&job, &Folder::at(&out), ExistingRun::Replace, &|| None, &mut SilentObserver).unwrap();
    let header = std::fs::read_to_string(out.join("timeseries.csv")).unwrap();
    let last = "deflection_body,tip_body_x,tip_body_y,tip_width_body,tip_spread_body";
    assert!(header.lines().next().unwrap().ends_with(last), "{header}");
    assert_eq!(header.lines().nth(1).unwrap().split(',').count(), COLUMNS.len() + 3 + 10);
    // The free plate's tip is at its ends, from 1 to 3 cm and 1 to 1.4 cm: their mean is its middle.
    let series = TimeSeries::parse(&header);
    let last = |name: &str| series.column(name).last().copied().unwrap();
    assert!((last("tip_body_x") - 0.02).abs() < 1e-9 && (last("tip_body_y") - 0.012).abs() < 1e-9);
    let off = last("tip_width_body") - 0.02f64.hypot(0.004);
    assert!(off.abs() < 1e-9 && last("tip_spread_body") < 1e-9 && last("line_loops_body") == 0.0);
    assert!(last("deflection_body") < 1e-9 && last("wetted_body") == 0.0 && last("angle_body_left").is_nan());
    let mesh = PlyMesh::load(&out.join("frames/solid_body_0002.ply")).unwrap();
    for name in ["ux", "uy", "uz", "strain"] {
        let values = &mesh.scalars[name];
        // It rests without weight: nothing moves.
        assert!(values.len() == mesh.positions.len() && values.iter().all(|v| v.abs() < 1e-9), "{name}");
    }
    std::fs::remove_dir_all(&out).unwrap();
    let Outcome::Finished(mut summary) = done else { panic!("it did not finish") };
    let passes = |summary: &_| -> Vec<bool> {
        expect::evaluate(&scene, summary, &TimeSeries::default()).iter().map(|v| v.pass).collect()
    };
    assert_eq!(passes(&summary), [true, true]);
    assert!(summary.least_element.unwrap() > 0.5 && summary.deepest_overlap == Some(0.0), "{summary:?}");
    (summary.least_element, summary.deepest_overlap) = (Some(-0.1), Some(summary.dx));
    assert_eq!(passes(&summary), [false, false]);
}

#[test]
fn meshes_that_are_built_in_need_no_file() {
    let none = Path::new("/nowhere");
    let leaf =
        r#"shape.mesh = { file = "builtin:leaf.msh", scale = "5 mm", translate = ["5 mm", "2 cm", "2 cm"] }"#;
    let text = text(3, leaf).replace("resolution = 32", "resolution = 80");
    let scene = load(&text, none).unwrap_or_else(|e| panic!("{}", e.render()));
    assert!(with_body::<3, usize>(&scene, |body| body.rest_mesh().simplices.len()) > 1000);
    assert_eq!(scene, load(&scene.to_toml().unwrap(), Path::new("/elsewhere")).unwrap());
    let e = load(&text.replace("leaf.msh", "leav.msh"), none).unwrap_err();
    assert!(e.message.contains("no built-in mesh `leav.msh`"), "{e}");
    assert!(e.help.as_ref().is_some_and(|h| h.contains("did you mean `builtin:leaf.msh`?")), "{e:?}");
}

#[test]
fn a_changed_mesh_file_is_another_scene() {
    let dir = folder("cube.obj", CUBE);
    let shape = r#"shape.mesh = { file = "cube.obj", scale = "4 mm", translate = ["1 cm", "1 cm", "1 cm"] }"#;
    let identity = || Job::of(&scene(3, shape, &dir), String::new()).identity;
    let before = identity();
    assert_eq!(before, identity());
    std::fs::write(dir.join("cube.obj"), format!("{CUBE}# changed\n")).unwrap();
    assert_ne!(before, identity());
    let _ = std::fs::remove_dir_all(dir);
}

#[test]
fn nothing_floats_and_sinks() {
    let expect = "[expect]\nfloats = [\"body\"]\nsinks = [\"body\"]\n";
    let (e, marked) = refused(&(plate(0.4, "rigid = {}") + expect), Path::new("/nowhere"));
    assert!(e.message.contains("cannot float and sink") && marked.contains("body"), "{e}");
}
