//! A case of the validation suite, its checks and its outcome.

use serde::{Deserialize, Serialize};
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Instant;

/// How thoroughly a case is run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Mode {
    /// Coarse and short.
    Quick,
    /// As in the published table.
    Full,
}

/// A validation case.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// Short name: letters, digits, `-`.
    pub name: &'static str,
    /// Title, in a few words.
    pub title: &'static str,
    /// The comparison and the source of its reference.
    pub theory: &'static str,
    /// Whether it is part of `verify --quick`.
    pub quick: bool,
    /// Runs the case.
    pub run: fn(Mode) -> Vec<Check>,
}

/// Cases about one subject.
#[derive(Clone, Copy, Debug)]
pub struct Group {
    /// The subject.
    pub title: &'static str,
    /// Its cases.
    pub cases: &'static [Case],
}

/// One number of a case against its reference.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Check {
    /// Name of the case.
    pub case: String,
    /// What is measured.
    pub quantity: String,
    /// The measured value.
    pub value: f64,
    /// The reference value.
    pub reference: f64,
    /// The error: signed; relative, or in the unit of the value.
    pub error: f64,
    /// Tolerance: the largest absolute error that passes.
    pub must: f64,
    /// The tolerance of the state of the art.
    pub aim: Option<f64>,
    /// Unit of value and reference, empty for a pure number.
    pub unit: String,
    /// Whether the tolerance is met.
    pub pass: bool,
}

/// Tolerances of an error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bars {
    /// The largest absolute error that passes.
    pub must: f64,
    /// The tolerance of the state of the art.
    pub aim: Option<f64>,
}

impl Check {
    /// A check of the relative error of a pure number.
    pub fn relative(case: &str, quantity: impl Into<String>, value: f64, reference: f64, bars: Bars) -> Self {
        Self::new(case, quantity.into(), value, reference, value / reference - 1.0, bars)
    }

    /// A check of the absolute error of a pure number.
    pub fn absolute(case: &str, quantity: impl Into<String>, value: f64, reference: f64, bars: Bars) -> Self {
        Self::new(case, quantity.into(), value, reference, value - reference, bars)
    }

    fn new(case: &str, quantity: String, value: f64, reference: f64, error: f64, bars: Bars) -> Self {
        let Bars { must, aim } = bars;
        let (case, unit, pass) = (case.into(), String::new(), error.abs() <= must);
        Self { case, quantity, value, reference, error, must, aim, unit, pass }
    }

    /// The check with a unit of value and reference.
    pub fn in_unit(self, unit: &str) -> Self {
        Self { unit: unit.into(), ..self }
    }

    /// The failed check of a case that did not run to its end.
    pub(crate) fn unfinished(case: &str, quantity: &str) -> Self {
        Self::absolute(case, quantity, 0.0, 1.0, Bars { must: 0.0, aim: None })
    }
}

/// The message of a panic.
fn panic_message(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("a panic without a message")
}

/// Outcome of a case.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Its name.
    pub name: String,
    /// Its title.
    pub title: String,
    /// Its theory.
    pub theory: String,
    /// Wall time, s.
    pub seconds: f64,
    /// Its checks.
    pub checks: Vec<Check>,
}

impl Case {
    /// Runs the case. A panic or an empty list of checks counts as a failed check.
    pub fn outcome(&self, mode: Mode) -> Outcome {
        let start = Instant::now();
        let unfinished =
            |reason: &str| vec![Check::unfinished(self.name, &format!("runs to its end{reason}"))];
        let checks = match catch_unwind(AssertUnwindSafe(|| (self.run)(mode))) {
            Ok(checks) if checks.is_empty() => unfinished(" (it has no check)"),
            Ok(checks) => checks,
            Err(panic) => unfinished(&format!(" ({})", panic_message(&*panic))),
        };
        Outcome {
            name: self.name.into(),
            title: self.title.into(),
            theory: self.theory.into(),
            seconds: start.elapsed().as_secs_f64(),
            checks,
        }
    }
}
