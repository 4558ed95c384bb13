//! `meniscus bench precision`: errors against cost with longer and longer steps.

use super::super::{print, save, show_progress, version};
use crate::args::BenchArgs;
use crate::failure::{Failure, Result, USAGE};
use meniscus_scene::output::markdown;
use meniscus_validation::bench::precision::{self, PROBLEMS, Problem, Run};
use serde::Deserialize;
use serde_json::{Value, json};
use std::fmt::Write as _;

/// Runs each problem and prints its rows; `--quick`: two of the bounds. `--markdown`: rows go to standard error as they come, and at the
/// end the tables go to standard output as a page of Markdown. `--resume`: earlier runs of the same version are not made again. `head` is
/// what the file of `--json` has beside these results; where they are wanted alone the file is written after each run.
pub fn precision(args: &BenchArgs, head: &Value) -> Result<Value> {
    let show = |text: &str| show_progress(text, args.markdown);
    let earlier = if args.resume { earlier_results(args, head)? } else { Value::Null };
    let (mut results, mut page) = (Vec::new(), heading());
    for problem in &PROBLEMS {
        let Problem { name, quantity, .. } = problem;
        show(&format!("{name}: {quantity}\n  capillary limits     cfl      value      error   seconds\n"))?;
        let of_problem = |runs: &[Run]| json!({ "name": name, "quantity": quantity, "runs": runs });
        let (mut made, mut shown) = (Vec::new(), Ok(()));
        let runs = precision::run(problem, args.quick, &runs_of(&earlier, name), |run| {
            made.push(*run);
            let all = [results.as_slice(), &[of_problem(&made)]].concat();
            let done = show(&row(run)).and_then(|()| save_results(args, head, all, &earlier));
            if shown.is_ok() {
                shown = done;
            }
        });
        shown?;
        let runs = runs.map_err(|e| Failure::new(5, format!("`{name}` failed: {e}")))?;
        page += &table(problem, &runs);
        results.push(of_problem(&runs));
    }
    if args.markdown {
        print(&page)?;
    }
    Ok(json!(results))
}

/// Writes the file of `--json` if it is to have these results alone: the new ones, and earlier ones of other problems.
fn save_results(args: &BenchArgs, head: &Value, mut results: Vec<Value>, earlier: &Value) -> Result<()> {
    let Some(path) = args.json.as_ref().filter(|_| args.names == ["precision"]) else { return Ok(()) };
    let is_new = |problem: &&Value| results.iter().any(|new| new["name"] == problem["name"]);
    let others: Vec<Value> =
        earlier.as_array().into_iter().flatten().filter(|problem| !is_new(problem)).cloned().collect();
    results.extend(others);
    let mut all = head.clone();
    all["precision"] = json!(results);
    save(path, &format!("{all:#}\n"))
}

/// The results in the file of `--json`; none where there is no such file.
fn earlier_results(args: &BenchArgs, head: &Value) -> Result<Value> {
    let Some(path) = args.json.as_ref().filter(|path| path.exists()) else { return Ok(Value::Null) };
    let text = std::fs::read_to_string(path).map_err(Failure::file("read", path))?;
    let all: Value = serde_json::from_str(&text).unwrap_or_default();
    if all["version"] != head["version"] || all["threads"] != head["threads"] {
        let reason = format!("{} has no results of this version and number of threads", path.display());
        return Err(Failure::new(USAGE, reason).help("give another file to --json, or leave out --resume"));
    }
    Ok(all["precision"].clone())
}

/// The runs of a problem in earlier results.
fn runs_of(earlier: &Value, name: &str) -> Vec<Run> {
    let problem = earlier.as_array().into_iter().flatten().find(|problem| problem["name"] == name);
    problem.and_then(|problem| Vec::deserialize(&problem["runs"]).ok()).unwrap_or_default()
}

fn row(Run { bounds, value, error, seconds }: &Run) -> String {
    format!("{:18} {:7} {value:10.5} {error:10.2e} {seconds:9.1}\n", bounds.capillary_step, bounds.cfl)
}

fn heading() -> String {
    format!(
        "# Errors and cost of long steps\n\n\
         The step is at most so many times the explicit capillary limit, and moves nothing farther than so many cells (`cfl`). Errors \
         are those against a closed form, or, where the table says so, against a run with steps of one limit and a quarter of a cell. \
         Wall times are those of {} threads that shared the machine ({}, {}; Meniscus {}); compare them within a table. This page is \
         made by `meniscus bench precision --markdown`.\n",
        rayon::current_num_threads(),
        std::env::consts::OS,
        std::env::consts::ARCH,
        version(),
    )
}

fn table(problem: &Problem, runs: &[Run]) -> String {
    let reference = if problem.has_closed_form() { "" } else { " (error against short steps)" };
    let mut out = format!(
        "\n## {}\n\nThe {}{reference}.\n\n| capillary limits | cfl | value | error | seconds |\n|---|---|---|---|---|\n",
        problem.name, problem.quantity
    );
    for Run { bounds, value, error, seconds } in runs {
        let cells = [
            bounds.capillary_step.to_string(),
            bounds.cfl.to_string(),
            format!("{value:.5}"),
            format!("{error:.2e}"),
            format!("{seconds:.1}"),
        ];
        let _ = write!(out, "{}", markdown::row(&cells));
    }
    out
}
