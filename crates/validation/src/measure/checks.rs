//! Checks with one-sided tolerances, and failed runs.

use crate::Check;
use meniscus_sim::StepError;

/// A check of a quantity that should vanish.
pub fn at_most(case: &str, quantity: &str, value: f64, must: f64, aim: Option<f64>, unit: &str) -> Check {
    Check::absolute(case, quantity, value, 0.0, must, aim, unit)
}

/// A check of a quantity that should be at least `must`, with the aim `aim`; the error is the shortfall.
pub fn at_least(case: &str, quantity: &str, value: f64, must: f64, aim: f64) -> Check {
    let mut check = Check::absolute(case, quantity, value, aim, aim - must, Some(0.0), "");
    check.error = (aim - value).max(0.0);
    check.pass = value >= must;
    check
}

/// The checks, or a failed check if the run failed.
pub fn checks_or_failure(case: &str, checks: Result<Vec<Check>, StepError>) -> Vec<Check> {
    checks.unwrap_or_else(|error| {
        vec![Check::absolute(case, &format!("runs to its end ({error})"), 0.0, 1.0, 0.0, None, "")]
    })
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
