//! The table of a sweep: a row for each case with the values of its parameters, its checks and what its summary measures.

use super::outcome::Outcome;
use super::plan::{Plan, SweepFolder};
use super::vary::split_number;
use crate::failure::Result;
use meniscus_scene::output::Folder;
use meniscus_scene::output::summary::Summary;
use std::fmt::Write as _;

/// The table.
pub struct Table {
    /// The varied parameters.
    pub parameters: Vec<Parameter>,
    /// The cases, in the order of their numbers.
    pub rows: Vec<Row>,
    /// Names and units of all checks and measures, in the order of the first case that has them.
    pub quantities: Vec<(String, String)>,
}

/// A varied parameter.
pub struct Parameter {
    /// Its path.
    pub path: String,
    /// Unit that all its values have; empty if they are numbers, or have none in common.
    pub unit: String,
}

/// A case.
pub struct Row {
    /// Its number.
    pub case: usize,
    /// Values of the parameters without the common unit.
    pub values: Vec<String>,
    /// `finished`, `not started`, or the reason why it is not finished.
    pub state: String,
    /// Whether all checks are met; `None` unless it is finished.
    pub met: Option<bool>,
    /// Checks and measures by name.
    pub cells: Vec<Cell>,
}

/// A check or a measure of a case.
pub struct Cell {
    /// Its name.
    pub name: String,
    /// The value; `None` if it could not be measured.
    pub value: Option<f64>,
    /// Of a check whether it is met.
    pub met: Option<bool>,
}

impl Row {
    /// The cell of a quantity.
    pub fn cell(&self, name: &str) -> Option<&Cell> {
        self.cells.iter().find(|cell| cell.name == name)
    }
}

impl Table {
    /// The table of cases with these values.
    ///
    /// # Errors
    /// A failure if a file of a finished case cannot be read.
    pub fn of(folder: &SweepFolder, plan: &Plan, cases: &[Vec<String>]) -> Result<Self> {
        let unit = |k: usize| common_unit(cases.iter().filter_map(|values| values.get(k)));
        let parameter = |(k, path): (usize, &String)| Parameter { path: path.clone(), unit: unit(k) };
        let paths: Vec<String> = plan.vary.iter().map(|vary| vary.path.clone()).collect();
        let parameters: Vec<Parameter> = paths.iter().enumerate().map(parameter).collect();
        let (mut rows, mut quantities) = (Vec::new(), Vec::new());
        for (case, values) in cases.iter().enumerate() {
            let plain = |(value, parameter): (&String, &Parameter)| match split_number(value) {
                Some((number, _)) if !parameter.unit.is_empty() => number.to_string(),
                _ => value.clone(),
            };
            let values = values.iter().zip(&parameters).map(plain).collect();
            let outcome = Outcome::read(folder, case)?;
            let found = outcome.as_ref().map(cells).unwrap_or_default();
            for (cell, unit) in &found {
                if !quantities.iter().any(|(name, _)| *name == cell.name) {
                    quantities.push((cell.name.clone(), unit.clone()));
                }
            }
            rows.push(Row {
                case,
                values,
                state: outcome
                    .as_ref()
                    .map_or_else(|| state(folder, case), |o| o.summary.exit_reason.clone()),
                met: outcome.as_ref().map(Outcome::is_met),
                cells: found.into_iter().map(|(cell, _)| cell).collect(),
            });
        }
        Ok(Self { parameters, rows, quantities })
    }

    /// The table as CSV, with units in its first row; of a check also a column whether it is met, 1 or 0.
    pub fn csv(&self) -> String {
        let mut head = vec!["case".to_owned()];
        head.extend(self.parameters.iter().map(|p| with_unit(&p.path, &p.unit)));
        head.extend(["state".to_owned(), "met".to_owned()]);
        for (name, unit) in &self.quantities {
            head.push(with_unit(name, unit));
            if self.is_check(name) {
                head.push(format!("{name} met"));
            }
        }
        let mut text = line(&head);
        let flag = |met: Option<bool>| met.map_or(String::new(), |met| u8::from(met).to_string());
        for row in &self.rows {
            let mut words = vec![row.case.to_string()];
            words.extend(row.values.iter().cloned());
            words.extend([row.state.clone(), flag(row.met)]);
            for (name, _) in &self.quantities {
                let cell = row.cell(name);
                let value = cell.and_then(|cell| cell.value).filter(|value| value.is_finite());
                words.push(value.map_or(String::new(), exact));
                if self.is_check(name) {
                    words.push(flag(cell.and_then(|cell| cell.met)));
                }
            }
            text += &line(&words);
        }
        text
    }

    /// Whether a quantity is a check.
    pub fn is_check(&self, name: &str) -> bool {
        self.rows.iter().filter_map(|row| row.cell(name)).any(|cell| cell.met.is_some())
    }

    /// The table in columns for a terminal: parameters, state, and the checks.
    pub fn text(&self) -> String {
        let checks: Vec<&(String, String)> =
            self.quantities.iter().filter(|(name, _)| self.is_check(name)).collect();
        let mut lines = vec![vec!["case".to_owned()]];
        lines[0].extend(self.parameters.iter().map(|p| with_unit(&p.path, &p.unit)));
        lines[0].push("state".into());
        lines[0].extend(checks.iter().map(|(name, unit)| with_unit(name, unit)));
        for row in &self.rows {
            let mut words = vec![row.case.to_string()];
            words.extend(row.values.iter().cloned());
            words.push(row.state.clone());
            words.extend(checks.iter().map(|(name, _)| row.cell(name).map_or_else(String::new, verdict)));
            lines.push(words);
        }
        let columns = lines[0].len();
        let width = |k: usize| lines.iter().map(|line| line[k].chars().count()).max().unwrap_or(0);
        let widths: Vec<usize> = (0..columns).map(width).collect();
        let mut text = String::new();
        for line in &lines {
            let padded: Vec<String> =
                line.iter().zip(&widths).map(|(word, width)| format!("{word:<width$}")).collect();
            let _ = writeln!(text, "{}", padded.join("  ").trim_end());
        }
        text
    }
}

/// A check in words: its value and whether it is met.
fn verdict(cell: &Cell) -> String {
    let value = cell.value.map_or_else(|| "not measured".to_owned(), short);
    let met = if cell.met == Some(true) { "met" } else { "MISSED" };
    format!("{value} {met}")
}

/// A number with four significant digits.
pub fn short(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 || (value.fract() == 0.0 && size < 1e6) {
        return format!("{value}");
    }
    if !(1e-3..1e5).contains(&size) {
        return format!("{value:.3e}");
    }
    let digits = (3 - size.log10().floor() as i32).clamp(0, 6) as usize;
    format!("{value:.digits$}")
}

/// A number with all its digits.
fn exact(value: f64) -> String {
    if value.fract() == 0.0 && value.abs() < 1e15 { format!("{value}") } else { format!("{value:?}") }
}

/// A name with its unit in parentheses.
pub fn with_unit(name: &str, unit: &str) -> String {
    if unit.is_empty() { name.to_owned() } else { format!("{name} ({unit})") }
}

/// A row of CSV.
fn line(words: &[String]) -> String {
    let quoted = |word: &String| match word.contains([',', '"', '\n']) {
        true => format!("\"{}\"", word.replace('"', "\"\"")),
        false => word.clone(),
    };
    words.iter().map(quoted).collect::<Vec<_>>().join(",") + "\n"
}

/// The unit of values that are numbers with one and the same unit.
fn common_unit<'a>(values: impl Iterator<Item = &'a String>) -> String {
    let mut units = values.map(|value| split_number(value).map(|(_, unit)| unit));
    let Some(Some(first)) = units.next() else { return String::new() };
    if units.all(|unit| unit == Some(first)) { first.to_owned() } else { String::new() }
}

/// The state of a case that is not finished.
fn state(folder: &SweepFolder, case: usize) -> String {
    match Summary::read(&Folder::at(&folder.run(case)).summary()) {
        Ok(summary) => summary.exit_reason,
        Err(_) => "not started".to_owned(),
    }
}

/// Checks and measures of a finished case, each with its unit.
fn cells(outcome: &Outcome) -> Vec<(Cell, String)> {
    let check = |(name, verdict): &(String, meniscus_scene::output::summary::Verdict)| {
        let cell = Cell { name: name.clone(), value: verdict.value, met: Some(verdict.pass) };
        (cell, verdict.unit.clone())
    };
    let mut all: Vec<(Cell, String)> = outcome.checks.iter().map(check).collect();
    let mut measure = |name: String, value: Option<f64>, unit: &str| {
        if all.iter().all(|(cell, _)| cell.name != name) {
            all.push((Cell { name, value, met: None }, unit.to_owned()));
        }
    };
    let summary = &outcome.summary;
    for solid in &summary.solids {
        measure(format!("angle of {}", solid.name), solid.contact_angle, "deg");
        measure(format!("wetted share of {}", solid.name), Some(solid.wetted), "");
        if solid.deflection.is_some() {
            measure(format!("largest displacement of {}", solid.name), solid.deflection, "m");
        }
    }
    measure("number of drops".into(), Some(summary.drops.len() as f64), "");
    measure("volume error".into(), Some(summary.volume_error), "");
    measure("largest speed".into(), Some(summary.max_speed), "m/s");
    measure("simulated time".into(), Some(summary.simulated_seconds), "s");
    measure("steps".into(), Some(summary.steps as f64), "");
    measure("wall time".into(), Some(summary.wall_seconds), "s");
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_csv_has_units_and_quotes() {
        let cell = |name: &str, value, met| Cell { name: name.into(), value, met };
        let row = |case: usize, cells| Row {
            case,
            values: vec![if case == 0 { "60" } else { "[1, 2]" }.to_owned()],
            state: "finished".into(),
            met: Some(case == 0),
            cells,
        };
        let table = Table {
            parameters: vec![Parameter { path: "a.b".into(), unit: "deg".into() }],
            rows: vec![
                row(0, vec![cell("drops", Some(1.0), Some(true)), cell("steps", Some(3.0), None)]),
                row(1, vec![cell("drops", None, Some(false))]),
            ],
            quantities: vec![("drops".into(), String::new()), ("steps".into(), String::new())],
        };
        let rows = "case,a.b (deg),state,met,drops,drops met,steps\n0,60,finished,1,1,1,3\n1,\"[1, 2]\",finished,0,,0,\n";
        assert_eq!(table.csv(), rows);
        let text = table.text();
        assert!(text.contains("1 met") && text.contains("not measured MISSED"), "{text}");
    }

    #[test]
    fn units_in_common() {
        let unit =
            |values: &[&str]| common_unit(values.iter().map(|v| (*v).to_owned()).collect::<Vec<_>>().iter());
        assert_eq!(unit(&["1 mm", "2 mm"]), "mm");
        assert_eq!((unit(&["1 mm", "2 cm"]), unit(&["1", "2"]), unit(&["slip", "1 mm"])), Default::default());
    }

    #[test]
    fn numbers_are_short() {
        let all = [0.0, 3.0, 1.23456, 123.456, 1.2e-5, 0.01234].map(short);
        assert_eq!(all, ["0", "3", "1.235", "123.5", "1.200e-5", "0.01234"]);
    }
}
