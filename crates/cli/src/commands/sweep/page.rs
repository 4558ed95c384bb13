//! The page of a sweep: one HTML file with the table and, for two varied parameters, a phase map of each check and measure.

use super::plan::SweepFolder;
use super::table::{Row, Table, short, with_unit};
use meniscus_scene::output::Folder;
use std::fmt::Write as _;

/// Width and height of a cell of a phase map, pixels, and the space for labels beside and below.
const CELL: [f64; 2] = [76.0, 40.0];
const MARGIN: [f64; 2] = [110.0, 58.0];

/// Measures of the run rather than of its outcome, which have no map.
const UNMAPPED: [&str; 4] = ["volume error", "simulated time", "steps", "wall time"];

/// Colours of what is met, missed, and not finished.
const MET: &str = "#9fd8a4";
const MISSED: &str = "#f2a7a0";
const OPEN: &str = "#e4e4e4";

const STYLE: &str = "body{font:14px/1.5 system-ui,sans-serif;margin:2em auto;max-width:76em;padding:0 1em;color:#222;background:#fff}\
table{border-collapse:collapse;font-size:13px}th,td{border:1px solid #ccc;padding:3px 8px;text-align:right;white-space:nowrap}\
th{background:#f3f3f3}.wide{overflow-x:auto}.maps{display:flex;flex-wrap:wrap;gap:1.5em}figure{margin:0}figcaption{font-weight:600}\
svg text{font:12px system-ui,sans-serif;fill:#222}";

/// The page.
pub fn page(folder: &SweepFolder, title: &str, notes: &[String], table: &Table) -> String {
    let mut html = format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<title>{0}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<h1>{0}</h1>\n",
        escaped(title)
    );
    for note in notes {
        let _ = writeln!(html, "<p>{}</p>", escaped(note));
    }
    html += &maps(table);
    html += &rows(folder, table);
    html += "</body>\n</html>\n";
    html
}

/// A text with the characters of HTML replaced.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// The table, with links to the pages of cases that have one.
fn rows(folder: &SweepFolder, table: &Table) -> String {
    let mut html = String::from("<h2>Cases</h2>\n<div class=\"wide\"><table>\n<tr><th>case</th>");
    let mut head = |text: &str| {
        let _ = write!(html, "<th>{}</th>", escaped(text));
    };
    table.parameters.iter().for_each(|p| head(&with_unit(&p.path, &p.unit)));
    head("state");
    table.quantities.iter().for_each(|(name, unit)| head(&with_unit(name, unit)));
    html += "</tr>\n";
    for row in &table.rows {
        let page = Folder::at(&folder.run(row.case)).root().join("page/index.html");
        let number = match page.is_file() {
            true => format!("<a href=\"case_{0:04}/page/index.html\">{0}</a>", row.case),
            false => row.case.to_string(),
        };
        let _ = write!(html, "<tr><td>{number}</td>");
        row.values.iter().for_each(|value| html += &format!("<td>{}</td>", escaped(value)));
        let _ = write!(html, "<td style=\"background:{}\">{}</td>", color(row.met), escaped(&row.state));
        for (name, _) in &table.quantities {
            let cell = row.cell(name);
            let text = cell
                .map_or_else(String::new, |cell| cell.value.map_or_else(|| "not measured".to_owned(), short));
            match cell.and_then(|cell| cell.met) {
                Some(met) => {
                    let _ = write!(html, "<td style=\"background:{}\">{text}</td>", color(Some(met)));
                }
                None => html += &format!("<td>{text}</td>"),
            }
        }
        html += "</tr>\n";
    }
    html += "</table></div>\n";
    html
}

fn color(met: Option<bool>) -> &'static str {
    match met {
        Some(true) => MET,
        Some(false) => MISSED,
        None => OPEN,
    }
}

/// The phase maps; nothing unless two parameters are varied.
fn maps(table: &Table) -> String {
    if table.parameters.len() != 2 {
        return String::new();
    }
    let mut html = String::from("<h2>Phase maps</h2>\n<div class=\"maps\">\n");
    let word = |met: bool| if met { "met" } else { "missed" };
    let outcome = |row: &Row| (color(row.met).to_owned(), row.met.map_or("", word).to_owned());
    if table.rows.iter().flat_map(|row| &row.cells).any(|cell| cell.met.is_some()) {
        html += &map(table, "all checks", &outcome);
    }
    for (name, unit) in &table.quantities {
        let values = table.rows.iter().filter_map(|row| row.cell(name)?.value);
        let [low, high] = values.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| [a.min(x), b.max(x)]);
        let is_check = table.is_check(name);
        // A measure that is everywhere the same tells nothing.
        if !is_check && (low >= high || UNMAPPED.contains(&name.as_str())) {
            continue;
        }
        let look = |row: &Row| {
            let Some(cell) = row.cell(name) else { return (OPEN.to_owned(), String::new()) };
            let text = cell.value.map_or_else(|| "–".to_owned(), short);
            let shade = cell.value.map(|value| (value - low) / (high - low)).filter(|x| x.is_finite());
            match cell.met {
                Some(met) => (color(Some(met)).to_owned(), text),
                None => (shade.map_or_else(|| OPEN.to_owned(), blue), text),
            }
        };
        html += &map(table, &with_unit(name, unit), &look);
    }
    html + "</div>\n<p>Green: met; red: missed; grey: not finished. Blue: from the least to the largest value.</p>\n"
}

/// A blue that is the darker the larger the number from 0 to 1.
fn blue(x: f64) -> String {
    let between = |a: f64, b: f64| (a + (b - a) * x).round() as u8;
    format!("#{:02x}{:02x}{:02x}", between(240.0, 110.0), between(246.0, 165.0), between(252.0, 220.0))
}

/// A phase map: the first parameter to the right, the second one up, each case with a colour and a text.
fn map(table: &Table, title: &str, look: &dyn Fn(&Row) -> (String, String)) -> String {
    let distinct = |k: usize| {
        let mut all: Vec<&String> = Vec::new();
        for row in &table.rows {
            if !all.contains(&&row.values[k]) {
                all.push(&row.values[k]);
            }
        }
        all
    };
    let [across, up] = [distinct(0), distinct(1)];
    let (width, height) = (MARGIN[0] + CELL[0] * across.len() as f64, MARGIN[1] + CELL[1] * up.len() as f64);
    let mut svg = format!(
        "<figure><figcaption>{}</figcaption>\n<svg width=\"{width}\" height=\"{height}\" role=\"img\">\n",
        escaped(title)
    );
    let bottom = CELL[1] * up.len() as f64;
    let left = |i: usize| MARGIN[0] + CELL[0] * i as f64;
    let top = |j: usize| bottom - CELL[1] * (j + 1) as f64;
    let text = |x: f64, y: f64, anchor: &str, text: &str| {
        format!("<text x=\"{x}\" y=\"{y}\" text-anchor=\"{anchor}\">{}</text>\n", escaped(text))
    };
    let place = |all: &[&String], value: &String| all.iter().position(|v| *v == value).unwrap_or(0);
    for row in &table.rows {
        let (i, j) = (place(&across, &row.values[0]), place(&up, &row.values[1]));
        let (fill, words) = look(row);
        let (x, y) = (left(i), top(j));
        let _ = writeln!(
            svg,
            "<rect x=\"{x}\" y=\"{y}\" width=\"{}\" height=\"{}\" fill=\"{fill}\" stroke=\"#fff\"><title>case {}</title></rect>",
            CELL[0], CELL[1], row.case
        );
        svg += &text(x + 0.5 * CELL[0], y + 0.5 * CELL[1] + 4.0, "middle", &words);
    }
    for (i, value) in across.iter().enumerate() {
        svg += &text(left(i) + 0.5 * CELL[0], bottom + 18.0, "middle", value);
    }
    for (j, value) in up.iter().enumerate() {
        svg += &text(MARGIN[0] - 8.0, top(j) + 0.5 * CELL[1] + 4.0, "end", value);
    }
    let name = |k: usize| with_unit(&table.parameters[k].path, &table.parameters[k].unit);
    svg += &text(0.5 * width, bottom + 36.0, "middle", &format!("→ {}", name(0)));
    svg += &text(0.5 * width, bottom + 52.0, "middle", &format!("↑ {}", name(1)));
    svg + "</svg></figure>\n"
}

#[cfg(test)]
mod tests {
    use super::super::table::{Cell, Parameter};
    use super::*;
    use std::path::Path;

    fn table() -> Table {
        let parameter = |path: &str| Parameter { path: path.into(), unit: "<deg>".into() };
        let row = |case: usize| Row {
            case,
            values: vec![(case / 2).to_string(), (case % 2).to_string()],
            state: "finished".into(),
            met: [Some(true), Some(false), None, Some(true)][case],
            cells: match case {
                2 => Vec::new(),
                _ => vec![
                    Cell { name: "drops".into(), value: Some(case as f64), met: Some(case != 1) },
                    Cell { name: "wetted".into(), value: Some(case as f64), met: None },
                    Cell { name: "same".into(), value: Some(1.0), met: None },
                ],
            },
        };
        Table {
            parameters: vec![parameter("a"), parameter("b")],
            rows: (0..4).map(row).collect(),
            quantities: ["drops", "wetted", "same"].map(|name| (name.into(), String::new())).to_vec(),
        }
    }

    #[test]
    fn two_parameters_make_maps() {
        let folder = SweepFolder::at(Path::new("/nowhere"));
        let html = page(&folder, "A & B", &["a < b".into()], &table());
        assert!(html.contains("A &amp; B") && html.contains("a &lt; b") && html.contains("a (&lt;deg&gt;)"));
        // All checks, the check, and the measure that is not everywhere the same, with four cases each.
        assert_eq!((html.matches("<svg").count(), html.matches("<rect").count()), (3, 12));
        assert_eq!(html.matches(&format!("fill=\"{MISSED}\"")).count(), 2);
        assert_eq!(html.matches(&format!("fill=\"{OPEN}\"")).count(), 3);
        let mut one = table();
        one.parameters.pop();
        one.rows.iter_mut().for_each(|row| drop(row.values.pop()));
        assert!(!page(&folder, "", &[], &one).contains("<svg"));
    }
}
