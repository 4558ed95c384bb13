//! `[numerics]`: parameters of the discretisation.

use super::is_zero;
use crate::error::SceneError;
use crate::file::text::{Si, Time};
use crate::file::validator::Validator;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `[numerics]`: parameters of the discretisation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Numerics {
    /// Scheme of a time step; `meniscus` by default.
    pub scheme: Scheme,
    /// Courant number: largest displacement of the liquid or of a solid in a step, in cells; 0.01 to 2, 0.7 by
    /// default. Longer displacements are refused, because the distance to the interface is known within five cells of it only.
    pub cfl: f64,
    /// Largest step, above 0; not bounded by default.
    #[serde(skip_serializing_if = "is_unbounded", with = "Si::<Time>")]
    pub max_step: f64,
    /// Relative residual at which a pressure solve ends; 1e-14 to 0.1, 1e-6 by default.
    pub tolerance: f64,
    /// Largest number of iterations of a pressure solve; 1 to 1000000, 1000 by default.
    pub max_iterations: usize,
    /// Largest step as a multiple of the explicit capillary limit, 0.36 √(ρ Δ³ / γ); 0.01 to 1000, 5 by
    /// default.
    pub capillary_step: f64,
    /// Newton's iterations of a step where solids move freely or deform go on for at least so many after the
    /// first, which keeps the angular momentum of those that deform to rounding; without it they end where
    /// nothing moves by a thousandth of a contact's reach.
    #[serde(skip_serializing_if = "is_zero")]
    pub newton_iterations: u32,
    /// Constant step, above 0, without any bound by stability. Only a step that fails is repeated with half the
    /// length, which then grows back by at most a quarter a step.
    #[serde(skip_serializing_if = "Option::is_none", with = "Si::<Option<Time>>")]
    pub fixed_step: Option<f64>,
    /// Whether the momentum that the discretisation loses is restored; `true` by default.
    pub restore_momentum: bool,
    /// Number of threads, 1 to 1024; all available ones by default. The result does not depend on it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub threads: Option<usize>,
}

impl Default for Numerics {
    fn default() -> Self {
        Self {
            scheme: Scheme::Meniscus,
            cfl: 0.7,
            max_step: f64::INFINITY,
            tolerance: 1e-6,
            max_iterations: 1000,
            capillary_step: 5.0,
            newton_iterations: 0,
            fixed_step: None,
            restore_momentum: true,
            threads: None,
        }
    }
}

#[allow(clippy::trivially_copy_pass_by_ref)]
fn is_unbounded(step: &f64) -> bool {
    *step == f64::INFINITY
}

/// Scheme of a time step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Scheme {
    /// One coupled solve per step; capillary forces are gradients of the surface energy.
    Meniscus,
    /// The seven steps of the paper's Section 6, with its errata corrected, for comparison: liquid and
    /// solids without contact. Of this section it uses `cfl`, `max_step`, `fixed_step`, `capillary_step` up to 1,
    /// `tolerance`, twenty times `max_iterations`, and `threads`.
    Paper,
    /// The same with the errors of the paper as they are printed, to show what they do: drops lose volume and miss their angles, and soft
    /// solids need short steps.
    PaperAsPrinted,
}

impl Numerics {
    /// Checks the section of a scene; `has_moving_solids`: whether forces move or deform a solid.
    ///
    /// # Errors
    /// [`SceneError`] at the value.
    pub(in crate::file) fn validate(
        &self,
        has_moving_solids: bool,
        v: &mut Validator,
    ) -> Result<(), SceneError> {
        let at = |key: &str| format!("numerics.{key}");
        let max_step = Some(self.max_step).filter(|step| !is_unbounded(step));
        for (key, step) in [("max_step", max_step), ("fixed_step", self.fixed_step)] {
            step.map_or(Ok(()), |step| v.positive(&at(key), "a time step", step))?;
        }
        v.within(&at("cfl"), "the CFL number", self.cfl, [0.01, 2.0])?;
        v.within(&at("tolerance"), "the tolerance", self.tolerance, [1e-14, 0.1])?;
        let iterations = self.max_iterations as f64;
        v.within(&at("max_iterations"), "the number of iterations", iterations, [1.0, 1e6])?;
        let what = "the multiple of the explicit capillary limit";
        v.within(&at("capillary_step"), what, self.capillary_step, [0.01, 1000.0])?;
        let newton = at("newton_iterations");
        let iterations = f64::from(self.newton_iterations);
        v.within(&newton, "the number of Newton iterations", iterations, [0.0, 20.0])?;
        if iterations > 0.0 && !has_moving_solids {
            v.warn(&newton, "`newton_iterations` has no effect: no solid moves freely or deforms");
        }
        let threads =
            self.threads.map(|n| v.within(&at("threads"), "the number of threads", n as f64, [1.0, 1024.0]));
        threads.unwrap_or(Ok(()))
    }
}
