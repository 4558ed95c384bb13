//! Built-in scenes: valid, runnable, and the same after being written and read; and no text makes the reader panic.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use meniscus_scene::builtin::{self, BUILTINS};
use meniscus_scene::error::SceneError;
use meniscus_scene::estimate::check;
use meniscus_scene::expect;
use meniscus_scene::file::{LoadOptions, Quality, Scene, ensure_runnable};
use meniscus_scene::output::summary::Summary;
use meniscus_scene::output::time_series::TimeSeries;
use proptest::prelude::*;
use std::path::Path;

fn read(text: &str, sets: &[&str]) -> Result<Scene, SceneError> {
    let options =
        LoadOptions { sets: sets.iter().map(|s| (*s).to_owned()).collect(), ..LoadOptions::default() };
    Scene::from_text("x.toml", text, Path::new(""), &options)
}

fn same_again(scene: &Scene) {
    let text = scene.to_toml().unwrap();
    let again = read(&text, &[]).unwrap_or_else(|e| panic!("{}\n{text}", e.render()));
    assert_eq!(*scene, again, "{text}");
    assert_eq!(text, again.to_toml().unwrap());
}

/// In parts, which run at the same time.
const PARTS: usize = 4;

#[test]
fn builtins_of_part_0_are_sound() {
    builtins_are_sound(0);
}

#[test]
fn builtins_of_part_1_are_sound() {
    builtins_are_sound(1);
}

#[test]
fn builtins_of_part_2_are_sound() {
    builtins_are_sound(2);
}

#[test]
fn builtins_of_part_3_are_sound() {
    builtins_are_sound(3);
}

fn builtins_are_sound(part: usize) {
    for b in BUILTINS.iter().skip(part).step_by(PARTS) {
        for quality in [Quality::Draft, Quality::Normal, Quality::Paper] {
            let options = LoadOptions { quality, ..LoadOptions::default() };
            let scene = builtin::open(b.name, &options).unwrap_or_else(|e| panic!("{}", e.render()));
            assert_eq!((scene.name.as_str(), scene.domain.dimension as u32), (b.name, b.dimension));
            assert_eq!((scene.description.as_deref(), scene.cost.as_deref()), (Some(b.line), Some(b.cost)));
            let runs = ensure_runnable(&scene).and_then(|()| expect::ensure_columns(&scene));
            runs.unwrap_or_else(|e| panic!("{}", e.render()));
            // What the paper prints for it has no Young angle, and a capillary length of half a cell.
            let odd = b.name == "fig22-plate-0-paper-constants";
            assert!(odd || scene.warnings.0.is_empty(), "{}: {:?}", b.name, scene.warnings.0);
            same_again(&scene);
            // The scenes of Fig. 16 have the liquid and the sheet of fig15-origami-square, whose check takes its time.
            if quality == Quality::Normal && !b.name.starts_with("fig16-") {
                let report = check::check(&scene, 2);
                assert!(odd || report.warnings.is_empty(), "{}: {:?}", b.name, report.warnings);
                println!("{}", report.render());
                assert!(serde_json::to_string(&report).is_ok());
            }
        }
    }
}

/// TOML 1.0, which other readers and editors know, has inline tables on one line, without a comma at their end.
#[test]
fn builtins_are_toml_1_0() {
    for b in &BUILTINS {
        assert_eq!(not_toml_1_0(b.text), None, "{}", b.name);
    }
    assert_eq!(not_toml_1_0("a = {\n b = 1 }"), Some(1));
    assert_eq!(not_toml_1_0("x = 1\na = [{ b = 1, },\n]"), Some(2));
    assert_eq!(not_toml_1_0("a = [\n { b = \"{\" }, # {\n]\nc = '{'\n"), None);
}

/// The line, from 1, in which an inline table goes on to the next one or ends with a comma.
fn not_toml_1_0(text: &str) -> Option<usize> {
    for (number, line) in text.lines().enumerate() {
        let (mut open, mut quote, mut last) = (0, None, ' ');
        for c in line.chars() {
            match (quote, c) {
                (Some(q), c) if q == c && last != '\\' => quote = None,
                (Some(_), _) => {}
                (None, '"' | '\'') => quote = Some(c),
                (None, '#') => break,
                (None, '{') => open += 1,
                (None, '}') if last == ',' || open == 0 => return Some(number + 1),
                (None, '}') => open -= 1,
                _ => {}
            }
            if !c.is_whitespace() {
                last = c;
            }
        }
        if open > 0 {
            return Some(number + 1);
        }
    }
    None
}

#[test]
fn the_reference_of_the_grammar_is_up_to_date() {
    let made = meniscus_scene::schema::markdown();
    let kept = include_str!("../../../../docs/scene.md");
    assert!(made == kept, "docs/scene.md is stale: meniscus schema --markdown > docs/scene.md");
}

#[test]
fn periods_are_rayleighs() {
    let expected = |name: &str| {
        let scene = builtin::open(name, &LoadOptions::default()).unwrap();
        (scene.expect.period.unwrap().value, scene)
    };
    let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-4, "{a} {b}");
    let tau = 2.0 * std::f64::consts::PI;
    let (t, s) = expected("oscillating-drop");
    close(t, tau / (8.0 * s.tension.liquid_air / (s.liquid.density * 1e-9)).sqrt());
    let (t, s) = expected("oscillating-drop-2d");
    close(t, tau / (6.0 * s.tension.liquid_air / (s.liquid.density * 1e-9)).sqrt());
    let (t, s) = expected("capillary-wave-2d");
    let k = tau / 0.01;
    close(t, tau / (s.tension.liquid_air * k.powi(3) * (k * 6e-3).tanh() / s.liquid.density).sqrt());
}

#[test]
fn dimensionless_numbers() {
    let of = |name| check::check(&builtin::open(name, &LoadOptions::default()).unwrap(), 2);
    let r = of("colliding-drops-fast");
    let we = 1000.0 * 1.49_f64.powi(2) * 2e-3 / 0.0728;
    assert!((r.weber.unwrap() / we - 1.0).abs() < 1e-12, "{r:?}");
    let r = of("static-drop");
    assert!((r.laplace.unwrap() / 145_600.0 - 1.0).abs() < 1e-12);
    assert!((r.ohnesorge.unwrap() - 145_600_f64.powf(-0.5)).abs() < 1e-12);
    let ball = 4.0 / 3.0 * std::f64::consts::PI * 1e-9;
    assert!((r.liquid_volume.unwrap() / ball - 1.0).abs() < 2e-3);
    let r = of("dam-break-2d");
    assert!((r.liquid_volume.unwrap() / (0.05715 * 0.1143) - 1.0).abs() < 5e-3);
    assert!((r.capillary_length.unwrap() - 2.724e-3).abs() < 1e-5);
    assert_eq!(r.pairs[0].wetting, "partial");
}

/// Everything in the grammar.
const FULL: &str = r#"
format = 1
name = "full"
based_on = "paper, Fig. 22"
domain = { dimension = 3, size = ["10 cm", "9.97 cm", "10 cm"], dx = "0.3 mm", walls.top = "open", wall_contact_angle = "80 deg" }
[liquid]
density = "0.9 g/cm^3"
dynamic_viscosity = "3 cP"
gravity = [0, 0, "-9.81 m/s^2"]
[[liquid.body]]
velocity = [0, "3 cm/s", 0]
shape.union = [
  { box = { center = ["5 cm", "5 cm", "5 cm"], size = ["1 cm", "2 cm", "3 cm"], rotation = { axis = [1, 2, 3], angle = "33 deg" } } },
  { difference = { of.ellipsoid = { center = ["5 cm", "5 cm", "5 cm"], radii = ["1 cm", "7 dx", "3 cm"] }, minus.capsule = { a = [0, 0, 0], b = ["1 cm", 0, 0], radius = "1 mm" } } },
  { cylinder = { center = ["5 cm", "5 cm", "5 cm"], axis = [1, 1, 0.1], radius = "1 cm", height = "2 cm" } },
  { extrusion = { outline = [["1 mm", 0], [0, "2 mm"], ["-1 mm", 0]], thickness = "1 mm", center = ["5 cm", "5 cm", "5 cm"] } },
  { wave = { level = "1 cm", amplitude = "1 mm", wavelength = "3 cm", phase = "77 deg" } },
  { half_space = { point = [0, 0, "7 mm"], normal = [0.1, 0, 1] } },
  { smooth_union = { parts = [{ ball = { center = ["5 cm", "5 cm", "5 cm"], radius = "1 cm" } }, { cow = { at = ["5 cm", "5 cm", "5 cm"], length = "2 cm", rotation = { axis = [0, 0, 1], angle = "33 deg" } } }], width = "2 mm" } },
]
[[solid]]
name = "plate"
density = "2.5 g/cm^3"
shape.box = { lower = ["2 cm", "2 cm", "4 cm"], upper = ["8 cm", "8 cm", "4.3 cm"] }
mesh = { edge = "0.35 mm" }
material.springs = { stiffness = "5e4 mN/cm", damping_ratio = 0.05 }
fixed = [{ box = { lower = ["2 cm", "2 cm", "4 cm"], upper = ["3 cm", "8 cm", "4.3 cm"] } }]
moved = [
  { shape.ball = { center = ["8 cm", "5 cm", "4 cm"], radius = "1 cm" }, velocity = [0, 0, "1 cm/s"] },
  { shape.ball = { center = ["8 cm", "8 cm", "4 cm"], radius = "1 cm" }, keyframes = [{ time = "1 s", translate = [0, 0, 0] }, { time = "2 s", translate = [0, 0, "1 cm"] }] },
]
[[solid]]
name = "leaf"
density = "2 g/cm^3"
shape.extrusion = { outline = "leaf", size = "2 cm", thickness = "1 mm", center = ["5 cm", "5 cm", "5 cm"] }
material.shell = { young_modulus = "10 kPa", poisson_ratio = 0.3, thickness = "0.1 mm" }
[[solid]]
name = "stirrer"
shape.ball = { center = ["5 cm", "5 cm", "5 cm"], radius = "1 cm" }
collision = { restitution = 0.7, friction = 0.15 }
material.kinematic.keyframes = [{ time = 0, translate = [0, 0, 0] }, { time = "1 s", translate = [0, 0, "1 cm"] }]
[[solid]]
name = "thread"
density = "1 g/cm^3"
shape.capsule = { a = ["1 cm", "1 cm", "1 cm"], b = ["2 cm", "1 cm", "1 cm"], radius = "0.1 mm" }
material.rod = { young_modulus = "1 MPa", radius = "0.1 mm" }
[tension]
liquid_air = "1.0 mN/cm"
plate = { liquid_solid = "0.1 mN/cm", solid_air = "0.13 mN/cm", patches = [
  { shape.box = { lower = ["2 cm", "2 cm", "4 cm"], upper = ["3 cm", "8 cm", "4.3 cm"] }, contact_angle = "30 deg" },
  { shape.difference = { of.ball = { center = ["5 cm", "5 cm", "4 cm"], radius = "1 cm" }, minus.ball = { center = ["5 cm", "5 cm", "4 cm"], radius = "5 mm" } }, contact_angle = "2 rad" },
] }
leaf = { contact_angle = "120 deg" }
stirrer.gradient = { from = { point = ["4 cm", "5 cm", "5 cm"], contact_angle = "20 deg" }, to = { point = ["6 cm", "5 cm", "5 cm"], contact_angle = "110 deg" } }
[contact_line]
friction = { plate = "0.3 Pa s", leaf = 0 }
hysteresis = { above = "10 deg", below = "12 deg" }
[numerics]
scheme = "paper"
max_step = "6.67 ms"
fixed_step = "1 us"
threads = 2
[output]
duration = "1 s"
formats = ["vtk", "page"]
[expect]
volume_drift = { max = 0.005 }
momentum_error = { max = 1e-6 }
energy_growth = { max = 0.01 }
repairs = { deleted_volume = 1e-6, unconverged = 0 }
max_speed = { max = "1 cm/s" }
frequency = { mode = 2, solid = "plate", value = "121.3 Hz", tolerance = 0.02 }
contact_angle = [{ solid = "plate", value = "90 deg", tolerance = "5 deg" }, { solid = "leaf", value = "120 deg", tolerance = "5 deg" }]
reach = { side = "top", value = "30 dx", tolerance = "1 mm" }
floats = ["leaf"]
sinks = ["plate", "stirrer"]
drops = { max = 3 }
series = { column = "wetted_leaf", of = "largest", from = "1 ms", until = "2 ms", max = 0.5 }
"#;

#[test]
fn the_whole_grammar_comes_back() {
    let scene = read(FULL, &[]).unwrap_or_else(|e| panic!("{}", e.render()));
    same_again(&scene);
    assert_eq!(ensure_runnable(&scene).unwrap_err().exit_status(), 3);
    let report = check::check(&scene, 2);
    assert_eq!(report.pairs.len(), 5);
    assert!((report.pairs[1].young_cosine.unwrap() - 0.03).abs() < 1e-12, "{report:?}");
    let angles = report.pairs[1].young_angles.unwrap();
    assert!((angles[0] - 30.0).abs() < 1e-9 && (angles[1] - 2f64.to_degrees()).abs() < 1e-9, "{angles:?}");
    assert!(report.render().contains("20.00 to 110.00 deg, patterned"), "{}", report.render());
    assert!(report.cannot_run.is_some());
}

#[test]
fn every_expectation_has_a_name_at_its_place() {
    let scene = read(FULL, &[]).unwrap();
    let summary = serde_json::json!({
        "scene": "", "version": "", "exit_reason": "", "dimension": 3, "resolution": 1, "cells": [], "dx": 1.0, "domain": [],
        "threads": 1, "steps": 0, "frames": 0, "frame_interval": 1.0, "simulated_seconds": 0.0, "wall_seconds": 0.0,
        "volume_error": 0.0, "max_divergence": 0.0, "max_speed": 0.0, "lost_volume": 0.0, "redone": 0, "phases": {},
        "solves": {}, "peak_memory_bytes": 0, "drops": [], "solids": [],
    });
    let summary: Summary = serde_json::from_value(summary).unwrap();
    let (names, verdicts) =
        (expect::names(&scene.expect), expect::evaluate(&scene, &summary, &TimeSeries::default()));
    let told: Vec<&str> = verdicts.iter().map(|verdict| verdict.quantity.as_str()).collect();
    assert_eq!(names.len(), told.len(), "{names:?} {told:?}");
    for (name, quantity) in [
        ("volume_drift", "volume drift"),
        ("repairs.unconverged", "repairs: unconverged"),
        ("frequency", "frequency"),
        ("drops", "drops"),
        ("reach.top", "reach towards top"),
        ("contact_angle.leaf", "contact angle on leaf"),
        ("floats.leaf", "wetted share of leaf, which floats"),
        ("sinks.stirrer", "wetted share of stirrer, which sinks"),
        ("series.wetted_leaf", "wetted_leaf (largest value from 0.001 s until 0.002 s)"),
    ] {
        let place = names.iter().position(|n| n == name).unwrap_or_else(|| panic!("{name} in {names:?}"));
        assert_eq!(told[place], quantity);
    }
}

#[test]
fn schema_is_json() {
    let schema: serde_json::Value = serde_json::from_str(&meniscus_scene::schema::json_schema()).unwrap();
    let properties = &schema["properties"];
    for key in ["format", "name", "domain", "liquid", "solid", "tension", "numerics", "output", "expect"] {
        assert!(properties.get(key).is_some(), "{key}");
    }
}

/// Reads; checks that the error points into its text.
fn survive(text: &str) {
    match read(text, &[]) {
        Ok(scene) => {
            let _ = ensure_runnable(&scene).map_err(|e| inside(&e));
            same_again(&scene);
        }
        Err(e) => inside(&e),
    }
}

fn inside(e: &SceneError) {
    if let Some(span) = &e.span {
        assert!(e.source_text.get(span.clone()).is_some(), "{span:?} {e:?}");
        assert!(e.line_column().is_some());
    }
    assert!(!e.render().is_empty() && !e.message.is_empty());
}

fn texts() -> Vec<&'static str> {
    BUILTINS.iter().map(|b| b.text).chain([FULL]).collect()
}

const PIECES: [&str; 30] = [
    "0",
    "-1",
    "1e400",
    "\"0 m\"",
    "\"-3 mm\"",
    "\"1e300 m\"",
    "\"3 dx\"",
    "[]",
    "{}",
    "[[solid]]\n",
    "nan",
    "inf",
    "\"\"",
    "true",
    "\"µ\"",
    "999999999999",
    "9223372036854775808",
    "'",
    "\"",
    "=",
    ".",
    "\n",
    "[",
    "]",
    "{",
    "}",
    "#",
    "\u{1f}",
    "\"1 s\"",
    "1979-05-27",
];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn any_text_is_survived(text in ".{0,300}") {
        survive(&text);
    }

    #[test]
    fn any_setting_is_survived(which in 0..10_usize, set in "[a-z.0-9]{0,20}=.{0,20}") {
        if let Err(e) = read(texts()[which], &[&set]) {
            inside(&e);
        }
    }

    #[test]
    fn mutated_scenes_are_survived(
        which in 0..10_usize,
        edits in prop::collection::vec((any::<prop::sample::Index>(), 0..12_usize, 0..30_usize, 0..4_u8), 1..4),
    ) {
        let mut text: Vec<char> = texts()[which].chars().collect();
        for (at, length, piece, kind) in edits {
            let start = at.index(text.len().max(1)).min(text.len());
            let end = match kind { 0 => start, _ => (start + length).min(text.len()) };
            let new = if kind == 1 { "" } else { PIECES[piece] };
            text.splice(start..end, new.chars());
        }
        survive(&text.into_iter().collect::<String>());
    }

    #[test]
    fn swapped_values_are_survived(
        which in 0..10_usize, a in any::<prop::sample::Index>(), piece in 0..30_usize,
    ) {
        let mut lines: Vec<String> = texts()[which].lines().map(str::to_owned).collect();
        let keyed: Vec<usize> = (0..lines.len()).filter(|&i| lines[i].contains(" = ")).collect();
        let line = keyed[a.index(keyed.len())];
        let key = lines[line].split(" = ").next().unwrap_or("").to_owned();
        lines[line] = format!("{key} = {}", PIECES[piece]);
        survive(&lines.join("\n"));
    }
}
