//! Every kind of bad scene: the exact text that a person sees, and the exit status.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use meniscus_scene::build::AnySetup;
use meniscus_scene::error::SceneError;
use meniscus_scene::estimate::memory;
use meniscus_scene::expect::ensure_columns;
use meniscus_scene::file::{LoadOptions, Scene, ensure_runnable};
use meniscus_scene::output::frame::Format;
use std::path::Path;

const GOOD: &str = r#"format = 1
name = "test"

[domain]
dimension = 3
size = ["3 mm", "3 mm", "3 mm"]
resolution = 32
walls = { all = "slip" }

[liquid]
density = "1 g/cm^3"
kinematic_viscosity = "0.01 cm^2/s"

[[liquid.body]]
shape.ball = { center = ["1.5 mm", "1.5 mm", "1.5 mm"], radius = "1 mm" }

[tension]
liquid_air = "72.8 mN/m"

[output]
duration = "10 ms"
"#;

const SOLID: &str = r#"
[[solid]]
name = "plate"
shape.box = { lower = ["1 mm", "1 mm", "0.1 mm"], upper = ["2 mm", "2 mm", "0.3 mm"] }
material.rigid = { fixed = true }
"#;

fn load(text: &str, sets: &[&str]) -> Result<Scene, SceneError> {
    let options =
        LoadOptions { sets: sets.iter().map(|s| (*s).to_owned()).collect(), ..LoadOptions::default() };
    Scene::from_text("test.toml", text, Path::new("/nowhere"), &options)
}

/// The error of the good scene with a piece replaced.
fn bad(from: &str, to: &str) -> SceneError {
    assert!(GOOD.contains(from), "{from}");
    bad_text(&GOOD.replacen(from, to, 1))
}

fn bad_text(text: &str) -> SceneError {
    let e = load(text, &[]).and_then(|s| ensure_runnable(&s)).expect_err(text);
    assert_eq!(e.exit_status(), 3);
    e
}

fn marked(e: &SceneError) -> &str {
    &e.source_text[e.span.clone().expect("a span")]
}

#[test]
fn bounds_of_the_time_series_name_a_column_and_a_bound() {
    let with = |bound: &str| format!("{GOOD}{SOLID}[expect]\nseries = {bound}\n");
    let e = bad_text(&with("{ column = \"max_speed\" }"));
    assert!(e.message.contains("not bounded"), "{e}");
    let e = bad_text(&with("{ column = \"max_speed\", min = 2, max = 1 }"));
    assert_eq!(marked(&e), "1");
    let e = bad_text(&with("{ column = \"max_speed\", max = 1, from = \"2 s\", until = \"1 s\" }"));
    assert!(e.message.contains("is before `from`"), "{e}");
    let scene =
        load(&with("[{ column = \"drops\", max = 1 }, { column = \"wetted_nothing\", max = 1 }]"), &[]);
    let e = ensure_columns(&scene.unwrap()).unwrap_err();
    assert_eq!((marked(&e), e.exit_status()), ("\"wetted_nothing\"", 3));
}

#[test]
fn the_good_scene_is_good() {
    let scene = load(GOOD, &[]).unwrap_or_else(|e| panic!("{}", e.render()));
    ensure_runnable(&scene).unwrap();
    assert_eq!(scene.domain.cells, [32, 32, 32]);
    assert_eq!(scene.tension.liquid_air, 0.0728);
    load(&format!("{GOOD}{SOLID}"), &[]).unwrap_or_else(|e| panic!("{}", e.render()));
}

#[test]
fn misspelt_key() {
    assert_eq!(
        bad("resolution = 32", "resolutoin = 32").render(),
        "error: unknown key `resolutoin`\n --> test.toml:7:1\n  |\n7 | resolutoin = 32\n  | ^^^^^^^^^^\n  \
         help: did you mean `resolution`? accepted: dimension, size, resolution, dx, quality, walls, \
         wall_contact_angle\n"
    );
}

#[test]
fn a_table_below_the_header_of_another() {
    let e = bad("[tension]\nliquid_air", "tension.liquid_air");
    assert_eq!((e.message.as_str(), marked(&e)), ("unknown key `tension`", "tension"));
    assert!(e.help.as_deref().is_some_and(|help| help.contains("`[tension]` as a header of its own")));
}

#[test]
fn a_list_is_no_table() {
    let e = bad("[output]\nduration = \"10 ms\"", "[[output]]\nduration = \"10 ms\"");
    assert_eq!(e.message, "found a list");
    let e = bad("[output]\nduration = \"10 ms\"", "[output]\nduration = 2026-01-01");
    assert_eq!(e.message, "found a date");
}

#[test]
fn wrong_dimension() {
    assert_eq!(
        bad("\"1 g/cm^3\"", "\"1 g/cm\"").render(),
        "error: `1 g/cm` is in kg m^-1, but a density is wanted\n  --> test.toml:11:11\n   |\n\
         11 | density = \"1 g/cm\"\n   |           ^^^^^^^^\n  \
         help: a density is written as text with a unit, one of: kg/m^3, g/cm^3\n"
    );
}

#[test]
fn bare_number() {
    let e = bad("radius = \"1 mm\"", "radius = 0.001");
    assert_eq!(
        e.render(),
        "error: the number 0.001 has no unit\n  --> test.toml:15:66\n   |\n\
         15 | shape.ball = { center = [\"1.5 mm\", \"1.5 mm\", \"1.5 mm\"], radius = 0.001 }\n   |  \
         \u{20}                                                               ^^^^^\n  \
         help: a length is written as text with a unit, one of: m, cm, mm, um, dx (cells); like \"0.001 mm\"\n"
    );
    assert_eq!(e.line_column(), Some((15, 66)));
}

#[test]
fn unknown_unit_and_not_finite() {
    let e = bad("\"1 mm\"", "\"1.5 furlong\"");
    assert_eq!(marked(&e), "\"1.5 furlong\"");
    assert!(e.message.contains("unknown unit `furlong`"), "{e}");
    for text in ["\"inf m\"", "\"1e999 m\"", "inf", "nan"] {
        assert_eq!(marked(&bad("\"1 mm\"", text)), text);
    }
}

#[test]
fn sizes() {
    for (text, what) in [("\"0 mm\"", "above zero"), ("\"-1 mm\"", "above zero"), ("0", "above zero")] {
        let e = bad("\"1 mm\"", text);
        assert_eq!(marked(&e), text);
        assert!(e.message.contains(what), "{e}");
    }
    assert_eq!(marked(&bad("resolution = 32", "resolution = 0")), "0");
    assert_eq!(marked(&bad("[\"3 mm\", ", "[\"0 mm\", ")), "\"0 mm\"");
    assert_eq!(marked(&bad("\"10 ms\"", "\"-10 ms\"")), "\"-10 ms\"");
    assert_eq!(marked(&bad("\"72.8 mN/m\"", "\"0 N/m\"")), "\"0 N/m\"");
}

#[test]
fn outside_the_domain() {
    let value = "{ center = [\"9 mm\", \"1.5 mm\", \"1.5 mm\"], radius = \"1 mm\" }";
    let expected = format!(
        "error: the liquid is outside the domain: it reaches from x = 0.008 m to 0.01 m\n  \
         --> test.toml:15:14\n   |\n15 | shape.ball = {value}\n   |              {}\n  \
         help: the domain reaches from x = 0 m to 0.003 m\n",
        "^".repeat(value.len())
    );
    assert_eq!(bad("center = [\"1.5 mm\"", "center = [\"9 mm\"").render(), expected);
}

#[test]
fn shapes() {
    let corners = "box = { lower = [\"1 mm\", \"1 mm\", \"1 mm\"], upper = [\"2 mm\", \"1 mm\", \"2 mm\"] }";
    let ball = "ball = { center = [\"1.5 mm\", \"1.5 mm\", \"1.5 mm\"], radius = \"1 mm\" }";
    let e = bad(ball, corners);
    assert_eq!(e.line_column(), Some((15, 66)), "{}", e.render());
    assert!(e.message.contains("not above `lower`"), "{e}");
    let e = bad("ball = {", "bal = {");
    assert!(e.help.as_deref().is_some_and(|h| h.contains("did you mean `ball`?")), "{}", e.render());
    assert_eq!(marked(&e), "bal");
    let mode = "perturbed_ball = { center = [0, 0, 0], radius = \"1 mm\", mode = 1, amplitude = 0.1 }";
    assert_eq!(marked(&bad(ball, mode)), "1");
    let e = bad("[\"1.5 mm\", \"1.5 mm\", \"1.5 mm\"]", "[\"1.5 mm\", \"1.5 mm\"]");
    assert_eq!(marked(&e), "[\"1.5 mm\", \"1.5 mm\"]");
    assert!(e.message.contains("2 entries"), "{e}");
    let e = bad(ball, "mesh = { file = \"lost.stl\" }");
    assert_eq!(marked(&e), "\"lost.stl\"");
    assert!(e.message.contains("no mesh file"), "{e}");
    assert!(bad(ball, "mesh = { file = \"a.exe\" }").message.contains("not a supported mesh file"));
    assert!(bad(ball, "union = []").message.contains("the union contains no shape"));
    let e = bad(
        ball,
        "cylinder = { center = [0, 0, 0], axis = [0, 0, 0], radius = \"1 mm\", height = \"1 mm\" }",
    );
    assert_eq!(marked(&e), "[0, 0, 0]");
}

#[test]
fn structure() {
    assert!(bad("format = 1", "format = 2").message.contains("format 2"));
    assert_eq!(marked(&bad("\"test\"", "\"../up\"")), "\"../up\"");
    let e = bad("duration = \"10 ms\"", "");
    assert!(e.message.contains("`duration` is missing"), "{e}");
    let e = bad("dimension = 3", "dimension = 3\ndimension = 3");
    assert!(e.line_column().is_some(), "{}", e.render());
    let e = bad("dimension = 3", "dimension = \"3\"");
    assert_eq!(
        (marked(&e), e.help.as_deref()),
        ("\"3\"", Some("expected a whole number, not negative, no quotes"))
    );
    let e = bad("dimension = 3", "dimension = ");
    assert!(e.span.is_some(), "{}", e.render());
    let e = bad("walls = { all = \"slip\" }", "walls = { all = \"slipp\" }");
    assert_eq!(marked(&e), "\"slipp\"");
    assert!(e.help.as_deref().is_some_and(|h| h.contains("did you mean `slip`?")));
    let e = bad("resolution = 32", "resolution = 32\ndx = \"0.1 mm\"");
    assert!(e.message.contains("both"), "{e}");
    let e = bad(
        "liquid_air = \"72.8 mN/m\"",
        "liquid_air = \"72.8 mN/m\"\nplat = { contact_angle = \"60 deg\" }",
    );
    assert_eq!(marked(&e), "plat");
}

#[test]
fn what_cannot_run_yet() {
    let sheet = "shell = { young_modulus = \"1 MPa\", poisson_ratio = 0.3, thickness = \"0.1 mm\" }";
    let soft = SOLID.replacen("rigid = { fixed = true }", sheet, 1).replacen(
        "name =",
        "density = \"1 g/cm^3\"\nname =",
        1,
    );
    let e = bad_text(&format!("{GOOD}{soft}"));
    assert!(e.message.contains("thin sheets"), "{e}");
    assert_eq!(e.line_column().map(|at| at.0), Some(27), "{}", e.render());
    let paper = "
[numerics]
scheme = \"paper\"
";
    let e = bad_text(&format!(
        "{GOOD}{SOLID}{paper}[contact_line]
friction = \"0.3 Pa s\"
"
    ));
    assert!(e.message.contains("friction of contact lines with numerics.scheme"), "{e}");
    assert_eq!(marked(&e), "\"0.3 Pa s\"");
    let e = bad_text(&format!("{GOOD}{SOLID}{paper}[contact_line]\nneumann = true\n"));
    assert!(e.message.contains("Neumann's balance of tensions with numerics.scheme"), "{e}");
    let e = bad_text(&format!("{GOOD}\n[contact_line]\nneumann = true\n"));
    assert!(e.message.contains("no solid deforms"), "{e}");
}

#[test]
fn every_format_that_an_error_accepts_is_written() {
    let e = bad_text(&format!("{GOOD}formats = [\"page\", \"udz\"]\n"));
    assert_eq!(marked(&e), "\"udz\"", "{}", e.render());
    let said = e.line();
    for format in Format::ALL {
        assert!(said.contains(format.name()), "{said} does not name {}", format.name());
        assert!(format == Format::Page || format.frame_writer().is_some(), "{}", format.name());
    }
    let flat = GOOD
        .replace("dimension = 3", "dimension = 2")
        .replace("[\"3 mm\", \"3 mm\", \"3 mm\"]", "[\"3 mm\", \"3 mm\"]")
        .replace("[\"1.5 mm\", \"1.5 mm\", \"1.5 mm\"]", "[\"1.5 mm\", \"1.5 mm\"]");
    let e = bad_text(&format!("{flat}formats = [\"page\", \"vdb\"]\n"));
    assert_eq!(marked(&e), "\"vdb\"");
    assert!(e.line().contains("3 dimensions") && e.line().contains("vti"), "{e}");
}

#[test]
fn a_line_that_is_off_has_no_friction() {
    let e = bad_text(&format!("{GOOD}\n[contact_line]\nenabled = false\nfriction = \"0.3 Pa s\"\n"));
    assert_eq!(marked(&e), "\"0.3 Pa s\"");
}

#[test]
fn lines_rest_around_their_angle() {
    let window = "\n[contact_line]\nhysteresis = { advancing = \"80 deg\", receding = \"50 deg\" }\n";
    let e = bad_text(&format!("{GOOD}{SOLID}{window}").replacen(
        "liquid_air = \"72.8 mN/m\"",
        "liquid_air = \"72.8 mN/m\"\nplate = { contact_angle = \"90 deg\" }",
        1,
    ));
    assert!(e.message.contains("`plate`, 90.0 deg, is not between the receding angle, 50.0 deg"), "{e}");
}

#[test]
fn solids_make_sense() {
    let with = |from: &str, to: &str| {
        assert!(SOLID.contains(from));
        load(&format!("{GOOD}{}", SOLID.replacen(from, to, 1)), &[]).expect_err(to)
    };
    let e = with("\"0.3 mm\"", "\"4 mm\"");
    assert!(e.message.contains("the solid `plate` extends outside the domain"), "{e}");
    assert!(with("\"plate\"", "\"liquid_air\"").message.contains("liquid_air"));
    assert!(with("fixed = true", "").message.contains("density"));
    let e = load(&format!("{GOOD}{SOLID}{SOLID}"), &[]).unwrap_err();
    assert_eq!(e.line_column(), Some((29, 8)), "{}", e.render());
    let wets = "72.8 mN/m\"\nplate = { liquid_solid = \"0 N/m\", solid_air = \"1 N/m\" }";
    let text = GOOD.replacen("72.8 mN/m\"", wets, 1);
    let scene = load(&format!("{text}{SOLID}"), &[]).unwrap_or_else(|e| panic!("{}", e.render()));
    assert!(scene.warnings.0[0].message.contains("no Young angle"));
}

#[test]
fn free_solids_have_room() {
    let free = SOLID.replacen("{ fixed = true }", "{}", 1).replacen(
        "name = \"plate\"",
        "density = \"1 g/cm^3\"\nname = \"boat\"",
        1,
    );
    let start = |text: &str| load(text, &[]).and_then(|s| AnySetup::of(&s).map(drop));
    start(&format!("{GOOD}{free}")).unwrap_or_else(|e| panic!("{}", e.render()));
    let e = start(&format!("{GOOD}{SOLID}{free}")).unwrap_err();
    assert_eq!(e.exit_status(), 3);
    assert!(e.message.contains("`boat` overlaps the solid `plate` by"), "{e}");
    assert_eq!(e.line_column().map(|at| at.0), Some(31), "{}", e.render());
    // What does not move may overlap, and what only touches is no overlap.
    start(&format!("{GOOD}{SOLID}{}", SOLID.replacen("plate", "other", 1))).unwrap();
    let beside = free.replacen("\"1 mm\", \"1 mm\", \"0.1 mm\"", "\"1 mm\", \"1 mm\", \"0.3 mm\"", 1);
    start(&format!("{GOOD}{SOLID}{}", beside.replacen("\"0.3 mm\"] }", "\"0.5 mm\"] }", 1))).unwrap();
    let (before, rest) = free.split_once("shape.box").unwrap();
    let (_, after) = rest.split_once('\n').unwrap();
    let plane = "shape.half_space = { point = [0, 0, \"1 mm\"], normal = [0, 0, 1] }";
    let e = start(&format!("{GOOD}{before}{plane}\n{after}")).unwrap_err();
    assert!(e.message.contains("`boat` is unbounded"), "{e}");
    let e = load(&format!("{GOOD}{free}collision.restitution = 1.5\n"), &[]).unwrap_err();
    assert_eq!(marked(&e), "1.5");
    let e = load(&format!("{GOOD}{free}collision.friction = -1\n"), &[]).unwrap_err();
    assert_eq!(marked(&e), "-1");
}

#[test]
fn solids_that_jump_or_that_the_grid_cannot_see() {
    let moved = |time: &str| {
        let frames = format!(
            "{{ keyframes = [{{ time = \"0 s\", translate = [\"0 m\", \"0 m\", \"0 m\"] }}, \
             {{ time = \"{time}\", translate = [\"0 m\", \"0 m\", \"1 mm\"] }}] }}"
        );
        let kinematic = SOLID.replacen("rigid = { fixed = true }", &format!("kinematic = {frames}"), 1);
        load(&format!("{GOOD}{kinematic}"), &[])
    };
    moved("1 ms").unwrap_or_else(|e| panic!("{}", e.render()));
    let e = moved("1 us").unwrap_err();
    assert!(e.message.contains("speed of 1000 m/s is above the speed of sound"), "{e}");
    let start = |set: &str| load(&format!("{GOOD}{SOLID}"), &[set]).and_then(|s| AnySetup::of(&s).map(drop));
    start("domain.dx=0.15 mm").unwrap_or_else(|e| panic!("{}", e.render()));
    let e = start("domain.dx=0.3 mm").unwrap_err();
    assert!(e.message.contains("`plate` is thinner than a cell"), "{e}");
    assert_eq!(e.exit_status(), 3);
}

#[test]
fn settings() {
    let scene = load(
        GOOD,
        &["domain.resolution=64", "tension.liquid_air=0.5 mN/cm", "output.frame_interval=\"1 ms\""],
    );
    let scene = scene.unwrap_or_else(|e| panic!("{}", e.render()));
    assert_eq!(
        (scene.domain.cells[0], scene.tension.liquid_air, scene.output.frame_interval()),
        (64, 0.05, 1e-3)
    );
    let scene = load(GOOD, &["liquid.body.0.velocity=[\"1 m/s\", 0, 0]", "domain.dx=0.1 mm"]).unwrap();
    assert_eq!((scene.liquid.bodies[0].velocity[0], scene.domain.cells[0]), (1.0, 30));
    for (set, message, mark) in [
        ("domain.resolutoin=64", "unknown key `resolutoin`", "resolutoin"),
        ("liquid.body.3.velocity=[0,0,0]", "`body` has no entry `3`", "3"),
        ("domain.resolution.x=1", "`resolution` is an integer, it has no key `x`", "x"),
        ("domain.resolution", "not of the form path=value", "domain.resolution"),
        ("domain..x=1", "empty part", ""),
        ("tension.liquid_air=5 cm", "is a length", "5 cm"),
        ("domain.size=[\"1 m\"", "", ""),
    ] {
        let e = load(GOOD, &[set]).expect_err(set);
        assert!(e.message.contains(message), "{set}: {e}");
        assert_eq!(e.source_name, "--set");
        if !mark.is_empty() {
            assert_eq!(marked(&e), mark, "{set}");
        }
    }
}

#[test]
fn too_much_memory() {
    let scene = load(GOOD, &["domain.resolution=256"]).unwrap();
    let need = memory::liquid_memory(256_f64.powi(3), 0.0);
    memory::check_liquid_memory(&scene, Some(64 << 30)).unwrap();
    let e = memory::check_liquid_memory(&scene, Some(need as u64 / 2)).unwrap_err();
    assert_eq!((e.exit_status(), e.source_name.as_str()), (3, "--set"));
    assert!(e.message.contains("3.4 GB of memory, this machine has 1.7 GB"), "{e}");
    assert!(e.help.as_deref().is_some_and(|h| h.contains("resolution = 19")), "{e:?}");
}

#[test]
fn missing_file() {
    let e = Scene::load(Path::new("/nowhere/a.toml"), &LoadOptions::default()).unwrap_err();
    assert_eq!(e.exit_status(), 4);
    let e = meniscus_scene::builtin::open("oscilating-drop", &LoadOptions::default()).unwrap_err();
    assert!(e.help.as_deref().is_some_and(|h| h.contains("`oscillating-drop`")));
}

#[test]
fn deep_nesting_is_refused() {
    for text in [
        format!("{} = 1", vec!["a"; 100_000].join(".")),
        format!("a = {}", "[".repeat(100_000)),
        format!("a = {}", "{a=".repeat(100_000)),
        format!("[{}]", vec!["a"; 100_000].join(".")),
        (0..20_000).map(|i| format!("[{}]\n", vec!["a"; i % 500 + 1].join("."))).collect(),
    ] {
        assert!(load(&text, &[]).is_err());
    }
}

#[test]
fn solids_that_deform_are_what_they_can_be() {
    let soft = |material: &str, more: &str| {
        let solid = SOLID.replacen("material.rigid = { fixed = true }", material, 1);
        format!("{GOOD}{solid}density = \"1 g/cm^3\"\n{more}")
    };
    let gel = "material.neo_hookean = { young_modulus = \"1 kPa\", poisson_ratio = 0.3 }";
    let e = bad_text(&soft(&gel.replace("0.3", "0.5"), ""));
    assert!(e.message.contains("Poisson"), "{e}");
    let e = bad_text(&soft(&gel.replace("1 kPa", "-1 kPa"), ""));
    assert!(e.message.contains("Young"), "{e}");
    // What only the mesh can tell.
    let held =
        "fixed = [{ ball = { center = [\"2.5 mm\", \"2.5 mm\", \"2.5 mm\"], radius = \"0.1 mm\" } }]\n";
    let scene = load(&soft(gel, held), &[]).unwrap();
    let e = AnySetup::of(&scene).err().unwrap();
    assert!(e.message.contains("contains no vertex of the solid `plate`"), "{e}");
    assert!(e.line_column().is_some() && e.exit_status() == 3, "{}", e.render());
    let scene = load(&soft(gel, ""), &[]).unwrap();
    let setup = AnySetup::of(&scene).unwrap();
    memory::check_solid_memory(&scene, &setup, Some(64 << 30)).unwrap();
    let e = memory::check_solid_memory(&scene, &setup, Some(1 << 20)).unwrap_err();
    assert!(e.help.as_deref().is_some_and(|h| h.contains("are for the solid `plate` with")), "{e:?}");
    assert!(e.line_column().is_some() && e.exit_status() == 3, "{}", e.render());
    // Three tensions balance at the line only where all are known.
    let line = "\n[contact_line]\nneumann = true\nradius = \"2 dx\"\n";
    let with = |tensions: &str| {
        let air = "liquid_air = \"72.8 mN/m\"";
        let scene = load(&soft(gel, line).replacen(air, &format!("{air}\n{tensions}"), 1), &[]);
        let scene = scene.unwrap_or_else(|e| panic!("{tensions}: {}", e.render()));
        (AnySetup::of(&scene), scene.domain.dx)
    };
    let refused = |tensions: &str, why: &str| {
        let Err(e) = with(tensions).0 else { panic!("not refused: {tensions}") };
        assert!(e.message.contains(why) && marked(&e) == "true", "{tensions}: {e}");
    };
    refused("", "`neumann` needs uniform tensions");
    refused("plate = { contact_angle = \"80 deg\" }", "`neumann` needs uniform tensions");
    refused("plate = { liquid_solid = \"20 mN/m\", solid_air = \"99 mN/m\" }", "no Neumann balance exists");
    match with("plate = { liquid_solid = \"20 mN/m\", solid_air = \"30 mN/m\" }") {
        (Ok(AnySetup::D3(setup)), dx) => {
            assert!((setup.model.numerics.line_radius / dx - 2.0).abs() < 1e-9);
        }
        (other, _) => panic!("not a setup in space: {:?}", other.err()),
    }
}

/// Two solids that deform need a gap between them; a floor that is rigid needs none.
#[test]
fn soft_solids_do_not_touch() {
    let soft = |name: &str, low: f64, high: f64| {
        let block = SOLID.replacen("plate", name, 1).replacen("name", "density = \"1 g/cm^3\"\nname", 1);
        let block = block.replacen(
            "rigid = { fixed = true }",
            "neo_hookean = { young_modulus = \"10 kPa\", poisson_ratio = 0.4 }",
            1,
        );
        block.replacen("0.3 mm", &format!("{high} mm"), 1).replacen("0.1 mm", &format!("{low} mm"), 1)
    };
    let start = |solids: &str| load(&format!("{GOOD}{solids}"), &[]).and_then(|s| AnySetup::of(&s).map(drop));
    let on = |gap: f64| format!("{}{}", soft("low", 0.3, 0.7), soft("high", 0.7 + gap, 1.1 + gap));
    let e = start(&on(0.0)).unwrap_err();
    assert_eq!(e.exit_status(), 3);
    assert!(e.message.contains("the deformable solid `high` touches the solid `low`"), "{e}");
    start(&on(0.1)).unwrap_or_else(|e| panic!("{}", e.render()));
    let floor = format!("{SOLID}{}", soft("high", 0.3, 0.7));
    start(&floor).unwrap_or_else(|e| panic!("{}", e.render()));
}
