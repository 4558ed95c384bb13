//! `meniscus soak`.

use super::{print, save};
use crate::args::{Set, SoakArgs, Solids};
use crate::failure::{Failure, MISSED, Result, USAGE};
use crate::own_program;
use meniscus_scene::file::{LoadOptions, Scene};
use meniscus_validation::soak::launcher::{CaseRange, Launcher, MESSAGE_PREFIXES, arguments};
use meniscus_validation::soak::rerun::shrink;
use meniscus_validation::soak::{self, CaseOptions, Class, Outcome, Subject, report, run};
use std::collections::BTreeMap;
use std::path::Path;
use std::time::{Duration, Instant};

/// Default number of cases.
const SCENES: u64 = 100;

/// Generates random scenes and checks them against the invariants.
pub fn soak(args: &SoakArgs) -> Result {
    let wish = case_options(args);
    if let Some(path) = args.scene.as_ref().filter(|path| !path.is_file()) {
        let message = format!("there is no file {}", path.display());
        return Err(Failure::new(USAGE, message)
            .help("--scene takes the file of a scene, such as one that a soak has written"));
    }
    if args.child {
        return child(args, wish);
    }
    let program = own_program::executable()?;
    let launch = Launcher { program, wish, out: args.out.clone() };
    match (&args.scene, args.case) {
        (Some(path), _) => one(args, &launch, launch.file(path).map_err(internal)?, Some(path)),
        (None, Some(case)) => one(args, &launch, launch.case(case).map_err(internal)?, None),
        (None, None) => many(args, &launch),
    }
}

fn case_options(args: &SoakArgs) -> CaseOptions {
    let class = match args.solids {
        Solids::None => Some(Class::Liquid),
        Solids::Rigid => Some(Class::Rigid),
        Solids::Soft => Some(Class::Soft),
        Solids::Any => None,
    };
    let set = match args.set {
        Set::Random => soak::CaseSet::Random,
        Set::DropTest => soak::CaseSet::DropTest,
    };
    CaseOptions { set, seed: args.seed, dimension: args.dimension.map(usize::from), class, quick: args.quick }
}

fn internal(words: String) -> Failure {
    Failure::new(1, words)
}

/// Runs a case in this process, and sends its outcome to the parent.
fn child(args: &SoakArgs, wish: CaseOptions) -> Result {
    let subject = match &args.scene {
        Some(path) => Subject::File(path.clone(), wish.set),
        None => Subject::Case(wish, args.case.unwrap_or(0)),
    };
    let mut tell = |text: &str| tell_parent(0, &serde_json::json!(text));
    let hung = |outcome: &Outcome| {
        tell_parent(1, &serde_json::json!(outcome));
        std::process::exit(0);
    };
    let outcome = run(&subject, &args.out, &mut tell, hung).map_err(internal)?;
    tell_parent(1, &serde_json::json!(outcome));
    Ok(0)
}

/// Sends a line to the parent. Errors are ignored: the parent has ended.
fn tell_parent(kind: usize, value: &serde_json::Value) {
    let _ = print(&format!("{}{value}\n", MESSAGE_PREFIXES[kind]));
}

/// Runs cases until their number or the time is reached, and prints the final table.
fn many(args: &SoakArgs, launch: &Launcher) -> Result {
    let known = known(args.known.as_deref())?;
    let hours = args.hours.map(|h| Duration::from_secs_f64(3600.0 * h.clamp(0.0, 1e4)));
    let extent = CaseRange {
        first: 0,
        scenes: args.scenes.or(if hours.is_none() { Some(SCENES) } else { None }),
        until: hours.map(|hours| Instant::now() + hours),
        jobs: args
            .jobs
            .map_or_else(|| std::thread::available_parallelism().map_or(1, usize::from), usize::from),
    };
    let mut done = 0;
    let outcomes = launch.run(&extent, &mut |outcome| {
        done += 1;
        eprint!("[{done}] {}", report::line(outcome));
    });
    print(&report::table(&outcomes))?;
    if let Some(path) = &args.json {
        save(path, &format!("{:#}\n", report::json(args.seed, &outcomes)))?;
    }
    if extent.scenes.is_some_and(|count| outcomes.len() < count as usize) && hours.is_none() {
        return Err(Failure::new(
            1,
            "some cases could not be run: no process of this program could be started for them",
        ));
    }
    let new: Vec<&Outcome> = outcomes.iter().filter(|o| !is_known(o, &known)).collect();
    for outcome in outcomes.iter().filter(|o| known.contains_key(&o.name)) {
        let word = if outcome.violations.is_empty() {
            "no longer violated: remove it from the list"
        } else {
            "known"
        };
        print(&format!("{}: {word}\n", outcome.name))?;
    }
    if new.is_empty() {
        return Ok(0);
    }
    let again = format!("meniscus soak {} --case", arguments(&launch.wish).join(" "));
    print(&format!(
        "scenes and checkpoints are in {}; to run a single case again: {again} {}\n",
        args.out.display(),
        new.first().map_or(0, |o| o.case)
    ))?;
    Ok(MISSED)
}

/// Whether all violations of a case are on the list.
fn is_known(outcome: &Outcome, known: &BTreeMap<String, Vec<String>>) -> bool {
    let listed = known.get(&outcome.name);
    outcome.violations.iter().all(|v| listed.is_some_and(|kinds| kinds.contains(&v.kind)))
}

/// Reads a list of known violations: per line the name of a case, then the invariants; `#` begins a comment.
fn known(path: Option<&Path>) -> Result<BTreeMap<String, Vec<String>>> {
    let Some(path) = path else { return Ok(BTreeMap::new()) };
    let text = std::fs::read_to_string(path).map_err(Failure::file("read", path))?;
    let lines = text.lines().map(|line| line.split('#').next().unwrap_or(""));
    let words = lines.map(|line| line.split_whitespace().map(str::to_owned).collect::<Vec<_>>());
    Ok(words.filter_map(|w| w.split_first().map(|(name, kinds)| (name.clone(), kinds.to_vec()))).collect())
}

/// Runs one case or scene, and shrinks it on request.
fn one(args: &SoakArgs, launch: &Launcher, outcome: Outcome, path: Option<&Path>) -> Result {
    print(&report::line(&outcome))?;
    let Some(first) = outcome.violations.first().cloned() else {
        print("no invariant is violated\n")?;
        return Ok(0);
    };
    let written = args.out.join(&outcome.name);
    let scene = path.map_or_else(|| append(&written, ".toml"), Path::to_path_buf);
    print(&format!(
        "to resume before the violation: meniscus run {} --out {} --resume\n",
        scene.display(),
        written.display()
    ))?;
    if args.shrink {
        let kind = args.kind.clone().unwrap_or(first.kind);
        if outcome.violations.iter().all(|v| v.kind != kind) {
            return Err(Failure::new(USAGE, format!("this scene does not violate the invariant `{kind}`")));
        }
        let loaded = Scene::load(&scene, &LoadOptions::default())?;
        let mut each = |words: &str| eprintln!("  {words}");
        let small = shrink::shrink(launch, loaded, outcome, &kind, &mut each).map_err(internal)?;
        print(&format!(
            "still violated without {}:\n{}",
            small.dropped.join(", "),
            report::line(&small.outcome)
        ))?;
        print(&format!("{}\n", small.path.display()))?;
    }
    Ok(MISSED)
}

/// A path with a suffix after its name, which may contain dots.
fn append(path: &Path, end: &str) -> std::path::PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(end);
    name.into()
}
