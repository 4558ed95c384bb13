//! Every bad input has a clear message and the right exit status.

use crate::common::{Place, text, words};

fn refused(place: &Place, line: &str, status: i32, parts: &[&str]) {
    let message = words(&place.expect(line, status));
    for part in parts {
        assert!(message.contains(part), "`{line}` should say `{part}`, but says:\n{message}");
    }
}

/// The scene with one piece of text replaced.
fn change(place: &Place, from: &str, to: &str) {
    assert!(crate::common::SCENE.contains(from));
    std::fs::write(place.path("changed.toml"), crate::common::SCENE.replace(from, to)).unwrap();
}

#[test]
fn scenes_that_are_wrong_are_refused_with_the_place() {
    let place = Place::new("scene");
    let cases = [
        ("resolution = 32", "resolutoin = 32", "unknown key `resolutoin`", "did you mean `resolution`?"),
        ("\"72.8 mN/m\"", "\"72.8 mm\"", "72.8 mm", "mN/m"),
        ("\"0.01 cm^2/s\"", "0.01", "no unit", "m^2/s"),
        ("\"0.9 mm\"", "\"0 mm\"", "above zero", "radius"),
        ("\"0.9 mm\"", "\"-1 mm\"", "above zero", "radius"),
        ("[\"3 mm\", \"3 mm\"]", "[\"3 mm\", \"-3 mm\"]", "above zero", "domain"),
        ("[\"1.5 mm\", \"1.5 mm\"], radius", "[\"9 mm\", \"1.5 mm\"], radius", "outside the domain", "3"),
        ("duration = \"20 ms\"", "duration = \"0 s\"", "duration", "zero"),
        ("format = 1", "format = 7", "format 7", "format = 1"),
        ("[tension]", "[tension", "", "changed.toml"),
    ];
    for (from, to, message, help) in cases {
        change(&place, from, to);
        refused(&place, "run changed.toml", 3, &[message, help, "changed.toml"]);
        refused(&place, "check changed.toml", 3, &[message, help]);
        assert!(!place.path("out").exists(), "nothing is written for a wrong scene");
    }
}

#[test]
fn missing_files_are_named() {
    let place = Place::new("missing");
    refused(&place, "run nowhere.toml", 4, &["nowhere.toml"]);
    refused(&place, "run oscilating-drop", 4, &["did you mean `oscillating-drop`?"]);
    refused(&place, "render nowhere", 4, &["nowhere"]);
    refused(&place, "page nowhere", 4, &["nowhere"]);
    refused(&place, "measure nowhere", 4, &["nowhere", "output folder"]);
    let text = crate::common::SCENE
        .replace("dimension = 2", "dimension = 3")
        .replace("size = [\"3 mm\", \"3 mm\"]", "size = [\"3 mm\", \"3 mm\", \"3 mm\"]");
    let (before, rest) = text.split_once("shape.perturbed_ball").unwrap();
    let (_, after) = rest.split_once('\n').unwrap();
    let text = format!("{before}shape.mesh = {{ file = \"no-such-mesh.stl\" }}\n{after}");
    std::fs::write(place.path("mesh.toml"), text).unwrap();
    let output = place.run("run mesh.toml");
    let message = words(&crate::common::text(&output.stderr));
    assert!(message.contains("no-such-mesh.stl"), "{message}");
    assert!(matches!(output.status.code(), Some(3 | 4)), "{message}");
}

#[test]
fn what_cannot_run_is_refused_before_the_first_step() {
    let place = Place::new("cannot");
    let solid = "[[solid]]\nname = \"plate\"\ndensity = \"2.5 g/cm^3\"\n\
                 shape.box = { lower = [0, 0], upper = [\"3 mm\", \"0.2 mm\"] }\nmaterial.shell = { young_modulus = \"1 MPa\", poisson_ratio = 0.3, thickness = \"0.2 mm\" }\n";
    std::fs::write(place.path("solid.toml"), crate::common::SCENE.to_string() + solid).unwrap();
    refused(&place, "run solid.toml", 3, &["thin sheets", "solid.toml"]);
    refused(&place, "run small.toml --set domain.resolution=16000", 3, &["memory"]);
    refused(&place, "run small.toml --set numerics.scheme=printed", 3, &["printed", "paper"]);
    refused(&place, "run small.toml --quality paper", 3, &["paper"]);
    assert!(!place.path("out").exists());
}

#[test]
fn output_that_cannot_be_written_is_named() {
    let place = Place::new("output");
    std::fs::write(place.path("file"), "in the way").unwrap();
    refused(&place, "run small.toml --out file/run", 4, &["file/run", "--out"]);
    refused(&place, "run small.toml --out /dev/null/run", 4, &["/dev/null/run"]);
    refused(&place, "run small.toml --out file", 4, &["file"]);
    refused(&place, "new static-drop -o small.toml", 4, &["small.toml", "exists"]);
    refused(
        &place,
        "verify contour-length --markdown file/results.md",
        4,
        &["cannot write", "file/results.md"],
    );
    assert_eq!(std::fs::read_to_string(place.path("file")).unwrap(), "in the way");
}

#[test]
fn wrong_usage_is_status_2() {
    let place = Place::new("usage");
    for line in [
        "",
        "fly",
        "run",
        "run small.toml --frames 7:3",
        "run small.toml --walltime soon",
        "run small.toml --resume --force",
        "run small.toml --threads 0",
        "verify no-such-case",
        "verify contour-length --resume",
        "verify contour-length --jobs 0",
        "bench no-such-bench",
        "bench --markdown",
        "bench step --resume --json a.json",
        "bench precision --resume",
        "bench table1 step --markdown",
        "scenes --json --markdown",
        "new no-such-scene",
        "render small --size 3",
        "export out",
        "export out --to gltf",
        "export out --to vdb",
        "export out --to obj --scale 0",
        "export out --to obj --every 0",
        "export out --to obj --frames 7:3",
        "sweep small.toml",
    ] {
        place.expect(line, 2);
    }
    refused(&place, "sweep small.toml", 2, &["nothing is varied", "--vary"]);
    refused(&place, "export out --to vti", 2, &["--to", "output.formats", "ply, vtk, obj, glb, usd, csv"]);
    refused(&place, "measure out --at soon", 2, &["--at", "soon", "a time"]);
    refused(&place, "measure out --at 3", 2, &["no unit", "ms"]);
}

#[test]
fn commands_that_only_tell() {
    let place = Place::new("tell");
    for (line, part) in [
        ("--version", "meniscus 0"),
        ("--help", "Exit status"),
        ("scenes", "oscillating-drop"),
        ("scenes --markdown", "| 2D |"),
        ("info", "meniscus 0"),
        ("new --list", "oscillating-drop"),
        ("new static-drop", "[domain]"),
        ("completions bash", "_meniscus"),
        ("check small.toml", "small"),
        ("check oscillating-drop --quality draft", "oscillating-drop"),
    ] {
        let output = place.run(line);
        assert_eq!(output.status.code(), Some(0), "`{line}`: {}", text(&output.stderr));
        assert!(text(&output.stdout).contains(part), "`{line}`: {}", text(&output.stdout));
    }
    for line in ["schema", "scenes --json", "info --json", "check small.toml --json"] {
        let output = place.run(line);
        assert_eq!(output.status.code(), Some(0), "`{line}`: {}", text(&output.stderr));
        serde_json::from_slice::<serde_json::Value>(&output.stdout).expect(line);
    }
    place.expect("new oscillating-drop-2d -o mine.toml", 0);
    place.expect("check mine.toml --strict", 0);
    assert!(std::fs::read_to_string(place.path("mine.toml")).unwrap().contains("\nname = \"mine\"\n"));
    // Materials that do not exist are not offered.
    for line in ["--help", "completions bash", "completions zsh", "completions fish", "schema"] {
        let said = text(&place.run(line).stdout);
        let values = ["shell", "rod"];
        let value = values.iter().find(|word| said.contains(&format!("\"{word}\"")));
        assert_eq!(value, None, "`{line}`");
    }
}
