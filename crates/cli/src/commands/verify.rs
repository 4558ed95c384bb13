//! `meniscus verify`.

use super::{print, save, version, with_threads};
use crate::args::VerifyArgs;
use crate::failure::{Failure, MISSED, Result, USAGE};
use meniscus_validation::{Case, Mode, Outcome, cases, report};
use std::fmt::Write as _;

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
    let outcomes = with_threads(None, || outcomes(&chosen, mode))?;
    print(&report::summary(&outcomes))?;
    if let Some(path) = &args.json {
        save(path, &format!("{:#}\n", report::json(&outcomes)))?;
    }
    if let Some(path) = &args.html {
        save(path, &report::html(&outcomes))?;
    }
    if let Some(path) = &args.markdown {
        save(path, &report::markdown(&outcomes, mode, &version()))?;
    }
    let passed = outcomes.iter().all(|o| o.checks.iter().all(|c| c.pass));
    Ok(if passed { 0 } else { MISSED })
}

/// Runs cases one after another on the current thread pool, and prints their checks.
fn outcomes(chosen: &[&Case], mode: Mode) -> Result<Vec<Outcome>> {
    let run = |(i, case): (usize, &&Case)| {
        eprintln!("[{}/{}] {}", i + 1, chosen.len(), case.title);
        let outcome = case.outcome(mode);
        print(&report::text(&outcome))?;
        Ok(outcome)
    };
    chosen.iter().enumerate().map(run).collect()
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
