//! Applies the defects of `defects.rs` one by one to a copy of the source, and looks whether the cases of `meniscus verify` notice:
//!
//! ```sh
//! cargo run --release -p meniscus-validation --example sabotage             # all defects: hours
//! cargo run --release -p meniscus-validation --example sabotage -- restitution half-friction
//! ```
//!
//! Each defect is compiled (minutes), and its cases run, quickly where they are in the quick suite. A case notices a defect if a check fails
//! that does not fail without it, as `docs/validation-full.json` tells. The copy is kept in the folder for temporary files, so that
//! the next call compiles less.
#![allow(clippy::expect_used, clippy::panic)]

mod defects;

use defects::DEFECTS;
use meniscus_validation::cases;
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

fn main() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let copy = std::env::temp_dir().join("meniscus-sabotage");
    copy_source(&root, &copy);
    let known = failures(&root.join("docs/validation-full.json"));
    let names: Vec<String> = std::env::args().skip(1).collect();
    let (mut caught, mut all) = (0, 0);
    for defect in DEFECTS.iter().filter(|d| names.is_empty() || names.iter().any(|n| n == d.name)) {
        println!("{}: {}", defect.name, defect.about);
        let text = std::fs::read_to_string(copy.join(defect.file)).expect("the file of the defect");
        assert_eq!(text.matches(defect.right).count(), 1, "{}: the line has changed", defect.name);
        write(&copy.join(defect.file), &text.replacen(defect.right, defect.wrong, 1));
        let program = compile(&copy);
        for case in defect.cases {
            let noticed = program.as_deref().is_some_and(|program| is_noticed(program, case, &known, &copy));
            println!("  {case}: {}", if noticed { "caught" } else { "NOT CAUGHT" });
            (caught, all) = (caught + usize::from(noticed), all + 1);
        }
        write(&copy.join(defect.file), &text);
    }
    println!("{caught} of {all} caught");
}

/// Brings the copy up to the tracked files of the workspace. Files that are the same keep their time, so that they are not compiled again.
fn copy_source(root: &Path, copy: &Path) {
    let listed = Command::new("git").arg("ls-files").current_dir(root).output().expect("git lists the files");
    for name in String::from_utf8_lossy(&listed.stdout).lines() {
        let (from, to) = (root.join(name), copy.join(name));
        let content = std::fs::read(&from).expect("a tracked file");
        if std::fs::read(&to).ok().as_ref() != Some(&content) {
            std::fs::create_dir_all(to.parent().expect("a folder")).expect("a folder for the copy");
            std::fs::write(&to, content).expect("the copy can be written");
        }
    }
}

fn write(path: &Path, text: &str) {
    std::fs::write(path, text).expect("the copy can be written");
}

/// The program of the copy; none if it does not compile.
fn compile(copy: &Path) -> Option<PathBuf> {
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["build", "--release", "--quiet", "-p", "meniscus-cli"]).current_dir(copy);
    cargo.env("CARGO_TARGET_DIR", copy.join("target")).env("CARGO_INCREMENTAL", "1");
    let compiled = cargo.status().is_ok_and(|status| status.success());
    compiled.then(|| copy.join("target/release/meniscus"))
}

/// Whether a check of a case fails that is not known to fail. A program that ends otherwise notices, too.
fn is_noticed(program: &Path, case: &str, known: &BTreeSet<[String; 2]>, copy: &Path) -> bool {
    let results = copy.join("sabotage.json");
    let _ = std::fs::remove_file(&results);
    let is_quick = cases().iter().any(|c| c.name == case && c.quick);
    let mut verify = Command::new(program);
    verify.args(["verify", case, "--json"]).arg(&results).args(is_quick.then_some("--quick"));
    let status = verify.output().expect("the program runs").status;
    !status.success() && (!results.exists() || !failures(&results).is_subset(known))
}

/// Case and quantity of the checks that fail in a file of results.
fn failures(path: &Path) -> BTreeSet<[String; 2]> {
    let text = std::fs::read_to_string(path).expect("the results of the suite");
    let all: Value = serde_json::from_str(&text).expect("results of the suite are JSON");
    let checks = all["cases"].as_array().into_iter().flatten().flat_map(|case| case["checks"].as_array());
    let failed = checks.flatten().filter(|check| check["pass"] == false);
    failed
        .map(|check| ["case", "quantity"].map(|key| check[key].as_str().unwrap_or_default().to_owned()))
        .collect()
}
