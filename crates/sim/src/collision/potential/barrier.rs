//! Barriers between solids in the potential of a step.
//!
//! With the impulse time `h` the term of a barrier with the energy `B` is
//!
//! ```text
//! h B(x + a v)/a  (late)    or    h B(x + l v)/l  (early)
//! ```
//!
//! The late configuration is the end of the coming step, after the time `a`, where nothing may overlap (M. Li
//! et al. 2020). The early one is that at the time of the new velocities, after `l`, at which the scheme
//! conserves energy ([`crate::model::time_step::unbounded_impulse_time`]). Pairs that approached with the old
//! velocities and are nearer at the early one use it; which pairs these are is lagged ([`EarlyPairs`]).
//!
//! As `B` is convex, approaching pairs lose at least the stored energy, also in the step of the turning point,
//! and separating pairs gain at most that (book/theory/contact.md). Limit: a pair that approaches again in the
//! step after it separated can gain energy. Pairs of rigid solids have a dashpot in addition
//! ([`super::dashpot`]).

use super::incremental_potential::Potential;
use super::term::{PotentialTerm, distance_derivatives};
use super::time_levels::{BarrierLevel, EarlyPairs, TimeLevel, TimeLevels};
use crate::collision::broad_phase::CandidatePairs;
use crate::collision::configuration::Configuration;
use crate::collision::points::{PointOwner, SdfPair};
use meniscus_contact::{Barrier, Contact};
use meniscus_numerics::{Vector, par};

/// Fraction of the softer solid's Young's modulus in the barrier stiffness. At a strain of a tenth half the gap is left.
const ELASTIC_STIFFNESS_FRACTION: f64 = 0.1;

/// A point and the closest point of a rigid solid or side.
pub struct SdfContact<const D: usize> {
    /// Number of the point.
    pub point: u32,
    /// Distance, m.
    pub distance: f64,
    /// Direction from the other feature to the point.
    pub normal: Vector<D>,
    /// The closest point of the other solid; `None` for a side.
    pub other: Option<PointOwner<D>>,
}

impl<'a, const D: usize> Potential<'a, D> {
    /// The solids at the end of the coming step with these velocities.
    pub fn configuration<'b>(&'b self, velocities: &'b [Vector<D>]) -> Configuration<'b, D> {
        self.configuration_after(velocities, self.lookahead)
    }

    /// The solids after the time `time` (s) with these velocities.
    pub fn configuration_after<'b>(&'b self, velocities: &'b [Vector<D>], time: f64) -> Configuration<'b, D> {
        Configuration::new(self.model, self.solids, self.points, velocities, time)
    }

    /// Time levels of the step with these velocities.
    pub fn time_levels<'b>(&'b self, velocities: &'b [Vector<D>]) -> TimeLevels<'b, D> {
        let after =
            |velocities: &'b [Vector<D>], time| TimeLevel::new(self.configuration_after(velocities, time));
        TimeLevels {
            past: &self.old_levels,
            early: after(velocities, self.velocity_lead),
            late: after(velocities, self.lookahead),
        }
    }

    /// Barrier stiffness, Pa, between a solid and another one or a side: the sum of `ρ (Δ/Δt_c)² = 7.7 γ/Δ`
    /// with the explicit capillary limit `Δt_c`, the hydrostatic pressure of the whole domain, the pressure of
    /// the solids' weight and initial speed, and a tenth of the smaller Young's modulus. Under this pressure
    /// solids rest at about half the activation distance.
    pub fn barrier_stiffness(&self, solid: usize, other: Option<usize>) -> f64 {
        let model = self.model;
        let speed = model.grid.dx / model.capillary_dt_limit();
        let column: f64 =
            model.gravity.iter().zip(&model.grid.domain_upper()).map(|(g, l)| (g * l).abs()).sum();
        let young = |solid: usize| model.solids[solid].elastic().map_or(f64::INFINITY, |e| e.young_modulus());
        let pressure = |solid: usize| self.points.weight_pressures[solid];
        let softer = young(solid).min(other.map_or(f64::INFINITY, young));
        let elastic = if softer.is_finite() { ELASTIC_STIFFNESS_FRACTION * softer } else { 0.0 };
        let heavier = pressure(solid).max(other.map_or(0.0, pressure));
        model.density * (speed * speed + column) + heavier + elastic
    }

    /// Barrier between a point and a rigid solid or side.
    pub fn point_barrier(&self, point: u32) -> Barrier {
        Barrier {
            activation_distance: self
                .barrier
                .activation_distance
                .min(self.points.surface.activation_distance(point)),
        }
    }

    /// Active contacts at a time level.
    fn contacts(&self, candidates: &CandidatePairs, now: &TimeLevel<'_, D>) -> Vec<Contact> {
        if candidates.feature_pairs.is_empty() {
            return Vec::new();
        }
        let solid = |p: u32| self.points.owners[p as usize].solid();
        candidates.feature_pairs.contacts(self.barrier.activation_distance, now.positions(), |p, q| {
            self.barrier_stiffness(solid(p), Some(solid(q)))
        })
    }

    /// Contact of a point with a rigid solid or side; `None` beyond the activation distance.
    pub fn sdf_contact(&self, meeting: &SdfPair, now: &TimeLevel<'_, D>) -> Option<SdfContact<D>> {
        let (point, places) = (meeting.point(), &now.configuration);
        let x = &now.positions()[point as usize];
        let distance = meeting.distance(places, x) - self.points.thickness(meeting);
        if distance >= self.point_barrier(point).activation_distance {
            return None;
        }
        let (normal, other) = match *meeting {
            SdfPair::Rigid(_, solid, part) => {
                let normal = places.rigid_normal(solid, part, x);
                (normal, Some(PointOwner::Rigid { solid, at: places.to_reference(solid, x) }))
            }
            SdfPair::Side(_, side) => (self.points.domain_sides[side].normal, None),
        };
        Some(SdfContact { point, distance, normal, other })
    }

    /// Pairs that use the early time level with these velocities.
    pub fn find_early_pairs(&self, velocities: &[Vector<D>], candidates: &CandidatePairs) -> EarlyPairs {
        let moments = self.time_levels(velocities);
        let contacts = self.contacts(candidates, &moments.early).into_iter();
        let meetings = candidates.sdf_pairs.iter().copied();
        let far = |m: &SdfPair, now: &TimeLevel<'_, D>| {
            m.distance(&now.configuration, &now.positions()[m.point() as usize])
        };
        EarlyPairs {
            contacts: contacts
                .filter(|c| moments.is_early(|m| c.distance(m.positions())))
                .map(|c| c.stencil)
                .collect(),
            sdf_pairs: meetings.filter(|m| moments.is_early(|now| far(m, now))).collect(),
        }
    }

    /// Active contacts that use this time level.
    pub fn active_contacts(&self, candidates: &CandidatePairs, felt: &BarrierLevel<'_, D>) -> Vec<Contact> {
        let mut contacts = self.contacts(candidates, felt.time_level());
        contacts.retain(|c| self.early_pairs.contacts.contains(&c.stencil) == felt.early);
        contacts
    }

    /// Contact of a point with a rigid solid or side, if the pair uses this time level.
    pub fn active_sdf_contact(&self, meeting: &SdfPair, felt: &BarrierLevel<'_, D>) -> Option<SdfContact<D>> {
        let (now, felt_now) = (felt.time_level(), self.early_pairs.sdf_pairs.contains(meeting) == felt.early);
        if felt_now { self.sdf_contact(meeting, now) } else { None }
    }

    /// Sum of the barriers' energies over the times to their levels, W (2D: W/m): up to a constant the mean power that they store.
    pub fn barrier_power(&self, velocities: &[Vector<D>], candidates: &CandidatePairs) -> f64 {
        let moments = self.time_levels(velocities);
        let of = |felt: &BarrierLevel<'_, D>| {
            let now = felt.time_level();
            let between: f64 =
                self.active_contacts(candidates, felt).iter().map(|c| c.energy(now.positions())).sum();
            let met = |m: &&SdfPair| self.early_pairs.sdf_pairs.contains(m) == felt.early;
            let stored =
                candidates.sdf_pairs.iter().filter(met).map(|m| self.sdf_barrier_energy(m, now)).sum::<f64>();
            (between + stored) / now.configuration.time()
        };
        moments.barrier_levels().iter().map(of).sum()
    }

    /// Energy of the barriers in the current configuration, J (2D: J/m).
    pub fn barrier_energy(&self, candidates: &CandidatePairs) -> f64 {
        let now = &self.old_levels.start;
        let contacts = self.contacts(candidates, now);
        let between: f64 = contacts.iter().map(|c| c.energy(now.positions())).sum();
        between + candidates.sdf_pairs.iter().map(|m| self.sdf_barrier_energy(m, now)).sum::<f64>()
    }

    /// Energy of the barrier between a point and a rigid solid or side, J (2D: J/m).
    fn sdf_barrier_energy(&self, meeting: &SdfPair, now: &TimeLevel<'_, D>) -> f64 {
        let point = meeting.point();
        let distance = meeting.distance(&now.configuration, &now.positions()[point as usize])
            - self.points.thickness(meeting);
        let energy = self.point_barrier(point).derivatives_by_distance(distance)[0];
        if energy > 0.0 { self.barrier_force_scale(meeting) * energy } else { 0.0 }
    }

    /// Area of a point times the barrier stiffness of the pair, N (2D: N/m).
    pub fn barrier_force_scale(&self, meeting: &SdfPair) -> f64 {
        let point = meeting.point();
        let solid = self.points.owners[point as usize].solid();
        self.points.surface.area(point) * self.barrier_stiffness(solid, meeting.solid())
    }

    /// Terms of all barriers and dashpots; with `positive` their Hessians are projected to be positive semidefinite.
    pub fn barrier_terms(
        &self,
        velocities: &[Vector<D>],
        candidates: &CandidatePairs,
        positive: bool,
    ) -> Vec<PotentialTerm<D>> {
        let moments = self.time_levels(velocities);
        let terms = moments
            .barrier_levels()
            .into_iter()
            .flat_map(|felt| self.barrier_terms_at(candidates, &felt, positive));
        terms.chain(self.damping_terms(velocities, &candidates.sdf_pairs)).collect()
    }

    /// Terms of the barriers that use this time level.
    fn barrier_terms_at(
        &self,
        candidates: &CandidatePairs,
        felt: &BarrierLevel<'_, D>,
        positive: bool,
    ) -> Vec<PotentialTerm<D>> {
        let now = felt.time_level();
        let (owners, time) = (&self.points.owners, now.configuration.time());
        let lever = |p: u32| now.configuration.node_jacobians(&owners[p as usize]);
        let of_contact = |c: &Contact| {
            let derivatives = c.derivatives(now.positions())?;
            let derivatives = if positive { derivatives.projected_psd() } else { derivatives };
            Some(PotentialTerm {
                node_jacobians: c.stencil.points().iter().map(|p| lever(*p)).collect(),
                derivatives,
                time,
            })
        };
        let contacts = self.active_contacts(candidates, felt);
        let mut terms = par::filter_map(contacts.len(), 32, |i| of_contact(&contacts[i]));
        for m in &candidates.sdf_pairs {
            let Some(SdfContact { point, distance, normal, other }) = self.active_sdf_contact(m, felt) else {
                continue;
            };
            let [_, slope, bend] = self
                .point_barrier(point)
                .derivatives_by_distance(distance)
                .map(|d| d * self.barrier_force_scale(m));
            let mut node_jacobians = vec![lever(point)];
            node_jacobians.extend(other.map(|o| now.configuration.node_jacobians(&o)));
            let derivatives = distance_derivatives(&normal, node_jacobians.len(), slope, bend);
            terms.push(PotentialTerm { node_jacobians, derivatives, time });
        }
        terms
    }
}
