//! Barriers between solids in the potential of a step.
//!
//! A barrier with the energy `B` is felt at the end of the coming step, after `a`, where nothing may overlap (M. Li et al. 2020). Pairs that
//! came towards each other with the old velocities feel it at the nearer of two places, there or at the time of the new velocities, after
//! `l`, where the step keeps its books of energy ([`crate::simulation::step`]):
//!
//! ```text
//! h max ((B(x + a v) − B(x))/a, (B(x + l v) − B(x))/l)
//! ```
//!
//! with the time `h` for which forces act. So what comes loses at least what is stored, also in the step in which it turns, and what
//! parts gets at most that: a convex `B` rises by less than its slope at a nearer place, and falls by more than that at a farther one.
//! Limit: what comes back in the step after it parted can win energy. Rigid solids feel a dashpot besides ([`super::dashpot`]).

use super::moments::{Early, Felt, Moment, Moments};
use super::term::{Term, of_distance};
use super::total::Potential;
use crate::collision::broad_phase::Candidates;
use crate::collision::places::Places;
use crate::collision::points::{Meeting, Owner};
use meniscus_contact::{Barrier, Contact};
use meniscus_numerics::Vector;
use rayon::prelude::*;

/// Part of the softer solid's Young's modulus in the stiffness of the barrier: under a stress that strains it by a tenth the gap is half
/// the reach.
const ELASTIC: f64 = 0.1;

/// A point and the nearest place of what it meets.
pub struct Met<const D: usize> {
    /// Number of the point.
    pub point: u32,
    /// Distance, m.
    pub distance: f64,
    /// Direction away from the other.
    pub normal: Vector<D>,
    /// The other place, where it moves.
    pub other: Option<Owner<D>>,
}

impl<'a, const D: usize> Potential<'a, D> {
    /// The solids at the end of the coming step with these velocities.
    pub fn places<'b>(&'b self, velocities: &'b [Vector<D>]) -> Places<'b, D> {
        self.places_after(velocities, self.ahead)
    }

    /// The solids after a time with these velocities.
    pub fn places_after<'b>(&'b self, velocities: &'b [Vector<D>], time: f64) -> Places<'b, D> {
        Places::new(self.model, self.solids, self.points, velocities, time)
    }

    /// The moments of a step with these velocities.
    pub fn moments<'b>(&'b self, velocities: &'b [Vector<D>]) -> Moments<'b, D> {
        let after = |velocities: &'b [Vector<D>], time| Moment::new(self.places_after(velocities, time));
        Moments { past: &self.past, early: after(velocities, self.lead), late: after(velocities, self.ahead) }
    }

    /// Stiffness of the barrier, Pa, between a solid and another, or a side: the pressures that there can be, tension's in a drop of a
    /// cell, that of a column of liquid through the domain, of the solids' weight and start, and what presses the softer one by a tenth.
    /// Solids that press each other so much rest half the reach apart.
    pub fn stiffness(&self, solid: usize, other: Option<usize>) -> f64 {
        let model = self.model;
        let speed = model.grid.dx / model.capillary_step();
        let column: f64 = model.gravity.iter().zip(&model.grid.upper()).map(|(g, l)| (g * l).abs()).sum();
        let young = |solid: usize| model.solids[solid].elastic().map_or(f64::INFINITY, |e| e.young());
        let pressure = |solid: usize| self.points.pressures[solid];
        let softer = young(solid).min(other.map_or(f64::INFINITY, young));
        let elastic = if softer.is_finite() { ELASTIC * softer } else { 0.0 };
        let heavier = pressure(solid).max(other.map_or(0.0, pressure));
        model.density * (speed * speed + column) + heavier + elastic
    }

    /// The barrier between a point and what has no facets.
    pub fn barrier(&self, point: u32) -> Barrier {
        Barrier { reach: self.barrier.reach.min(self.points.surface.reach(point)) }
    }

    /// The contacts within reach at the end.
    pub fn contacts(&self, candidates: &Candidates, at: &[Vector<D>]) -> Vec<Contact> {
        let solid = |p: u32| self.points.owners[p as usize].solid();
        candidates.near.contacts(self.barrier.reach, at, |p, q| self.stiffness(solid(p), Some(solid(q))))
    }

    /// A point that feels something without facets; nothing where it is out of reach.
    pub fn met(&self, meeting: &Meeting, places: &Places<'_, D>, at: &[Vector<D>]) -> Option<Met<D>> {
        let point = meeting.point();
        let x = &at[point as usize];
        let distance = meeting.distance(places, x) - self.points.thickness(meeting);
        if distance >= self.barrier(point).reach {
            return None;
        }
        let (normal, other) = match *meeting {
            Meeting::Rigid(_, solid, part) => {
                let normal = places.away_from_rigid((solid, part), x);
                (normal, Some(Owner::Rigid { solid, at: places.at_start(solid, x) }))
            }
            Meeting::Side(_, side) => (self.points.sides[side].normal, None),
        };
        Some(Met { point, distance, normal, other })
    }

    /// The pairs that feel their barrier early with these velocities.
    pub fn early(&self, velocities: &[Vector<D>], candidates: &Candidates) -> Early {
        let moments = self.moments(velocities);
        let contacts = self.contacts(candidates, &moments.early.at).into_iter();
        let meetings = candidates.meetings.iter().copied();
        let far = |m: &Meeting, now: &Moment<'_, D>| m.distance(&now.places, &now.at[m.point() as usize]);
        Early {
            contacts: contacts
                .filter(|c| moments.is_early(|m| c.distance(&m.at)))
                .map(|c| c.stencil)
                .collect(),
            meetings: meetings.filter(|m| moments.is_early(|now| far(m, now))).collect(),
        }
    }

    /// The contacts that are felt within reach at one of both moments.
    pub fn felt_contacts(&self, candidates: &Candidates, felt: &Felt<'_, D>) -> Vec<Contact> {
        let mut contacts = self.contacts(candidates, &felt.now().at);
        contacts.retain(|c| self.early.contacts.contains(&c.stencil) == felt.early);
        contacts
    }

    /// A point that feels something without facets at one of both moments.
    pub fn felt_met(&self, meeting: &Meeting, felt: &Felt<'_, D>) -> Option<Met<D>> {
        let (now, felt_now) = (felt.now(), self.early.meetings.contains(meeting) == felt.early);
        if felt_now { self.met(meeting, &now.places, &now.at) } else { None }
    }

    /// The sum of the barriers over the times until they are felt, W (2D: W/m): as that of what they gain, but for a constant.
    pub fn barriers(&self, velocities: &[Vector<D>], candidates: &Candidates) -> f64 {
        let moments = self.moments(velocities);
        let of = |felt: &Felt<'_, D>| {
            let now = felt.now();
            let between: f64 = self.felt_contacts(candidates, felt).iter().map(|c| c.energy(&now.at)).sum();
            let met = |m: &&Meeting| self.early.meetings.contains(m) == felt.early;
            let stored = candidates.meetings.iter().filter(met).map(|m| self.stored_in(m, now)).sum::<f64>();
            (between + stored) / now.places.time()
        };
        moments.felt().iter().map(of).sum()
    }

    /// Energy of the barriers where solids are, J (2D: J/m).
    pub fn stored(&self, candidates: &Candidates) -> f64 {
        let now = &self.past.start;
        let contacts = self.contacts(candidates, &now.at);
        let between: f64 = contacts.iter().map(|c| c.energy(&now.at)).sum();
        between + candidates.meetings.iter().map(|m| self.stored_in(m, now)).sum::<f64>()
    }

    /// Energy of the barrier between a point and what has no facets, J (2D: J/m).
    fn stored_in(&self, meeting: &Meeting, now: &Moment<'_, D>) -> f64 {
        let point = meeting.point();
        let distance =
            meeting.distance(&now.places, &now.at[point as usize]) - self.points.thickness(meeting);
        let energy = self.barrier(point).of_distance(distance)[0];
        if energy > 0.0 { self.scale(meeting) * energy } else { 0.0 }
    }

    /// The area of a point times the stiffness of the barrier between it and what has no facets, N (2D: N/m).
    pub fn scale(&self, meeting: &Meeting) -> f64 {
        let point = meeting.point();
        let solid = self.points.owners[point as usize].solid();
        self.points.surface.area(point) * self.stiffness(solid, meeting.solid())
    }

    /// The terms of all barriers and dashpots, or the positive part of their second derivatives.
    pub fn barrier_terms(
        &self,
        velocities: &[Vector<D>],
        candidates: &Candidates,
        positive: bool,
    ) -> Vec<Term<D>> {
        let moments = self.moments(velocities);
        let terms = moments.felt().into_iter().flat_map(|felt| self.terms_at(candidates, &felt, positive));
        terms.chain(self.damping_terms(velocities, &candidates.meetings)).collect()
    }

    /// The terms of the barriers that are felt now.
    fn terms_at(&self, candidates: &Candidates, felt: &Felt<'_, D>, positive: bool) -> Vec<Term<D>> {
        let now = felt.now();
        let (owners, time) = (&self.points.owners, now.places.time());
        let lever = |p: u32| now.places.levers(&owners[p as usize]);
        let of_contact = |c: &Contact| {
            let local = c.derivatives(&now.at)?;
            let local = if positive { local.positive() } else { local };
            Some(Term { levers: c.stencil.points().iter().map(|p| lever(*p)).collect(), local, time })
        };
        let contacts = self.felt_contacts(candidates, felt);
        let mut terms: Vec<Term<D>> = contacts.par_iter().with_min_len(32).filter_map(of_contact).collect();
        for m in &candidates.meetings {
            let Some(Met { point, distance, normal, other }) = self.felt_met(m, felt) else {
                continue;
            };
            let [_, slope, bend] = self.barrier(point).of_distance(distance).map(|d| d * self.scale(m));
            let mut levers = vec![lever(point)];
            levers.extend(other.map(|o| now.places.levers(&o)));
            let local = of_distance(&normal, levers.len(), slope, bend);
            terms.push(Term { levers, local, time });
        }
        terms
    }
}
