//! What the barriers between solids hold: their energy and friction's where solids are now, and the narrowest gap that they keep
//! open.
//!
//! No step asks for it; the books of a study do, as a body at rest on another has a part of its energy there.

use super::moments::{Early, Past};
use super::slips::{Slips, advance, friction};
use super::total::Potential;
use crate::collision::broad_phase::{Candidates, Way};
use crate::collision::places::Places;
use crate::collision::points::{Points, REACH};
use crate::model::Model;
use crate::solid::SolidState;
use crate::state::State;
use meniscus_contact::Barrier;
use meniscus_numerics::Vector;

/// Solids, and the elastic slips between them, after a time (s) with the velocities that they have.
pub fn solids_after<const D: usize>(
    model: &Model<D>,
    state: &State<D>,
    time: f64,
) -> (Vec<SolidState<D>>, Slips<D>) {
    let (mut solids, mut slips) = (state.solids.clone(), state.slips.clone());
    model.solids.iter().zip(&mut solids).for_each(|(solid, now)| solid.advance(now, state.time, time));
    advance(model, &mut slips, time);
    (solids, slips)
}

/// The barriers of a model, as they are from its start on.
#[derive(Clone, Debug)]
pub struct Barriers<const D: usize> {
    points: Points<D>,
}

impl<const D: usize> Barriers<D> {
    /// Of a model.
    pub fn of(model: &Model<D>) -> Self {
        Self { points: Points::of(model) }
    }

    /// Their energy, and that of friction's elastic slips, J (2D: J/m).
    pub fn energy(&self, model: &Model<D>, solids: &[SolidState<D>], slips: &Slips<D>) -> f64 {
        let still = vec![Vector::zeros(); self.points.nodes()];
        let potential = Potential {
            model,
            solids,
            points: &self.points,
            parts: Vec::new(),
            barrier: Barrier { reach: REACH * model.grid.dx },
            kick: 0.0,
            lead: 0.0,
            ahead: 0.0,
            settling: 0.0,
            past: Past::new(model, solids, &self.points, &still, 0.0),
            slips,
            early: Early::default(),
            rubs: Vec::new(),
            pressed: Vec::new(),
        };
        let candidates = potential.candidates(&still, &still, 0.0);
        let friction = friction(model);
        let held: f64 = slips.values().map(|slip| friction.stored(slip.hold, &slip.way)).sum();
        potential.stored(&candidates) + held
    }

    /// The narrowest gap, m, between surfaces of solids, and of these and the sides of the domain; infinite where all are wider than
    /// the barrier's reach, not above zero where something overlaps.
    pub fn narrowest(&self, model: &Model<D>, solids: &[SolidState<D>]) -> f64 {
        let still = vec![Vector::zeros(); self.points.nodes()];
        let places = Places::new(model, solids, &self.points, &still, 0.0);
        let at = places.all();
        let all = Candidates::on(&[Way { from: &places, to: &places }], REACH * model.grid.dx, 0.0);
        let of_meeting = all.meetings.iter().map(|m| {
            let point = m.point();
            m.distance(&places, &at[point as usize]) - self.points.surface.radius(point)
        });
        all.near.gaps(&at).map(|(_, gap)| gap).chain(of_meeting).fold(f64::INFINITY, f64::min)
    }
}
