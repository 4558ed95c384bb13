//! `meniscus verify`.

use super::{print, save, version, with_threads};
use crate::args::VerifyArgs;
use crate::failure::{Failure, MISSED, Result, USAGE};
use meniscus_validation::{Case, Mode, Outcome, cases, groups, report};
use std::fmt::Write as _;
use std::path::PathBuf;

/// Runs the validation suite or some of its cases.
pub fn verify(args: &VerifyArgs) -> Result {
    let chosen = choose(args)?;
    if args.list {
        let mut out = String::new();
        for case in &chosen {
            let quick = if case.quick { "quick" } else { "" };
            let _ = writeln!(out, "{:24} {quick:6} {}", case.name, case.title);
        }
        print(&out)?;
        return Ok(0);
    }
    let mode = if args.quick { Mode::Quick } else { Mode::Full };
    let earlier = if args.resume { earlier_outcomes(args, mode)? } else { Vec::new() };
    let outcomes = with_threads(None, || outcomes(args, &chosen, mode, earlier))?;
    print(&report::summary(&outcomes))?;
    let passed = outcomes.iter().all(|o| o.checks.iter().all(|c| c.pass));
    Ok(if passed { 0 } else { MISSED })
}

/// Runs cases one after another on the current thread pool, prints their checks, and saves the results after each. Cases with an
/// `earlier` outcome are not run; earlier outcomes of other cases are saved with the rest.
fn outcomes(
    args: &VerifyArgs,
    chosen: &[&Case],
    mode: Mode,
    mut earlier: Vec<Outcome>,
) -> Result<Vec<Outcome>> {
    let mut all = Vec::new();
    for (i, case) in chosen.iter().enumerate() {
        let known = earlier.iter().position(|o| o.name == case.name).map(|k| earlier.swap_remove(k));
        let when = if known.is_some() { " (earlier)" } else { "" };
        eprintln!("[{}/{}] {}{when}", i + 1, chosen.len(), case.title);
        let is_new = known.is_none();
        let outcome = known.unwrap_or_else(|| case.outcome(mode));
        print(&report::text(&outcome))?;
        all.push(outcome);
        if is_new || i + 1 == chosen.len() {
            save_results(args, &[all.as_slice(), &earlier].concat(), mode)?;
        }
    }
    Ok(all)
}

/// Saves the results in the files that the arguments name.
fn save_results(args: &VerifyArgs, outcomes: &[Outcome], mode: Mode) -> Result<()> {
    let save = |path: &Option<PathBuf>, text: &dyn Fn() -> String| match path {
        Some(path) => save(path, &text()),
        None => Ok(()),
    };
    save(&args.json, &|| format!("{:#}\n", report::json(outcomes, mode, &version())))?;
    save(&args.html, &|| report::html(outcomes, &version()))?;
    save(&args.markdown, &|| report::markdown(outcomes, groups(), mode, &version()))
}

/// The outcomes in the file of `--json`; none where there is no such file.
fn earlier_outcomes(args: &VerifyArgs, mode: Mode) -> Result<Vec<Outcome>> {
    let Some(path) = args.json.as_ref().filter(|path| path.exists()) else { return Ok(Vec::new()) };
    let text = std::fs::read_to_string(path).map_err(Failure::file("read", path))?;
    report::outcomes_of_json(&text, mode, &version()).map_err(|reason| {
        Failure::new(USAGE, format!("cannot resume from {}: {reason}", path.display()))
            .help("give another file to --json, or leave out --resume")
    })
}

fn choose(args: &VerifyArgs) -> Result<Vec<&'static Case>> {
    if args.names.is_empty() {
        return Ok(cases().iter().filter(|case| case.quick || !args.quick).collect());
    }
    let find = |name: &String| {
        cases().iter().find(|case| case.name == name).ok_or_else(|| {
            Failure::new(USAGE, format!("there is no validation case `{name}`"))
                .help("`meniscus verify --list` shows them all")
        })
    };
    args.names.iter().map(find).collect()
}
