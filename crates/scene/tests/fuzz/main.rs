//! Readers of files get damaged input: scenes, meshes, images, checkpoints, and what a run writes.
//!
//! Each input is one of a small corpus, changed in one to four places by a generator with a fixed seed. A reader may refuse it; it may
//! not panic, take longer than [`MOST_SECONDS`], or hold more than [`MOST_BYTES`] of memory. Run alone, each reader gets [`INPUTS`] inputs;
//! `MENISCUS_FUZZ=3600 cargo test --release -p meniscus-scene --test fuzz -- --nocapture` gives each an hour. An input that fails is
//! kept in the folder for temporary files. Limit: nothing guides the changes towards new branches of a reader, and those of a checkpoint
//! rarely get past its checksum.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod corpus;
mod memory;
mod mutate;

use corpus::Input;
use meniscus_numerics::mesh::ply::PlyMesh;
use meniscus_numerics::mesh::volume::read;
use meniscus_numerics::shape::MeshShape;
use meniscus_scene::build::AnySetup;
use meniscus_scene::file::{LoadOptions, Scene};
use meniscus_scene::output::summary::Summary;
use meniscus_scene::output::time_series::TimeSeries;
use meniscus_scene::run::checkpoint;
use mutate::Mutator;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Inputs of each reader, unless a time is given.
const INPUTS: u64 = 1500;
/// Longest time for one input, s; the machine may be busy with other work.
const MOST_SECONDS: f64 = 10.0;
/// Most memory that the inputs may add to the address space of the process, bytes. Small inputs are to take little; the threads of the
/// tests and of the solver reserve some, too.
const MOST_BYTES: usize = 3 << 30;

/// Feeds damaged inputs to a reader.
fn fuzz(name: &str, inputs: &[Input], read: &dyn Fn(&Input)) {
    inputs.iter().for_each(read);
    let before = memory::largest();
    let seconds = std::env::var("MENISCUS_FUZZ").ok().and_then(|text| text.parse::<f64>().ok());
    let start = Instant::now();
    let mut mutator = Mutator::new(name);
    let mut count = 0u64;
    let goes_on = |count: u64| match seconds {
        Some(seconds) => start.elapsed() < Duration::from_secs_f64(seconds),
        None => count < INPUTS,
    };
    while goes_on(count) {
        let input = mutator.change(inputs);
        let began = Instant::now();
        let done = catch_unwind(AssertUnwindSafe(|| read(&input)));
        let (taken, bytes) = (began.elapsed().as_secs_f64(), memory::largest() - before);
        if done.is_err() || taken > MOST_SECONDS || bytes > MOST_BYTES {
            let path = std::env::temp_dir().join(format!("meniscus-fuzz-{name}-{count}.{}", input.ending));
            std::fs::write(&path, &input.bytes).unwrap();
            let panicked = if done.is_err() { "panicked, " } else { "" };
            panic!("{name}: input {count} {panicked}took {taken:.1} s and {bytes} bytes: {}", path.display());
        }
        count += 1;
    }
    println!("{name}: {count} inputs in {:.0} s", start.elapsed().as_secs_f64());
}

/// A closed surface or a mesh of elements, in the number of dimensions of its ending.
fn read_mesh(input: &Input) {
    let file = |path: &Path| match (path.extension().and_then(|e| e.to_str()), input.companion) {
        (Some(ending), Some((other, text))) if ending == other => Ok(Arc::from(text.as_bytes())),
        _ => Ok(Arc::from(&input.bytes[..])),
    };
    let path = Path::new("mesh").with_extension(input.ending);
    match input.ending {
        "obj" | "stl" | "ply" => {
            let _ = MeshShape::<3>::load(&path, &file).map(|shape| shape.surface().facets.len());
            let _ = MeshShape::<2>::load(&path, &file).map(|shape| shape.surface().facets.len());
        }
        _ => {
            let _ = read::load::<3>(&path, &file).map(|mesh| mesh.quality());
            let _ = read::load::<2>(&path, &file).map(|mesh| mesh.quality());
        }
    }
}

/// Writes an input where a reader finds it.
fn with_file(name: &str, input: &Input, read: impl FnOnce(&Path)) {
    let path =
        std::env::temp_dir().join(format!("meniscus-fuzz-{name}-{}.{}", std::process::id(), input.ending));
    std::fs::write(&path, &input.bytes).unwrap();
    read(&path);
    std::fs::remove_file(&path).unwrap();
}

#[test]
fn surfaces() {
    fuzz("surfaces", &corpus::surfaces(), &read_mesh);
}

#[test]
fn volumes() {
    fuzz("volumes", &corpus::volumes(), &read_mesh);
}

#[test]
fn frames() {
    fuzz("frames", &corpus::frames(), &|input| drop(PlyMesh::from_bytes(&input.bytes)));
}

#[test]
fn scenes() {
    fuzz("scenes", &corpus::scenes(), &|input| {
        let text = String::from_utf8_lossy(&input.bytes);
        let scene = Scene::from_text("fuzz.toml", &text, Path::new("."), &LoadOptions::default());
        drop(scene.map(|scene| scene.to_toml()));
    });
}

#[test]
fn images() {
    let scene = corpus::painted_scene();
    fuzz("images", &corpus::images(), &|input| {
        with_file("images", input, |path| {
            let text = scene.replace("IMAGE", &path.display().to_string());
            let scene = Scene::from_text("painted.toml", &text, Path::new("/"), &LoadOptions::default());
            drop(scene.and_then(|scene| AnySetup::of(&scene)));
        });
    });
}

#[test]
fn checkpoints() {
    let (inputs, identity, grid) = corpus::checkpoints();
    fuzz("checkpoints", &inputs, &|input| {
        with_file("checkpoints", input, |path| drop(checkpoint::read::<2>(path, identity, grid)));
    });
}

#[test]
fn tables() {
    fuzz("tables", &corpus::tables(), &|input| {
        with_file("tables", input, |path| match input.ending {
            "csv" => drop(TimeSeries::read(path)),
            _ => drop(Summary::read(path)),
        });
    });
}
