//! The history of the suite: how near to its bar each case was, commit by commit.
//!
//! A file with one JSON object a line, for each version of the program, mode and case: the check whose error is the largest part of its bar.

use crate::{Check, Mode, Outcome};
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::fmt::Write as _;

/// Powers of ten of error over bar between which histories are drawn; what is beyond them is drawn at the end.
const RANGE: [f64; 2] = [-3.0, 0.5];
/// Size of a drawing, pixels.
const SIZE: [f64; 2] = [240.0, 36.0];
/// Signs for a history in a line of text, from far below the bar to it.
const SIGNS: [char; 7] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇'];
/// The sign of a missed bar.
const MISSED: char = '█';

/// A case at a commit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Entry {
    /// The version of the program, with its commit.
    pub version: String,
    /// `quick` or `full`.
    pub mode: String,
    /// Name of the case.
    pub case: String,
    /// What the check measures.
    pub quantity: String,
    /// Its value; none if it is not finite.
    pub value: Option<f64>,
    /// Its error, of which the size counts; none if it is not finite.
    pub error: Option<f64>,
    /// Its bar.
    pub bar: f64,
    /// Wall time of the case, s.
    pub seconds: f64,
}

impl Entry {
    /// The error over the bar; infinite without an error.
    fn ratio(&self) -> f64 {
        self.error.map_or(f64::INFINITY, |error| ratio(error, self.bar))
    }
}

/// Size of an error over its bar. A bar of zero is met only by no error.
fn ratio(error: f64, bar: f64) -> f64 {
    if error == 0.0 { 0.0 } else { (error / bar).abs() }
}

/// The entries, the oldest first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct History(Vec<Entry>);

impl History {
    /// Reads the text of a file.
    ///
    /// # Errors
    /// A message with the number of a line that is no entry.
    pub fn parse(text: &str) -> Result<Self, String> {
        let lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
        let entry = |(k, line): (usize, &str)| {
            serde_json::from_str(line).map_err(|e| format!("line {} is no entry: {e}", k + 1))
        };
        lines.map(entry).collect::<Result<_, _>>().map(Self)
    }

    /// The text of the file.
    pub fn text(&self) -> String {
        self.0.iter().map(|entry| format!("{}\n", json!(entry))).collect()
    }

    /// Adds outcomes. Those of the same version, mode and case are replaced.
    pub fn add(&mut self, outcomes: &[Outcome], mode: Mode, version: &str) {
        for outcome in outcomes {
            let part = |check: &&Check| {
                if check.error.is_nan() { f64::INFINITY } else { ratio(check.error, check.must) }
            };
            let Some(worst) = outcome.checks.iter().max_by(|a, b| part(a).total_cmp(&part(b))) else {
                continue;
            };
            let entry = Entry {
                version: version.into(),
                mode: name(mode),
                case: outcome.name.clone(),
                quantity: worst.quantity.clone(),
                value: Some(worst.value).filter(|x| x.is_finite()),
                error: Some(worst.error).filter(|x| x.is_finite()),
                bar: worst.must,
                seconds: outcome.seconds,
            };
            let same =
                |e: &&mut Entry| e.version == entry.version && e.mode == entry.mode && e.case == entry.case;
            match self.0.iter_mut().find(same) {
                Some(old) => *old = entry,
                None => self.0.push(entry),
            }
        }
    }

    /// The entries of a case.
    fn of(&self, case: &str, mode: Mode) -> Vec<&Entry> {
        let mode = name(mode);
        self.0.iter().filter(|entry| entry.case == case && entry.mode == mode).collect()
    }

    /// A case's errors over their bars as signs, and the last of them as a number; empty for fewer than two entries.
    pub(super) fn signs(&self, case: &str, mode: Mode) -> String {
        let entries = self.of(case, mode);
        let [.., last] = &entries[..] else { return String::new() };
        if entries.len() < 2 {
            return String::new();
        }
        let signs: String = entries.iter().map(|entry| sign(entry.ratio())).collect();
        format!("{signs} {:.2} of the bar", last.ratio())
    }

    /// A case's errors over their bars as a drawing on a logarithmic scale, with a line at the bar; empty for fewer than two entries.
    pub(super) fn drawing(&self, case: &str, mode: Mode) -> String {
        let entries = self.of(case, mode);
        if entries.len() < 2 {
            return String::new();
        }
        let [width, height] = SIZE;
        let x = |k: usize| 4.0 + (width - 8.0) * k as f64 / (entries.len() - 1) as f64;
        let y = |ratio: f64| 3.0 + (height - 6.0) * (1.0 - place(ratio));
        let mut out = format!("<svg class=history width={width} height={height}>");
        let _ = write!(out, "<line x1=0 x2={width} y1={0:.1} y2={0:.1} class=bar />", y(1.0));
        let points = entries.iter().enumerate().map(|(k, e)| format!("{:.1},{:.1}", x(k), y(e.ratio())));
        let _ = write!(out, "<polyline points=\"{}\" />", points.collect::<Vec<_>>().join(" "));
        for (k, entry) in entries.iter().enumerate() {
            let class = if entry.ratio() <= 1.0 { "met" } else { "missed" };
            let told = format!(
                "{}: {}, {:.2e} of the bar, {:.0} s",
                entry.version,
                entry.quantity,
                entry.ratio(),
                entry.seconds
            );
            let (x, y) = (x(k), y(entry.ratio()));
            let _ = write!(
                out,
                "<circle cx={x:.1} cy={y:.1} r=2.5 class={class}><title>{}</title></circle>",
                super::escape(&told)
            );
        }
        out + "</svg>"
    }
}

fn name(mode: Mode) -> String {
    json!(mode).as_str().unwrap_or_default().to_owned()
}

/// The place of a ratio in the range, 0 to 1.
fn place(ratio: f64) -> f64 {
    ((ratio.log10() - RANGE[0]) / (RANGE[1] - RANGE[0])).clamp(0.0, 1.0)
}

fn sign(ratio: f64) -> char {
    if ratio > 1.0 {
        return MISSED;
    }
    let below = (place(ratio) / place(1.0) * SIGNS.len() as f64) as usize;
    SIGNS[below.min(SIGNS.len() - 1)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::bar;

    fn outcome(error: f64) -> Outcome {
        let checks = vec![
            Check::absolute("drop", "angle", 90.0 + error, 90.0, bar(2.0)),
            Check::absolute("drop", "volume, \"lost\"", 0.0, 0.0, bar(0.0)),
        ];
        Outcome { name: "drop".into(), title: String::new(), theory: String::new(), seconds: 3.0, checks }
    }

    #[test]
    fn a_case_has_one_line_for_each_commit() {
        let mut history = History::default();
        for (version, error) in [("1", 0.02), ("2", -1.0), ("2", -1.9), ("3", 2.5)] {
            history.add(&[outcome(error)], Mode::Quick, version);
        }
        history.add(&[outcome(f64::NAN)], Mode::Full, "3");
        let text = history.text();
        assert_eq!(text.lines().count(), 4, "{text}");
        assert_eq!(History::parse(&text), Ok(history.clone()));
        assert_eq!(history.0[1].value, Some(88.1));
        assert_eq!(history.signs("drop", Mode::Quick), "▃▇█ 1.25 of the bar");
        assert_eq!(history.signs("drop", Mode::Full), "", "one entry is no history");
        let drawing = history.drawing("drop", Mode::Quick);
        assert_eq!((drawing.matches("met").count(), drawing.matches("missed").count()), (2, 1), "{drawing}");
        assert!(History::parse("\n{}\n").unwrap_err().contains("line 2"));
    }
}
