//! The results of a soak as a table and as JSON.

use super::judge::invariants::INVARIANTS;
use super::{Class, Outcome};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// One or two lines per case: its scene and its violations.
pub fn line(outcome: &Outcome) -> String {
    let solids =
        if outcome.solids.is_empty() { String::new() } else { format!(" ({})", outcome.solids.join(", ")) };
    let mut out = format!(
        "{:14} {}D {:6} {:4} steps {:6.1} ms {:5.1} s",
        outcome.name,
        outcome.dimension,
        outcome.class.name(),
        outcome.steps,
        1e3 * outcome.time,
        outcome.seconds
    );
    outcome.repeated.iter().for_each(|how| out += &format!("  repeated: {how}"));
    outcome.cut.iter().for_each(|why| out += &format!("  ended {why}"));
    out += &solids;
    out.push('\n');
    for v in &outcome.violations {
        let _ = writeln!(
            out,
            "    {} at step {}, {:.4e} s: {:.4e}, limit {:.4e} ({}); worst {:.4e}",
            v.kind, v.step, v.time, v.value, v.bar, v.words, v.worst
        );
    }
    out
}

/// The final table: per class the cases with a violation of each invariant, and in brackets those that violated it first.
pub fn table(outcomes: &[Outcome]) -> String {
    let mut out = String::new();
    let of = |class: Class| outcomes.iter().filter(move |o| o.class == class);
    let mut row = |name: &str, cell: &dyn Fn(Class) -> String| {
        let cells = Class::ALL.map(|class| format!("{:>12}", cell(class)));
        let _ = writeln!(out, "{name:24}{}", cells.concat());
    };
    row("", &|class| class.name().into());
    row("cases", &|class| of(class).count().to_string());
    let broke = |o: &&Outcome| !o.violations.is_empty();
    row("violating", &|class| of(class).filter(broke).count().to_string());
    row("  per cent", &|class| {
        let (bad, all) = (of(class).filter(broke).count(), of(class).count());
        if all == 0 { String::new() } else { format!("{:.1}", 100.0 * bad as f64 / all as f64) }
    });
    for invariant in INVARIANTS {
        let has = |o: &&Outcome| o.violations.iter().any(|v| v.kind == invariant.name);
        let first = |o: &&Outcome| o.violations.first().is_some_and(|v| v.kind == invariant.name);
        if outcomes.iter().any(|o| has(&o)) {
            row(invariant.name, &|class| {
                format!("{} ({})", of(class).filter(has).count(), of(class).filter(first).count())
            });
        }
    }
    row("ended early", &|class| of(class).filter(|o| o.cut.is_some()).count().to_string());
    row("repeated", &|class| of(class).filter(|o| o.repeated.is_some()).count().to_string());
    row("seconds, mean", &|class| {
        let (sum, count) = of(class).fold((0.0, 0), |(s, n), o| (s + o.seconds, n + 1));
        if count == 0 { String::new() } else { format!("{:.1}", sum / f64::from(count)) }
    });
    if let Some(slowest) = outcomes.iter().max_by(|a, b| a.seconds.total_cmp(&b.seconds)) {
        let _ = writeln!(out, "slowest: {} ({:.1} s)", slowest.name, slowest.seconds);
    }
    let names = |kind: &str| {
        let all = outcomes.iter().filter(|o| o.violations.iter().any(|v| v.kind == kind));
        all.map(|o| o.name.as_str()).collect::<Vec<_>>().join(" ")
    };
    for invariant in INVARIANTS.iter().filter(|i| !names(i.name).is_empty()) {
        let _ = writeln!(out, "{} ({}): {}", invariant.name, invariant.holds, names(invariant.name));
    }
    out + &counted("gave up", &messages(outcomes)) + &counted("refused, drawn again", &refusals(outcomes))
}

fn counted(title: &str, all: &BTreeMap<String, usize>) -> String {
    if all.is_empty() {
        return String::new();
    }
    let mut sorted: Vec<_> = all.iter().collect();
    sorted.sort_by(|a, b| b.1.cmp(a.1));
    let lines = sorted.iter().map(|(words, count)| format!("  {count:5} {words}\n"));
    format!("{title}:\n{}", lines.collect::<String>())
}

/// A message without its numbers and names, which groups messages of one kind.
fn kind_of(message: &str) -> String {
    let mut out = String::new();
    for word in message.split_inclusive(' ') {
        let bare = word.trim();
        let number = bare.trim_start_matches(['-', '(']).starts_with(|c: char| c.is_ascii_digit());
        out += if bare.starts_with('`') {
            "`…` "
        } else if number {
            "# "
        } else {
            word
        };
    }
    out.trim_end().to_owned()
}

fn refusals(outcomes: &[Outcome]) -> BTreeMap<String, usize> {
    count(outcomes.iter().flat_map(|o| &o.refused).map(|m| kind_of(m)))
}

fn messages(outcomes: &[Outcome]) -> BTreeMap<String, usize> {
    let all =
        outcomes.iter().flat_map(|o| &o.violations).filter(|v| v.kind == "gave-up" || v.kind == "panic");
    count(all.map(|v| kind_of(&v.words)))
}

fn count(all: impl Iterator<Item = String>) -> BTreeMap<String, usize> {
    let mut counts = BTreeMap::new();
    all.for_each(|words| *counts.entry(words).or_insert(0) += 1);
    counts
}

/// The results as JSON: every case with its violations.
pub fn json(seed: u64, outcomes: &[Outcome]) -> Value {
    let violating = outcomes.iter().filter(|o| !o.violations.is_empty()).count();
    json!({
        "seed": seed, "cases": outcomes.len(), "violating": violating, "gave_up": messages(outcomes),
        "refused": refusals(outcomes), "outcomes": outcomes,
    })
}
