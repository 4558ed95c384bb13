//! The results of the validation suite as text, JSON and HTML.

use crate::{Check, Outcome};
use serde_json::{Value, json};
use std::fmt::Write as _;

/// The results of a case as a table for a terminal.
pub fn text(outcome: &Outcome) -> String {
    let header = ["case", "quantity", "value", "reference", "error", "must", "aim", ""].map(String::from);
    let mut rows = vec![header];
    rows.extend(outcome.checks.iter().map(cells));
    let widths: Vec<usize> =
        (0..8).map(|c| rows.iter().map(|row| row[c].chars().count()).max().unwrap_or(0)).collect();
    let mut out = String::new();
    for (i, row) in rows.iter().enumerate() {
        let mut line = String::new();
        for (c, (cell, width)) in row.iter().zip(&widths).enumerate() {
            let gap = " ".repeat(width - cell.chars().count());
            let numeric = (2..7).contains(&c);
            let _ = if numeric { write!(line, "{gap}{cell}  ") } else { write!(line, "{cell}{gap}  ") };
        }
        let _ = writeln!(out, "{}", line.trim_end());
        if i == 0 {
            let _ = writeln!(out, "{}", "-".repeat(line.trim_end().chars().count() + 6));
        }
    }
    out + "\n"
}

/// Number of passed checks, and the time of all cases.
pub fn summary(outcomes: &[Outcome]) -> String {
    let (passed, all) = count(outcomes);
    let seconds = outcomes.iter().map(|o| o.seconds).fold(0.0, |sum, s| sum + s);
    format!("{passed} of {all} checks passed in {seconds:.0} s\n")
}

/// The results as JSON.
pub fn json(outcomes: &[Outcome]) -> Value {
    let (passed, all) = count(outcomes);
    json!({ "version": env!("CARGO_PKG_VERSION"), "passed": passed, "checks": all, "cases": outcomes })
}

/// The results as a self-contained page.
pub fn html(outcomes: &[Outcome]) -> String {
    let (passed, all) = count(outcomes);
    let mut out = String::from(HEAD);
    let _ = writeln!(out, "<h1>Meniscus: validation</h1><p>{passed} of {all} checks passed.</p>");
    for outcome in outcomes {
        let _ = writeln!(out, "<h2>{}</h2><p>{}</p>", escape(&outcome.title), escape(&outcome.theory));
        out += "<table><tr><th>quantity<th>value<th>reference<th>error<th>must<th>aim<th></tr>\n";
        for check in &outcome.checks {
            let row = cells(check);
            let class = if check.pass { "pass" } else { "fail" };
            let _ = write!(out, "<tr class={class}>");
            row[1..].iter().for_each(|cell| out += &format!("<td>{}", escape(cell)));
            out += "</tr>\n";
        }
        let _ = writeln!(out, "</table><p class=time>{:.1} s</p>", outcome.seconds);
    }
    out + "</body></html>\n"
}

const HEAD: &str = "<!doctype html><html lang=en><head><meta charset=utf-8><title>Meniscus: validation</title><style>
body{font:16px/1.5 system-ui,sans-serif;max-width:60rem;margin:2rem auto;padding:0 1rem;color:#1b2a33}
table{border-collapse:collapse;width:100%}th,td{text-align:right;padding:.2rem .6rem;border-bottom:1px solid #dde}
th:first-child,td:first-child{text-align:left}.pass td:last-child{color:#0a7d3c}.fail td{background:#fdecea}
.time{color:#789;font-size:.85rem}</style></head><body>
";

fn count(outcomes: &[Outcome]) -> (usize, usize) {
    let checks = || outcomes.iter().flat_map(|o| &o.checks);
    (checks().filter(|c| c.pass).count(), checks().count())
}

fn cells(check: &Check) -> [String; 8] {
    let unit = if check.unit.is_empty() { String::new() } else { format!(" {}", check.unit) };
    let verdict = match (check.pass, check.aim) {
        (false, _) => "FAIL",
        (true, Some(aim)) if check.error.abs() <= aim => "pass, aim met",
        (true, _) => "pass",
    };
    [
        check.case.clone(),
        check.quantity.clone(),
        format!("{}{unit}", number(check.value)),
        format!("{}{unit}", number(check.reference)),
        number(check.error),
        number(check.must),
        check.aim.map_or_else(String::new, number),
        verdict.to_string(),
    ]
}

/// A number with about four digits.
fn number(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 {
        "0".into()
    } else if (1e-3..1e5).contains(&size) {
        let digits = (3 - size.log10().floor() as i32).clamp(0, 6) as usize;
        format!("{value:.digits$}")
    } else {
        format!("{value:.2e}")
    }
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reports_show_every_check() {
        let checks = vec![
            Check::relative("drop", "frequency", 79.5, 80.0, 0.02, Some(0.01), "rad/s"),
            Check::absolute("drop", "angle", 93.5, 90.0, 3.0, None, "deg"),
        ];
        assert!(checks[0].pass && !checks[1].pass);
        let outcome = Outcome {
            name: "drop".into(),
            title: "A <drop>".into(),
            theory: "Rayleigh".into(),
            seconds: 1.0,
            checks,
        };
        let text = text(&outcome);
        assert!(text.contains("aim met") && text.contains("FAIL"));
        assert!(summary(std::slice::from_ref(&outcome)).contains("1 of 2 checks"));
        assert!(html(std::slice::from_ref(&outcome)).contains("A &lt;drop&gt;"));
        assert_eq!(json(&[outcome])["passed"], 1);
    }
}
