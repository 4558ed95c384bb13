//! Newton's iterations of a step with solids that deform (design, numerics §5), where they are asked for.
//!
//! A step is linear about the positions at its start. An iteration takes the solids' forces and tangents where the last one led,
//! with the residual `R` of their velocities' change `w`, and solves for the liquid's pressure again:
//! `A (w' − w) = R + J λ' − J λ`. The liquid's own velocity before that pressure is the same in all of them.

use crate::exchange::Exchange;
use crate::model::Model;
use crate::soft::{Systems, spread};
use crate::solid::SolidState;
use crate::state::State;
use meniscus_elastic::Elastic;
use meniscus_numerics::Vector;
use meniscus_numerics::grid::FaceField;
use meniscus_numerics::linalg::SolveError;

/// What all iterations of a step start from.
pub struct Newton<'a, const D: usize> {
    model: &'a Model<D>,
    /// The solids before the forces.
    before: &'a [SolidState<D>],
    /// What contact lines give to them.
    line: &'a Exchange<D>,
    /// For how long forces act, s.
    time: f64,
    /// Velocities before the pressure.
    velocity: FaceField<D>,
    solids: Vec<SolidState<D>>,
    /// Velocities of solids that deform which the step does not resolve, m/s.
    fast: Vec<Vec<Vector<D>>>,
}

impl<'a, const D: usize> Newton<'a, D> {
    /// Before the pressure of a step; nothing where no iterations are asked for, or nothing deforms.
    pub fn start(
        model: &'a Model<D>,
        (before, state): (&'a [SolidState<D>], &State<D>),
        systems: &Systems<D>,
        line: &'a Exchange<D>,
        time: f64,
    ) -> Option<Self> {
        if model.numerics.newton_iterations == 0 || systems.iter().all(Option::is_none) {
            return None;
        }
        let fast = |(number, system): (usize, &Option<_>)| match (soft(model, before, number), system) {
            (Some((elastic, body)), Some(system)) => crate::soft::SoftSystem::fast(system, elastic, body),
            _ => Vec::new(),
        };
        let fast = systems.iter().enumerate().map(fast).collect();
        Some(Self {
            model,
            before,
            line,
            time,
            velocity: state.velocity.clone(),
            solids: state.solids.clone(),
            fast,
        })
    }

    /// Goes back to before the pressure, `pressure` having been given, with solids about where that led.
    ///
    /// # Errors
    /// [`SolveError::Indefinite`] with the number of the solid whose matrix has no factors.
    pub fn again(
        &self,
        state: &mut State<D>,
        systems: &mut Systems<D>,
        pressure: &Exchange<D>,
    ) -> Result<(), SolveError> {
        let reached = std::mem::replace(&mut state.solids, self.solids.clone());
        state.velocity.clone_from(&self.velocity);
        for (number, (system, now)) in systems.iter_mut().zip(&mut state.solids).enumerate() {
            let (Some(system), Some((elastic, body))) = (system, soft(self.model, self.before, number))
            else {
                continue;
            };
            let (Some(soft), Some(reached)) = (&mut now.soft, &reached[number].soft) else { continue };
            let weights = elastic.masses().iter().map(|m| self.model.gravity * (m * self.time));
            let mut impulses: Vec<Vector<D>> = weights.collect();
            let mut pressed = vec![Vector::zeros(); impulses.len()];
            let grips = |exchange: &'a Exchange<D>| exchange.grips.get(&(number as u32));
            grips(self.line).iter().for_each(|grips| spread(grips, 1.0, &mut impulses));
            pressure.grips.get(&(number as u32)).iter().for_each(|grips| spread(grips, 1.0, &mut pressed));
            impulses.iter_mut().zip(&pressed).for_each(|(j, p)| *j += p);
            let velocities = &reached.body.velocities;
            let wrong = system.iterate(elastic, (body, &self.fast[number]), &impulses, velocities);
            let failed = |_| SolveError::Indefinite { solid: number, step: self.time };
            let mut change = wrong.map_err(failed)?;
            change.iter_mut().zip(&pressed).for_each(|(r, p)| *r -= p);
            system.solve_vectors(&mut change);
            soft.body.velocities = velocities.iter().zip(&change).map(|(v, c)| v + c).collect();
            now.follow(elastic);
        }
        Ok(())
    }
}

/// A solid that deforms, and its state among others.
fn soft<'a, const D: usize>(
    model: &'a Model<D>,
    solids: &'a [SolidState<D>],
    number: usize,
) -> Option<(&'a Elastic<D>, &'a meniscus_elastic::ElasticState<D>)> {
    model.solids[number].elastic().zip(solids[number].soft.as_ref().map(|soft| &soft.body))
}
