//! Work and precision: the error of a result against what it costs, for longer and longer steps.
//!
//! Each problem runs with several bounds of the step: multiples of the explicit capillary limit, and paths in cells (Courant numbers). The
//! error is that against a closed form, or where there is none against the run with the shortest steps.
//!
//! Limit: the error contains that of the grid, which remains where the length of the steps no longer matters.

use crate::cases::liquid::rayleigh;
use crate::cases::rigid::{bounce, floating};
use crate::cases::soft::soft_sag;
use crate::cases::wetting::sessile;
use crate::setup::{StepBounds, run_to};
use meniscus_scene::build;
use meniscus_scene::builtin;
use meniscus_scene::error::SceneError;
use meniscus_scene::file::{LoadOptions, Quality};
use meniscus_scene::output::summary::deflection;
use meniscus_sim::StepError;
use serde::{Deserialize, Serialize};
use std::time::Instant;
use thiserror::Error;

/// Multiples of the explicit capillary limit, with the usual Courant number.
const CAPILLARY_STEPS: [f64; 5] = [2.0, 5.0, 10.0, 20.0, 40.0];
/// Courant numbers, with steps of at most 20 capillary limits.
const COURANT_NUMBERS: [f64; 3] = [0.5, 1.0, 2.0];
/// Bounds of the reference of problems without a closed form.
const REFERENCE: StepBounds = StepBounds { capillary_step: 1.0, cfl: 0.25 };

/// A result of the simulation as a function of the bounds of the step.
pub struct Problem {
    /// Its name.
    pub name: &'static str,
    /// The measured quantity, with its unit.
    pub quantity: &'static str,
    /// The value of the theory; where there is none, the run with the shortest steps is the reference.
    exact: Option<f64>,
    /// Whether the Courant number bounds its steps; they are all of one length otherwise.
    has_courant_bound: bool,
    run: fn(StepBounds) -> Result<f64, PrecisionError>,
}

impl Problem {
    /// Whether errors are those against a closed form.
    pub fn has_closed_form(&self) -> bool {
        self.exact.is_some()
    }
}

/// A run of a problem.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Run {
    /// Bounds of the step.
    pub bounds: StepBounds,
    /// The measured value.
    pub value: f64,
    /// Its error.
    pub error: f64,
    /// Wall time, s.
    pub seconds: f64,
}

/// Why a problem could not run.
#[derive(Debug, Error)]
pub enum PrecisionError {
    /// A step failed.
    #[error(transparent)]
    Step(#[from] StepError),
    /// A scene is wrong.
    #[error(transparent)]
    Scene(#[from] Box<SceneError>),
}

/// The problems.
pub static PROBLEMS: [Problem; 6] = [
    Problem {
        name: "rayleigh-3d",
        quantity: "frequency of an oscillating drop over Rayleigh's, less one",
        exact: Some(0.0),
        has_courant_bound: false,
        run: |bounds| Ok(rayleigh::frequency_error(bounds.capillary_step)?),
    },
    Problem {
        name: "sessile-2d",
        quantity: "angle of a drop on a tilted wall less 60 degrees",
        exact: Some(0.0),
        has_courant_bound: true,
        run: |bounds| Ok(sessile::angle_error(bounds)?),
    },
    Problem {
        name: "soft-sag",
        quantity: "angle of a drop on a sagging plate, degrees",
        exact: Some(90.0),
        has_courant_bound: true,
        run: |bounds| Ok(soft_sag::angle(bounds)?),
    },
    Problem {
        name: "floating",
        quantity: "height of a floating cylinder less that of the closed form, R",
        exact: Some(0.0),
        has_courant_bound: true,
        run: |bounds| {
            let height = floating::float(1.0, 120.0, 12, floating::TIME, bounds)?;
            Ok(height.map_or(f64::NAN, |height| height.found - height.exact))
        },
    },
    Problem {
        name: "bounce",
        quantity: "contact time of a drop with a wall at a Weber number of 6.9, √(ρR³/γ)",
        exact: None,
        has_courant_bound: true,
        run: |bounds| Ok(bounce::bounce(16, 6.868, bounds)?.contact_time),
    },
    Problem {
        name: "fig14",
        quantity: "largest deflection of the plate of Fig. 14 at 256², mm",
        exact: None,
        has_courant_bound: true,
        run: largest_deflection,
    },
];

/// The bounds with which a problem runs. `quick`: two of them.
fn all_bounds(problem: &Problem, quick: bool) -> Vec<StepBounds> {
    let cfl = StepBounds::default().cfl;
    let reference = problem.exact.is_none().then_some(REFERENCE);
    let longer = CAPILLARY_STEPS.map(|capillary_step| StepBounds { capillary_step, cfl });
    let farther = COURANT_NUMBERS.map(|cfl| StepBounds { capillary_step: 20.0, cfl });
    let farther = farther.into_iter().filter(|_| problem.has_courant_bound);
    let all = reference.into_iter().chain(longer).chain(farther);
    if quick { all.take(2).collect() } else { all.collect() }
}

/// Runs a problem with all bounds, `quick`: with two; those of the reference come first where there is no closed form. Runs that `earlier`
/// has are taken from it; `each` is called with each run.
///
/// # Errors
/// Those of the problem.
pub fn run(
    problem: &Problem,
    quick: bool,
    earlier: &[Run],
    mut each: impl FnMut(&Run),
) -> Result<Vec<Run>, PrecisionError> {
    let (mut exact, mut runs) = (problem.exact, Vec::new());
    for bounds in all_bounds(problem, quick) {
        let run = match earlier.iter().find(|run| run.bounds == bounds) {
            Some(run) => *run,
            None => {
                let start = Instant::now();
                let value = (problem.run)(bounds)?;
                let error = value - exact.unwrap_or(value);
                Run { bounds, value, error, seconds: start.elapsed().as_secs_f64() }
            }
        };
        exact.get_or_insert(run.value);
        each(&run);
        runs.push(run);
    }
    Ok(runs)
}

/// The largest deflection of the plate of Fig. 14 within 40 ms, mm.
fn largest_deflection(bounds: StepBounds) -> Result<f64, PrecisionError> {
    let sets = vec![
        format!("numerics.capillary_step={}", bounds.capillary_step),
        format!("numerics.cfl={}", bounds.cfl),
    ];
    let options = LoadOptions { quality: Quality::Draft, sets };
    let scene = builtin::open("fig14-soft-plate", &options).map_err(Box::new)?;
    let mut sim = build::setup::<2>(&scene).map_err(Box::new)?.simulation();
    let mut largest = 0.0;
    run_to(&mut sim, 0.04, |sim, _| {
        largest = deflection(&sim.solid(0)).map_or(f64::NAN, |now| f64::max(now, largest));
    })?;
    Ok(1e3 * largest)
}
