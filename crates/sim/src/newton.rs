//! Newton's iterations of a step with solids that deform (design, numerics §5), where they are asked for.
//!
//! A step is linear about the positions at its start. An iteration takes the solids' forces and tangents where the last one led,
//! with what is wrong there with the change `w` of their velocities, `R` (without the pressure), and solves for the liquid's
//! pressure again: `A (w' − w) = R + J λ'`. The liquid's velocity before the pressure is the same in all of them; what solids
//! rest on pushes as in the last step, and contact lines do as at the start.

use crate::exchange::Exchange;
use crate::model::Model;
use crate::soft::{SoftSystem, Systems, spread};
use crate::solid::SolidState;
use crate::state::State;
use meniscus_elastic::{Elastic, ElasticState};
use meniscus_numerics::Vector;
use meniscus_numerics::grid::FaceField;
use meniscus_numerics::linalg::SolveError;

/// Change of the velocities from one iteration to the next, over these and over the tolerance of the pressure's solve, at which
/// there is nothing more to be won.
const SETTLED: f64 = 10.0;

/// What all iterations of a step start from.
pub struct Newton<'a, const D: usize> {
    model: &'a Model<D>,
    /// The solids before the forces.
    before: &'a [SolidState<D>],
    /// For how long forces act, s.
    time: f64,
    /// Velocities before the pressure.
    velocity: FaceField<D>,
    solids: Vec<SolidState<D>>,
    /// Of solids that deform.
    soft: Vec<Option<Start<D>>>,
}

/// What the iterations of a solid that deforms start from.
struct Start<const D: usize> {
    /// The part of its velocities that the step does not resolve, m/s.
    fast: Vec<Vector<D>>,
    /// What gravity, contact lines and what it rests on give to its vertices, N s.
    impulses: Vec<Vector<D>>,
    /// Velocities that the last iteration came to, m/s.
    last: Vec<Vector<D>>,
}

impl<'a, const D: usize> Newton<'a, D> {
    /// Before the pressure of a step; nothing where no iterations are asked for, or nothing deforms.
    pub fn start(
        model: &'a Model<D>,
        (before, state): (&'a [SolidState<D>], &State<D>),
        systems: &Systems<D>,
        line: &Exchange<D>,
        time: f64,
    ) -> Option<Self> {
        if model.numerics.newton_iterations == 0 || systems.iter().all(Option::is_none) {
            return None;
        }
        let start = |(number, system): (usize, &Option<SoftSystem<D>>)| {
            let ((elastic, body), system) = soft(model, before, number).zip(system.as_ref())?;
            let resting = before[number].soft.as_ref()?.held.iter().map(|held| held * time);
            let mut impulses = system.impulses(&resting.collect::<Vec<_>>());
            impulses.iter_mut().zip(elastic.masses()).for_each(|(j, m)| *j += model.gravity * (m * time));
            line.grips.get(&(number as u32)).iter().for_each(|grips| spread(grips, &mut impulses));
            Some(Start { fast: system.fast(elastic, body), impulses, last: Vec::new() })
        };
        let soft = systems.iter().enumerate().map(start).collect();
        let (velocity, solids) = (state.velocity.clone(), state.solids.clone());
        Some(Self { model, before, time, velocity, solids, soft })
    }

    /// Goes back to before the pressure, with solids about where that led, unless nothing has changed since the last time: then
    /// it is `false`.
    ///
    /// # Errors
    /// [`SolveError::Indefinite`] with the number of the solid whose matrix has no factors.
    pub fn again(&mut self, state: &mut State<D>, systems: &mut Systems<D>) -> Result<bool, SolveError> {
        if self.settled(&state.solids) {
            return Ok(false);
        }
        state.velocity.clone_from(&self.velocity);
        state.solids.clone_from(&self.solids);
        for (number, (start, now)) in self.soft.iter().zip(&mut state.solids).enumerate() {
            let (Some(start), Some((elastic, body))) = (start, soft(self.model, self.before, number)) else {
                continue;
            };
            let (Some(system), Some(soft)) = (systems[number].take(), &mut now.soft) else { continue };
            let about = system.about(elastic, (body, &start.fast), &start.impulses, &start.last);
            let failed = |_| SolveError::Indefinite { solid: number, step: self.time };
            let (system, mut change) = about.map_err(failed)?;
            system.solve_vectors(&mut change);
            soft.body.velocities = start.last.iter().zip(&change).map(|(v, c)| v + c).collect();
            systems[number] = Some(system);
            now.follow(elastic);
        }
        Ok(true)
    }

    /// Takes note of the velocities that solids have come to; whether they are those of the last time.
    pub fn settled(&mut self, solids: &[SolidState<D>]) -> bool {
        let limit = SETTLED * self.model.numerics.tolerance;
        let mut settled = true;
        for (start, now) in self.soft.iter_mut().zip(solids) {
            let (Some(start), Some(soft)) = (start, &now.soft) else { continue };
            let now = &soft.body.velocities;
            let size: f64 = now.iter().map(Vector::norm_squared).sum();
            let change: f64 = now.iter().zip(&start.last).map(|(a, b)| (a - b).norm_squared()).sum();
            settled &= !start.last.is_empty() && change <= limit * limit * size;
            start.last.clone_from(now);
        }
        settled
    }
}

/// A solid that deforms, and its state among others.
fn soft<'a, const D: usize>(
    model: &'a Model<D>,
    solids: &'a [SolidState<D>],
    number: usize,
) -> Option<(&'a Elastic<D>, &'a ElasticState<D>)> {
    model.solids[number].elastic().zip(solids[number].soft.as_ref().map(|soft| &soft.body))
}
