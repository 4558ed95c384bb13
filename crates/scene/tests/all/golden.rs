//! A refactoring may not change results: this test compares the bits of the state after some steps of small scenes of every kind, with
//! one and two threads, from a checkpoint, and after a step that is undone.
//!
//! Mathematical libraries and the width of vectors differ between machines, and with them last bits. So `hashes.txt` holds the hash of
//! the machine's own arithmetic, too; where that differs, sums of the state are compared within [`NEAR`]. A change that is meant to
//! change results writes the file anew with `MENISCUS_GOLDEN=write`.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use crate::state_hash::{hash, sums};
use meniscus_scene::build::AnySetup;
use meniscus_scene::file::{LoadOptions, Scene, ensure_runnable};
use meniscus_scene::run::checkpoint;
use meniscus_scene::run::{RunStatistics, Setup};
use meniscus_sim::{Compiled, Simulation, SolidSurfaces, Solids, State};
use std::path::{Path, PathBuf};

/// Steps of a scene.
const STEPS: u64 = 20;
/// Relative difference of sums that different machines may have: ten times the residual (1e-6) at which the pressure's solve ends, which
/// other last bits may reach an iteration earlier.
const NEAR: f64 = 1e-5;

const SCENES: [&str; 15] = [
    "2d/collisions",
    "2d/free",
    "2d/hysteresis",
    "2d/liquid",
    "2d/neo-hookean",
    "2d/open-sides",
    "2d/pattern",
    "2d/prescribed",
    "2d/springs",
    "2d/wetting-walls",
    "3d/corotated",
    "3d/fixed",
    "3d/free",
    "3d/liquid",
    "3d/neumann",
];

/// Hash and sums of the state of a scene after its steps.
#[derive(Clone, Debug, PartialEq)]
struct Golden {
    hash: u64,
    sums: Vec<f64>,
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden")
}

/// Goes some steps on.
fn walk<const D: usize>(simulation: &mut Simulation<D>, steps: u64) {
    for _ in 0..steps {
        simulation.step(1e-2, &mut |_| {}).unwrap();
    }
}

fn with_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(work)
}

/// Runs a scene on one thread to its end; on the way it is written and read, run on with two threads, and a step is undone.
fn run<const D: usize>(name: &str, setup: &Setup<D>) -> Golden
where
    Simulation<D>: Compiled<D>,
{
    let mut whole = setup.simulation();
    with_threads(1, || walk(&mut whole, STEPS / 2));
    let mut resumed = there_and_back(name, &whole);
    with_threads(2, || walk(&mut resumed, STEPS - STEPS / 2));
    undo(name, &mut there_and_back(name, &whole));
    with_threads(1, || walk(&mut whole, STEPS - STEPS / 2));
    assert_eq!(
        hash(&whole.state),
        hash(&resumed.state),
        "{name}: two threads after a checkpoint give other bits"
    );
    let mut threaded = setup.simulation();
    with_threads(2, || walk(&mut threaded, STEPS));
    assert_eq!(hash(&whole.state), hash(&threaded.state), "{name}: two threads give other bits");
    Golden { hash: hash(&whole.state), sums: sums(&whole.state) }
}

/// The simulation after its checkpoint has been written and read.
fn there_and_back<const D: usize>(name: &str, simulation: &Simulation<D>) -> Simulation<D>
where
    Simulation<D>: Compiled<D>,
{
    let folder = std::env::temp_dir().join(format!(
        "meniscus-golden-{}-{}",
        name.replace('/', "-"),
        std::process::id()
    ));
    std::fs::create_dir_all(&folder).unwrap();
    let tally = RunStatistics::at_start(&simulation.model, &simulation.diagnostics());
    let path = checkpoint::write(&folder, 1, &simulation.state, &tally).unwrap();
    let (state, _) = checkpoint::read::<D>(&path, 1, simulation.model.grid).unwrap();
    std::fs::remove_dir_all(&folder).unwrap();
    assert_eq!(hash(&state), hash(&simulation.state), "{name}: a checkpoint changes the state");
    let resumed = Simulation::resume(simulation.model.clone(), state);
    assert_eq!(hash(&resumed.state), hash(&simulation.state), "{name}: resuming changes the state");
    resumed
}

/// A step that is undone leaves the state as it was, but for the guess of the pressure, which is none, and for the sign of φ where φ is
/// at its bound.
fn undo<const D: usize>(name: &str, simulation: &mut Simulation<D>) {
    let mut before = simulation.state.clone();
    simulation.step_and_undo(1e-4).unwrap();
    let after = &mut simulation.state;
    assert!(
        after.pressure_impulse.data.iter().all(|value| *value == 0.0),
        "{name}: a guess of the pressure is left"
    );
    before.pressure_impulse = after.pressure_impulse.clone();
    let bound = |values: &[f64]| values.iter().fold(0.0f64, |most, v| most.max(v.abs()));
    let bound = bound(&before.phi.data);
    let beyond = |state: &mut State<D>| {
        state.phi.data.iter_mut().filter(|v| v.abs() == bound).for_each(|v| *v = bound);
    };
    beyond(&mut before);
    beyond(after);
    assert_eq!(hash(&before), hash(after), "{name}: a step that is undone changes the state");
    let surfaces = &SolidSurfaces::new(&simulation.model.solids, &simulation.state.solids);
    let fresh = Solids { surfaces, ..simulation.solids() };
    for (kept, fresh) in simulation.solids().iter().zip(fresh.iter()) {
        let [kept, fresh] = [kept, fresh].map(|solid| &solid.surface.mesh.positions);
        assert_eq!(kept, fresh, "{name}: a step that is undone changes the surface of a solid");
    }
}

fn golden(name: &str) -> Golden {
    let path = folder().join(format!("{name}.toml"));
    let text = std::fs::read_to_string(&path).unwrap();
    let scene = Scene::from_text(&path.to_string_lossy(), &text, Path::new(""), &LoadOptions::default())
        .unwrap_or_else(|e| panic!("{}", e.render()));
    ensure_runnable(&scene).unwrap_or_else(|e| panic!("{}", e.render()));
    match AnySetup::of(&scene).unwrap() {
        AnySetup::D2(setup) => run(name, &setup),
        AnySetup::D3(setup) => run(name, &setup),
    }
}

/// The hash of this machine's arithmetic: of functions of the mathematical library, and of sums and solutions of linear algebra, whose
/// order depends on the width of vectors.
fn arithmetic() -> u64 {
    let mut values = Vec::new();
    for k in 1..200 {
        let x = 0.37 * f64::from(k);
        values.extend([
            x.sin(),
            x.cos(),
            x.exp(),
            x.ln(),
            x.powf(1.3),
            x.cbrt(),
            (1.0 / x).acos(),
            x.tanh(),
            x.sin().atan2(x),
        ]);
    }
    let matrix = product(&values);
    values.extend(matrix);
    crate::state_hash::of_values(&values)
}

/// Entries of a product of two matrices by the library that factors the solids' matrix.
fn product(values: &[f64]) -> Vec<f64> {
    let n = 24;
    let a = faer::Mat::from_fn(n, n, |r, c| values[r * n + c] + if r == c { 100.0 } else { 0.0 });
    let b = &a * a.transpose();
    (0..n * n).map(|k| b[(k / n, k % n)]).collect()
}

fn write(machine: u64, all: &[(&str, Golden)]) {
    let mut text = format!("arithmetic {machine:016x}\n");
    for (name, golden) in all {
        let sums: Vec<String> = golden.sums.iter().map(|v| format!("{v:e}")).collect();
        text += &format!("{name} {:016x} {}\n", golden.hash, sums.join(" "));
    }
    std::fs::write(folder().join("hashes.txt"), text).unwrap();
}

#[test]
fn states_after_twenty_steps_are_those_recorded() {
    let all: Vec<(&str, Golden)> = SCENES.iter().map(|name| (*name, golden(name))).collect();
    let machine = arithmetic();
    if std::env::var("MENISCUS_GOLDEN").is_ok_and(|value| value == "write") {
        return write(machine, &all);
    }
    let text = std::fs::read_to_string(folder().join("hashes.txt")).unwrap();
    let mut lines = text.lines();
    let same = lines.next() == Some(&format!("arithmetic {machine:016x}"));
    assert_eq!(lines.clone().count(), all.len(), "hashes.txt is of other scenes");
    for ((name, found), line) in all.iter().zip(lines) {
        let mut words = line.split(' ');
        assert_eq!(words.next(), Some(*name), "hashes.txt is of other scenes");
        let hash = words.next().unwrap();
        let sums: Vec<f64> = words.map(|w| w.parse().unwrap()).collect();
        if same {
            assert_eq!(
                hash,
                format!("{:016x}", found.hash),
                "{name}: the state has changed: {:?} for {sums:?}",
                found.sums
            );
        } else {
            let near = found.sums.iter().zip(&sums).all(|(a, b)| (a - b).abs() <= NEAR * (a.abs() + b.abs()));
            assert!(near, "{name}: {:?} for {sums:?}", found.sums);
        }
    }
}
