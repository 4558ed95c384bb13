//! Energy of the barriers and of friction in the current configuration, and the narrowest gap between solids.
//!
//! The time step does not use these; they are for energy balances, because a solid at rest on another stores energy in the barrier.

use super::incremental_potential::Potential;
use super::slips::{Slips, advance_slips, friction_law};
use super::time_levels::{EarlyPairs, OldTimeLevels};
use crate::collision::broad_phase::{CandidatePairs, Sweep};
use crate::collision::configuration::Configuration;
use crate::collision::points::{BARRIER_REACH_CELLS, CollisionPoints};
use crate::model::Model;
use crate::solid::SolidState;
use crate::state::State;
use meniscus_contact::Barrier;
use meniscus_numerics::Vector;

/// Solids, and the elastic slips between them, after a time (s) with their current velocities.
pub fn advanced_solids<const D: usize>(
    model: &Model<D>,
    state: &State<D>,
    time: f64,
) -> (Vec<SolidState<D>>, Slips<D>) {
    let (mut solids, mut slips) = (state.solids.clone(), state.elastic_slips.clone());
    model.solids.iter().zip(&mut solids).for_each(|(solid, now)| solid.advance(now, state.time, time));
    advance_slips(model, &mut slips, time);
    (solids, slips)
}

/// Barriers of a model, with the activation distances of its start.
#[derive(Clone, Debug)]
pub struct Barriers<const D: usize> {
    points: CollisionPoints<D>,
}

impl<const D: usize> Barriers<D> {
    /// Barriers of a model.
    pub fn of(model: &Model<D>) -> Self {
        Self { points: CollisionPoints::of(model) }
    }

    /// Energy of the barriers and the elastic slips, J (2D: J/m).
    pub fn energy(&self, model: &Model<D>, solids: &[SolidState<D>], elastic_slips: &Slips<D>) -> f64 {
        let still = vec![Vector::zeros(); self.points.node_count()];
        let potential = Potential {
            model,
            solids,
            points: &self.points,
            parts: Vec::new(),
            barrier: Barrier { activation_distance: BARRIER_REACH_CELLS * model.grid.dx },
            impulse_time: 0.0,
            velocity_lead: 0.0,
            lookahead: 0.0,
            settling_time: 0.0,
            old_levels: OldTimeLevels::new(model, solids, &self.points, &still, 0.0),
            elastic_slips,
            early_pairs: EarlyPairs::default(),
            friction_contacts: Vec::new(),
            pressure_impulses: Vec::new(),
        };
        let candidates = potential.candidates(&still, &still);
        let friction = friction_law(model);
        let friction_energy: f64 = elastic_slips
            .values()
            .map(|slip| friction.slip_energy(slip.friction_limit, &slip.displacement))
            .sum();
        potential.barrier_energy(&candidates) + friction_energy
    }

    /// The narrowest gap, m, between surfaces of solids or between these and the sides of the domain. It is infinite if all gaps exceed
    /// the barrier's activation distance, and not positive if solids overlap.
    pub fn narrowest_gap(&self, model: &Model<D>, solids: &[SolidState<D>]) -> f64 {
        let still = vec![Vector::zeros(); self.points.node_count()];
        let places = Configuration::new(model, solids, &self.points, &still, 0.0);
        let at = places.positions();
        let all =
            CandidatePairs::on(&[Sweep { from: &places, to: &places }], BARRIER_REACH_CELLS * model.grid.dx);
        let of_meeting = all.sdf_pairs.iter().map(|m| {
            let point = m.point();
            m.distance(&places, &at[point as usize]) - self.points.surface.radius(point)
        });
        all.feature_pairs.gaps(&at).map(|(_, gap)| gap).chain(of_meeting).fold(f64::INFINITY, f64::min)
    }
}
