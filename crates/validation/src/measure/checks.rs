//! Checks with one-sided tolerances, and failed runs.

use crate::case::{Bars, Check};
use meniscus_sim::StepError;

/// A tolerance, and that of the state of the art.
pub const fn bars(must: f64, aim: f64) -> Bars {
    Bars { must, aim: Some(aim) }
}

/// A tolerance alone.
pub const fn bar(must: f64) -> Bars {
    Bars { must, aim: None }
}

/// A check of a quantity that should vanish.
pub fn at_most(case: &str, quantity: impl Into<String>, value: f64, bars: Bars) -> Check {
    Check::absolute(case, quantity, value, 0.0, bars)
}

/// A check of a quantity that should be at least `must`; the reference is `aim`, and the error is the shortfall from it.
pub fn at_least(case: &str, quantity: impl Into<String>, value: f64, must: f64, aim: f64) -> Check {
    let check = Check::absolute(case, quantity, value, aim, bars(aim - must, 0.0));
    Check { error: (aim - value).max(0.0), pass: value >= must, ..check }
}

/// The checks, or a failed check if the run failed.
pub fn checks_or_failure(case: &str, checks: Result<Vec<Check>, StepError>) -> Vec<Check> {
    checks.unwrap_or_else(|error| vec![Check::unfinished(case, &format!("runs to its end ({error})"))])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_sided_bars() {
        let order = |value| at_least("drop", "order", value, 1.3, 1.8);
        assert!(!order(1.2).pass && order(1.4).pass && order(2.5).error == 0.0);
        let failed = checks_or_failure("drop", Err(StepError::NotFinite { time: 0.0, what: "velocity" }));
        assert!(failed.len() == 1 && !failed[0].pass);
    }
}
