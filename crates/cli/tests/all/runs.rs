//! Runs end, stop, fail, go on, and are the same bits however they were cut.

use crate::common::{Place, assert_same, frames, series, signal, text, wait_for, wait_for_frames, words};
use meniscus_numerics::mesh::ply::PlyMesh;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

/// A run of some hundred steps.
const FINE: &str = "--until 6ms --set numerics.max_step=20us";

fn summary(run: &Path) -> serde_json::Value {
    serde_json::from_str(&std::fs::read_to_string(run.join("summary.json")).unwrap()).unwrap()
}

fn newest_checkpoint(run: &Path) -> std::path::PathBuf {
    let files = std::fs::read_dir(run.join("checkpoints")).unwrap().map(|e| e.unwrap().path());
    files.max().unwrap()
}

fn damage(path: &Path) {
    let mut bytes = std::fs::read(path).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(path, bytes).unwrap();
}

#[test]
fn a_run_ends_with_everything_in_its_place() {
    let place = Place::new("whole");
    let said = place.expect("run small.toml --until 1ms --out a --log json", 0);
    for line in said.lines() {
        let event: serde_json::Value = serde_json::from_str(line).unwrap();
        assert!(event["event"].is_string());
    }
    let a = place.path("a");
    assert_eq!(frames(&a).len(), 5);
    let s = summary(&a);
    assert_eq!(s["exit_reason"], "finished");
    assert_eq!(s["frames"], 5);
    assert!((s["simulated_seconds"].as_f64().unwrap() - 1e-3).abs() < 1e-15);
    let rows = series(&a);
    assert!(rows[0].starts_with("step,time,dt,cfl,liquid_volume,kinetic_energy"));
    assert!(!rows[1..].iter().any(|row| row.contains("NaN") || row.contains("inf")));

    // scene.toml gives the same run again
    place.expect("run a/scene.toml --out b --quiet", 0);
    assert_same(&a, &place.path("b"));
    let said = place.run("run a --resume");
    assert_eq!(said.status.code(), Some(0));
    assert!(text(&said.stdout).contains("already finished"));

    // never overwritten without --force
    let refusal = words(&place.expect("run small.toml --until 1ms --out a", 4));
    assert!(refusal.contains("already holds a run") && refusal.contains("--force"), "{refusal}");
    place.expect("run small.toml --until 1ms --out a --force --quiet", 0);
    assert_same(&a, &place.path("b"));
    // a longer run goes on from a finished one
    place.expect("run small.toml --until 1.2ms --out a --resume --quiet", 0);
    place.expect("run small.toml --until 1.2ms --out c --quiet", 0);
    assert_eq!(frames(&a).len(), 5);
    assert_eq!(frames(&place.path("c")).len(), 5);
}

#[test]
fn frames_of_a_range() {
    let place = Place::new("range");
    place.expect("run small.toml --frames 2:3 --out a --quiet", 0);
    let names: Vec<String> = frames(&place.path("a")).into_iter().map(|f| f.0).collect();
    assert_eq!(names, ["liquid_0002.ply", "liquid_0003.ply"]);
}

#[test]
fn the_number_of_threads_does_not_change_a_bit() {
    let place = Place::new("threads");
    place.expect("run small.toml --until 2ms --threads 1 --out a --quiet", 0);
    place.expect("run small.toml --until 2ms --threads 2 --out b --quiet", 0);
    place.expect("run small.toml --until 2ms --threads 5 --out c --quiet", 0);
    assert_same(&place.path("a"), &place.path("b"));
    assert_same(&place.path("a"), &place.path("c"));
}

#[test]
fn killed_at_any_moment_it_goes_on_with_the_same_bits() {
    let place = Place::new("kill");
    place.expect(&format!("run small.toml {FINE} --out whole --quiet"), 0);
    let broken = place.path("broken");
    let mut random = 12345u64;
    for kill in 0..10 {
        random = random.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        let mut child = place.start(&format!("run small.toml {FINE} --out broken --resume --quiet"));
        std::thread::sleep(Duration::from_millis(30 + (random >> 40) % 300));
        child.kill().unwrap();
        if child.wait().unwrap().code() == Some(0) && kill < 5 {
            // a fast machine was done before the kill: again from the start
            std::fs::remove_dir_all(&broken).unwrap();
        }
    }
    place.expect(&format!("run small.toml {FINE} --out broken --resume --quiet"), 0);
    assert_same(&place.path("whole"), &broken);
    assert_eq!(summary(&place.path("whole"))["steps"], summary(&broken)["steps"]);
    assert_eq!(summary(&place.path("whole"))["volume_error"], summary(&broken)["volume_error"]);
}

#[test]
fn signals_stop_it_with_a_checkpoint() {
    let place = Place::new("signals");
    place.expect("run small.toml --until 6ms --out whole --quiet", 0);
    for name in ["INT", "TERM"] {
        let child = place.start(&format!("run small.toml --until 100s --out {name}"));
        wait_for_frames(&place.path(name), 3);
        signal(&child, name);
        let output = child.wait_with_output().unwrap();
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(75), "{said}");
        let again = said.lines().find(|line| line.contains("--resume")).expect(&said).trim();
        assert!(again.starts_with("meniscus run small.toml --until 100s"), "{again}");
        assert_eq!(summary(&place.path(name))["exit_reason"], "stopped: signal");
        if summary(&place.path(name))["simulated_seconds"].as_f64().unwrap() < 5.9e-3 {
            place.expect(&format!("run small.toml --until 6ms --out {name} --resume --quiet"), 0);
            assert_same(&place.path("whole"), &place.path(name));
        }
    }
}

#[test]
fn the_wall_time_stops_it() {
    let place = Place::new("walltime");
    place.expect("run small.toml --until 100s --walltime 0.3s --out a --quiet", 75);
    assert_eq!(summary(&place.path("a"))["exit_reason"], "stopped: walltime");
}

#[test]
fn damaged_and_foreign_checkpoints() {
    let place = Place::new("damage");
    place.expect("run small.toml --until 3ms --out whole --quiet", 0);
    place.expect("run small.toml --until 2.1ms --out a --quiet", 0);
    let a = place.path("a");

    let refusal = words(&place.expect("run small.toml --set liquid.density=2g/cm^3 --out a --resume", 4));
    assert!(refusal.contains("another scene") && refusal.contains("--force"), "{refusal}");
    let newest = newest_checkpoint(&a);
    let good = std::fs::read(&newest).unwrap();
    let mut other = good.clone();
    other[8] = 99;
    std::fs::write(&newest, other).unwrap();
    let refusal = words(&place.expect("run small.toml --until 3ms --out a --resume", 4));
    assert!(refusal.contains("another version"), "{refusal}");

    std::fs::write(&newest, good).unwrap();
    damage(&newest);
    let said = words(&place.expect("run small.toml --until 3ms --out a --resume", 0));
    assert!(said.contains("damaged") && said.contains("the previous checkpoint is tried"), "{said}");
    assert_same(&place.path("whole"), &a);

    for entry in std::fs::read_dir(a.join("checkpoints")).unwrap() {
        damage(&entry.unwrap().path());
    }
    let refusal = words(&place.expect("run small.toml --until 4ms --out a --resume", 4));
    assert!(refusal.contains("damaged") && refusal.contains("--force"), "{refusal}");
    assert_eq!(frames(&a).len(), 11, "nothing is lost by a refusal");
}

#[test]
fn a_full_disk_keeps_the_last_good_state() {
    let place = Place::new("full");
    place.expect(&format!("run small.toml {FINE} --out whole --quiet"), 0);
    let binary = env!("CARGO_BIN_EXE_meniscus");
    // blocks of 512 bytes: the time series grows beyond them
    let line = format!("ulimit -f 48; exec '{binary}' run small.toml {FINE} --out a");
    let output =
        Command::new("sh").args(["-c", &line]).current_dir(&place.0).env("NO_COLOR", "1").output().unwrap();
    let said = words(&text(&output.stderr));
    assert_eq!(output.status.code(), Some(4), "{said}");
    assert!(said.contains("cannot write `a/") && said.contains("--resume"), "{said}");
    place.expect(&format!("run small.toml {FINE} --out a --resume --quiet"), 0);
    assert_same(&place.path("whole"), &place.path("a"));
}

#[test]
fn two_runs_cannot_share_a_folder() {
    let place = Place::new("busy");
    let child = place.start("run small.toml --until 100s --out a --quiet");
    wait_for_frames(&place.path("a"), 2);
    for flag in ["--resume", "--force"] {
        let refusal = words(&place.expect(&format!("run small.toml --until 100s --out a {flag}"), 4));
        assert!(refusal.contains("another run is writing"), "{refusal}");
    }
    signal(&child, "TERM");
    assert_eq!(child.wait_with_output().unwrap().status.code(), Some(75));

    // Of two that begin at the same time one runs and one is refused.
    for flag in ["--resume", "--force"] {
        let line = format!("run small.toml --until 100s --out b {flag} --quiet");
        let mut both = [0, 1].map(|_| place.start(&line));
        let mut ended = None;
        wait_for(|| {
            ended = both.iter_mut().position(|run| run.try_wait().unwrap().is_some());
            ended.is_some()
        });
        both.rotate_left(ended.unwrap());
        let [refused, other] = both;
        let output = refused.wait_with_output().unwrap();
        let said = words(&text(&output.stderr));
        assert!(output.status.code() == Some(4) && said.contains("another run is writing"), "{said}");
        wait_for_frames(&place.path("b"), 2);
        signal(&other, "TERM");
        assert_eq!(other.wait_with_output().unwrap().status.code(), Some(75));
    }
}

#[test]
fn the_contact_line_is_written_and_its_angle_expected() {
    let place = Place::new("line");
    place.expect("run plate.toml --out whole --quiet", 0);
    let whole = place.path("whole");
    let names: Vec<String> = frames(&whole).into_iter().map(|f| f.0).collect();
    assert!(names.contains(&"contact_line_0005.ply".to_string()), "{names:?}");
    let line = PlyMesh::load(&whole.join("frames/contact_line_0005.ply")).unwrap();
    assert_eq!(line.positions.len(), 2);
    for name in ["angle", "speed", "fx", "fy", "fz", "solid"] {
        assert_eq!(line.scalars[name].len(), 2, "{name}");
    }
    let plate = PlyMesh::load(&whole.join("frames/solid_plate_0005.ply")).unwrap();
    assert!(
        plate.scalars["phi_c"].iter().any(|d| *d < 0.0) && plate.scalars["phi_c"].iter().any(|d| *d > 0.0)
    );
    let rows = series(&whole);
    let names: Vec<&str> = rows[0].split(',').collect();
    let last: Vec<&str> = rows[rows.len() - 1].split(',').collect();
    let cell = |name: &str| last[names.iter().position(|n| *n == name).unwrap()];
    assert_eq!((cell("contact_points"), cell("contact_length")), ("2", ""));
    let angle: f64 = cell("contact_angle_mean").parse().unwrap();
    assert!((angle - line.scalars["angle"].iter().sum::<f64>() / 2.0).abs() < 1e-9);
    assert!(cell("line_distance").parse::<f64>().unwrap() < 1.0);
    let told = &summary(&whole)["expect"][0];
    assert!((told["value"].as_f64().unwrap() - angle).abs() < 1e-9 && told["pass"] == true, "{told}");

    // In two parts it is the same, to the last bit.
    place.expect("run plate.toml --until 0.6ms --out parts --quiet", 0);
    place.expect("run plate.toml --out parts --resume --quiet", 0);
    assert_same(&whole, &place.path("parts"));

    let strict = crate::common::PLATE.replace("\"80 deg\"", "\"0.001 deg\"");
    std::fs::write(place.path("plate.toml"), strict).unwrap();
    let missed = place.run("run plate.toml --out missed");
    let said = words(&(text(&missed.stdout) + &text(&missed.stderr)));
    assert!(missed.status.code() == Some(6) && said.contains("contact angle on plate"), "{said}");
}

#[test]
fn meshes_that_are_built_in_are_found_from_anywhere() {
    let place = Place::new("mesh");
    let duck = "[[solid]]\nname = \"duck\"\nmaterial.rigid = { fixed = true }\n\
                shape.mesh = { file = \"builtin:duck.obj\", scale = \"0.3 mm\", translate = [\"1.5 mm\", \"1.5 mm\", \"0.5 mm\"] }\n";
    let scene = crate::common::SCENE
        .replace("dimension = 2\nsize = [\"3 mm\", ", "dimension = 3\nsize = [\"3 mm\", \"3 mm\", ")
        .replace(
            "center = [\"1.5 mm\", \"1.5 mm\"], radius = \"0.9 mm\"",
            "center = [\"1.5 mm\", \"1.5 mm\", \"2.2 mm\"], radius = \"0.6 mm\"",
        );
    std::fs::write(place.path("duck.toml"), scene + duck).unwrap();
    place.expect("run duck.toml --until 0.6ms --out a --quiet", 0);
    place.expect("run duck.toml --until 0.3ms --out b --quiet", 0);
    std::fs::rename(place.path("b"), place.path("c")).unwrap();
    place.expect("run c --until 0.6ms --resume --quiet", 0);
    assert_same(&place.path("a"), &place.path("c"));
    place.expect("new drop-on-leaf -o mine.toml", 0);
    place.expect("check mine.toml --quality draft", 0);
}

/// Cases that run at the same time give the same results in the same order; earlier results are kept.
#[test]
fn cases_of_the_suite_run_at_the_same_time() {
    let place = Place::new("jobs");
    let outcomes = |line: &str| {
        let said = place.expect(line, 0);
        let text = std::fs::read_to_string(place.path("all.json")).unwrap();
        let results: serde_json::Value = serde_json::from_str(&text).unwrap();
        let cases = results["cases"].as_array().unwrap().clone();
        (said, cases.into_iter().map(|c| (c["name"].clone(), c["checks"].clone())).collect::<Vec<_>>())
    };
    let (_, one) = outcomes("verify mesh-distance --json all.json");
    let (said, both) = outcomes("verify contour-length mesh-distance --json all.json --resume --jobs 2");
    assert!(said.contains("(earlier)"), "{said}");
    assert_eq!(both[1..], one);
    let (_, again) = outcomes("verify contour-length mesh-distance --json all.json");
    assert_eq!(both, again);
}
