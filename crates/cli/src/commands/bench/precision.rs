//! `meniscus bench precision`: errors against cost with longer and longer steps.

use super::super::{print, show_progress, version};
use crate::failure::{Failure, Result};
use meniscus_scene::output::markdown;
use meniscus_validation::bench::precision::{self, PROBLEMS, Problem, Run};
use serde_json::{Value, json};
use std::fmt::Write as _;

/// Runs each problem and prints its rows. `quick`: two of the bounds. `as_markdown`: rows go to standard error as they come, and at the end
/// the tables go to standard output as a page of Markdown.
pub fn precision(quick: bool, as_markdown: bool) -> Result<Value> {
    let show = |text: &str| show_progress(text, as_markdown);
    let (mut results, mut page) = (Vec::new(), heading());
    for problem in &PROBLEMS {
        let Problem { name, quantity, .. } = problem;
        show(&format!("{name}: {quantity}\n  capillary limits     cfl      value      error   seconds\n"))?;
        let mut shown = Ok(());
        let runs = precision::run(problem, quick, |run| {
            let row = show(&row(run));
            if shown.is_ok() {
                shown = row;
            }
        });
        shown?;
        let runs = runs.map_err(|e| Failure::new(5, format!("`{name}` failed: {e}")))?;
        page += &table(problem, &runs);
        results.push(json!({ "name": name, "quantity": quantity, "runs": runs }));
    }
    if as_markdown {
        print(&page)?;
    }
    Ok(json!(results))
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
