//! A case of the validation suite, its checks and its outcome.

use serde::Serialize;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Instant;

/// How thoroughly a case is run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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

/// One number of a case against its reference.
#[derive(Clone, Debug, PartialEq, Serialize)]
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

impl Check {
    /// A check of the relative error.
    pub fn relative(
        case: &str,
        quantity: &str,
        value: f64,
        reference: f64,
        must: f64,
        aim: Option<f64>,
        unit: &str,
    ) -> Self {
        let error = value / reference - 1.0;
        Self {
            error,
            pass: error.abs() <= must,
            ..Self::absolute(case, quantity, value, reference, must, aim, unit)
        }
    }

    /// A check of the error in the unit of the value.
    pub fn absolute(
        case: &str,
        quantity: &str,
        value: f64,
        reference: f64,
        must: f64,
        aim: Option<f64>,
        unit: &str,
    ) -> Self {
        let error = value - reference;
        Self {
            case: case.into(),
            quantity: quantity.into(),
            value,
            reference,
            error,
            must,
            aim,
            unit: unit.into(),
            pass: error.abs() <= must,
        }
    }
}

/// Outcome of a case.
#[derive(Clone, Debug, PartialEq, Serialize)]
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
        let checks = catch_unwind(AssertUnwindSafe(|| (self.run)(mode))).unwrap_or_default();
        let checks = if checks.is_empty() {
            vec![Check::absolute(self.name, "runs to its end", 0.0, 1.0, 0.0, None, "")]
        } else {
            checks
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
