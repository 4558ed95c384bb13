//! Every write, sync and rename of a run fails once: the command says so, the last checkpoint is whole, and the run goes on to the same
//! bits. A library that is preloaded (`preload/interposer.rs`) makes them fail.

use crate::common::{PLATE, Place, assert_same, text};
use std::path::{Path, PathBuf};
use std::process::Command;

/// More calls than the run makes.
const MOST: usize = 1000;

/// Compiles the library; none where there is no `rustc`.
fn interposer(place: &Place) -> Option<PathBuf> {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/preload/interposer.rs");
    let library = place.path("interposer.so");
    let mut compiler = Command::new(std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()));
    compiler.args(["--edition", "2024", "-O", "--crate-type", "cdylib"]).arg(source).arg("-o").arg(&library);
    let output = compiler.output().ok()?;
    assert!(output.status.success(), "{}", text(&output.stderr));
    Some(library)
}

#[test]
fn every_write_fails_once() {
    let place = Place::new("failed-writes");
    let Some(library) = interposer(&place) else {
        println!("left out: there is no rustc");
        return;
    };
    let scene = PLATE.replace("resolution = 32", "resolution = 24").replace("1.5 ms", "0.6 ms");
    std::fs::write(place.path("short.toml"), scene.replace("[\"ply\"]", "[\"ply\", \"page\"]")).unwrap();
    place.expect("run short.toml --out whole", 0);
    let failures: usize = std::thread::scope(|scope| {
        let halves = [1, 2].map(|first| {
            let (place, library) = (&place, &library);
            scope
                .spawn(move || (first..=MOST).step_by(2).take_while(|n| fails_at(place, library, *n)).count())
        });
        halves.map(|half| half.join().unwrap()).iter().sum()
    });
    println!("{failures} writes, syncs and renames failed once each");
    assert!(
        (50..MOST).contains(&failures),
        "the run makes another number of calls than expected: {failures}"
    );
}

/// Lets the n-th call of a run fail, and resumes it. False if the run makes fewer calls.
fn fails_at(place: &Place, library: &Path, n: usize) -> bool {
    let (name, whole) = (format!("run-{}", n % 2), place.path("whole"));
    let (run, failed) = (place.path(&name), place.path(&format!("failed-{}", n % 2)));
    let _ = std::fs::remove_file(&failed);
    let _ = std::fs::remove_dir_all(&run);
    let mut command = place.command(&format!("run short.toml --out {name}"));
    command.env("LD_PRELOAD", library).env("FAIL_UNDER", &run).env("FAIL_AT", n.to_string());
    let output = command.env("FAILED", &failed).output().unwrap();
    let said = text(&output.stderr);
    let Ok(file) = std::fs::read_to_string(&failed) else {
        assert_eq!(output.status.code(), Some(0), "{said}");
        return false;
    };
    let told = format!("call {n}, of {file}: {said}");
    assert_eq!(output.status.code(), Some(4), "{told}");
    assert!(said.contains("cannot") || said.contains("error 5"), "{told}");
    place.expect(&format!("run short.toml --out {name} --resume"), 0);
    assert_same(&whole, &run);
    let parts = |folder: &str| std::fs::read_dir(run.join(folder)).unwrap().map(|e| e.unwrap().path());
    for path in ["", "frames", "checkpoints", "render", "page"].into_iter().flat_map(parts) {
        assert!(path.extension().is_none_or(|e| e != "part"), "{told}{} is left", path.display());
    }
    assert_eq!(verdicts(&run), verdicts(&whole), "{told}");
    for picture in ["render/frame_0000.png", "render/frame_0002.png"] {
        let bytes = |run: &Path| std::fs::read(run.join(picture)).unwrap();
        assert!(bytes(&run) == bytes(&whole), "{told}{picture}");
    }
    assert!(run.join("page/index.html").is_file(), "{told}");
    true
}

fn verdicts(run: &Path) -> serde_json::Value {
    let summary = std::fs::read_to_string(run.join("summary.json")).unwrap();
    serde_json::from_str::<serde_json::Value>(&summary).unwrap()["expect"].clone()
}
