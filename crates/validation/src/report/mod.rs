//! The results of the validation suite as text, JSON, HTML and Markdown.

mod history;

pub use history::{Entry, History};

use crate::{Check, Group, Mode, Outcome};
use meniscus_scene::output::markdown::{one_line, row};
use serde::Deserialize;
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

/// The results as JSON. `version` is that of the program.
pub fn json(outcomes: &[Outcome], mode: Mode, version: &str) -> Value {
    let (passed, all) = count(outcomes);
    json!({ "version": version, "mode": mode, "passed": passed, "checks": all, "cases": outcomes })
}

/// The outcomes in a text that [`json()`] wrote. One with a number that is not finite is left out, because JSON does not hold it.
///
/// # Errors
/// The text is not of this form, or the results are of another version or mode.
pub fn outcomes_of_json(text: &str, mode: Mode, version: &str) -> Result<Vec<Outcome>, String> {
    let all: Value = serde_json::from_str(text).map_err(|e| format!("it is not a file of results: {e}"))?;
    if all["version"] != version || all["mode"] != json!(mode) {
        let [of, as_mode] = ["version", "mode"].map(|key| all[key].as_str().unwrap_or("unknown"));
        let this_mode = json!(mode);
        return Err(format!(
            "its results are of version {of}, mode {as_mode}; this run is of version {version}, mode {}",
            this_mode.as_str().unwrap_or_default()
        ));
    }
    let cases = all["cases"].as_array().ok_or("it has no list of cases")?;
    Ok(cases.iter().filter_map(|case| Outcome::deserialize(case).ok()).collect())
}

/// The results as a self-contained page. `version` is that of the program.
pub fn html(outcomes: &[Outcome], mode: Mode, version: &str, history: &History) -> String {
    let (passed, all) = count(outcomes);
    let mut out = String::from(HEAD);
    let _ = writeln!(
        out,
        "<h1>Meniscus: validation</h1><p>Meniscus {}: {passed} of {all} checks passed.</p>",
        escape(version)
    );
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
        let drawing = history.drawing(&outcome.name, mode);
        let _ = writeln!(out, "</table><p class=time>{:.1} s {drawing}</p>", outcome.seconds);
    }
    out + "</body></html>\n"
}

const HEAD: &str = "<!doctype html><html lang=en><head><meta charset=utf-8><title>Meniscus: validation</title><style>
body{font:16px/1.5 system-ui,sans-serif;max-width:60rem;margin:2rem auto;padding:0 1rem;color:#1b2a33}
table{border-collapse:collapse;width:100%}th,td{text-align:right;padding:.2rem .6rem;border-bottom:1px solid #dde}
th:first-child,td:first-child{text-align:left}.pass td:last-child{color:#0a7d3c}.fail td{background:#fdecea}
.time{color:#789;font-size:.85rem}.history{float:right;fill:none;stroke:#9ab}.bar{stroke:#d43;stroke-dasharray:4 3}
.met{fill:#0a7d3c;stroke:none}.missed{fill:#d43;stroke:none}</style></head><body>
";

/// The results as a page of Markdown: totals, then a table for each of the groups of cases. `version` is that of the program.
pub fn markdown(
    outcomes: &[Outcome],
    groups: &[Group],
    mode: Mode,
    version: &str,
    history: &History,
) -> String {
    let command = match mode {
        Mode::Quick => "meniscus verify --quick",
        Mode::Full => "meniscus verify",
    };
    let mut out = format!(
        "# Results of the validation suite\n\nMeniscus {version}, `{command}`: {} cases; {}. Errors are relative, or in the unit of \
         the value; a check passes if the size of its error is at most the bar.\n\n\
         | group | cases | checks | passed |\n|---|---|---|---|\n",
        outcomes.len(),
        summary(outcomes).trim_end(),
    );
    let mut tables = String::new();
    for group in groups {
        let of_group = |o: &&Outcome| group.cases.iter().any(|case| case.name == o.name);
        let ours: Vec<&Outcome> = outcomes.iter().filter(of_group).collect();
        if !ours.is_empty() {
            let (passed, all) = count(ours.iter().copied());
            out += &row(&[group.title, &ours.len().to_string(), &all.to_string(), &passed.to_string()]);
            tables += &markdown_table(group.title, &ours, &|case| history.signs(case, mode));
        }
    }
    out + &tables
}

/// A group's section: the titles and histories of its cases, and a table of their checks.
fn markdown_table(title: &str, outcomes: &[&Outcome], history: &dyn Fn(&str) -> String) -> String {
    let mut out = format!("\n## {title}\n\n");
    for outcome in outcomes {
        let (name, title) = (&outcome.name, one_line(&outcome.title));
        let line = format!("- `{name}`: {title} ({:.0} s) {}", outcome.seconds, history(name));
        out += line.trim_end();
        out.push('\n');
    }
    out += "\n| case | quantity | value | reference | error | bar | |\n|---|---|---|---|---|---|---|\n";
    for check in outcomes.iter().flat_map(|o| &o.checks) {
        let [case, quantity, value, reference, error, bar, ..] = cells(check);
        let verdict = if check.pass { "pass" } else { "**FAIL**" };
        out += &row(&[format!("`{case}`"), quantity, value, reference, error, bar, verdict.to_string()]);
    }
    out
}

/// The numbers of passed and of all checks.
fn count<'a>(outcomes: impl IntoIterator<Item = &'a Outcome>) -> (usize, usize) {
    let checks: Vec<&Check> = outcomes.into_iter().flat_map(|o| &o.checks).collect();
    (checks.iter().filter(|c| c.pass).count(), checks.len())
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
    use crate::Case;
    use crate::measure::{bar, bars};

    #[test]
    fn reports_show_every_check() {
        let checks = vec![
            Check::relative("drop", "frequency", 79.5, 80.0, bars(0.02, 0.01)).in_unit("rad/s"),
            Check::absolute("drop", "angle", 93.5, 90.0, bar(3.0)).in_unit("deg"),
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
        assert!(
            html(std::slice::from_ref(&outcome), Mode::Quick, "0.1.0", &History::default())
                .contains("A &lt;drop&gt;")
        );
        let saved = json(std::slice::from_ref(&outcome), Mode::Quick, "0.1.0");
        assert_eq!(saved["passed"], 1);
        let text = saved.to_string();
        assert_eq!(outcomes_of_json(&text, Mode::Quick, "0.1.0"), Ok(vec![outcome]));
        assert!(outcomes_of_json(&text, Mode::Full, "0.1.0").unwrap_err().contains("mode quick"));
        assert!(outcomes_of_json(&text, Mode::Quick, "0.2.0").unwrap_err().contains("version 0.1.0"));
        assert!(outcomes_of_json("{", Mode::Quick, "0.1.0").is_err());
    }

    #[test]
    fn markdown_has_a_table_for_each_group() {
        let outcome = |name: &str, check| Outcome {
            name: name.into(),
            title: "A drop".into(),
            theory: String::new(),
            seconds: 2.0,
            checks: vec![check],
        };
        let speed = Check::absolute("static-2d", "max|u|", 0.5, 0.0, bars(1.0, 0.1));
        let angle = Check::absolute("sessile-2d", "angle", 93.5, 90.0, bar(3.0)).in_unit("deg");
        let outcomes = [outcome("static-2d", speed), outcome("sessile-2d", angle)];
        const fn case(name: &'static str) -> Case {
            Case { name, title: "", theory: "", quick: true, run: |_| Vec::new() }
        }
        const GROUPS: [Group; 3] = [
            Group { title: "Liquid without solids", cases: &[case("static-2d"), case("vortex")] },
            Group { title: "Contact lines", cases: &[case("sessile-2d")] },
            Group { title: "Rigid solids", cases: &[case("bounce")] },
        ];
        let page = markdown(&outcomes, &GROUPS, Mode::Quick, "0.1.0", &History::default());
        for part in [
            "Meniscus 0.1.0, `meniscus verify --quick`: 2 cases; 1 of 2 checks passed in 4 s.",
            "| Liquid without solids | 1 | 1 | 1 |\n| Contact lines | 1 | 1 | 0 |\n\n## Liquid without solids\n",
            "- `static-2d`: A drop (2 s)\n",
            "| `static-2d` | max\\|u\\| | 0.5000 | 0 | 0.5000 | 1.000 | pass |\n",
            "| `sessile-2d` | angle | 93.50 deg | 90.00 deg | 3.500 | 3.000 | **FAIL** |\n",
        ] {
            assert!(page.contains(part), "no {part} in\n{page}");
        }
        assert!(!page.contains("## Rigid solids"), "{page}");
    }
}
