//! Impacts of rigid solids on each other and on the closed sides: `v_n' = −e v_n` with the coefficient of restitution `e` (Newton).
//!
//! An impact is an event: its impulses change the velocities at once, before the minimisation of the step's potential. It acts on pairs
//! that would come within the activation distance of the barrier in the coming step, so bouncing solids do not feel the barrier. Impacts
//! propagate from solid to solid in rounds. Each round is solved by projected Gauss–Seidel in a fixed order with Coulomb friction (E.
//! Guendelman, R. Bridson, R. Fedkiw, "Nonconvex rigid bodies with stacking", SIGGRAPH 2003). Every impulse acts on both solids at one
//! point, which conserves momentum and angular momentum to rounding. The barrier stops pairs that do not bounce.
//!
//! Limit: deformable solids have no restitution; they bounce by their own elasticity.

use super::broad_phase::{CandidatePairs, Sweep};
use super::configuration::Configuration;
use super::points::{BARRIER_REACH_CELLS, CollisionPoints, PointOwner, SdfPair};
use crate::coupling::impulses::moment;
use crate::model::Model;
use crate::model::time_step::StepTimes;
use crate::simulation::repairs::Repairs;
use crate::solid::{Solid, SolidKind, SolidState};
use meniscus_numerics::{Matrix, Vector};

/// Maximum number of rounds in a step.
const MAX_ROUNDS: usize = 12;
/// Maximum number of symmetric Gauss–Seidel sweeps.
const MAX_SWEEPS: usize = 300;
/// Change of speed in a sweep, relative to the largest speed, at which the iteration has converged.
const SWEEP_TOLERANCE: f64 = 1e-12;
/// Cosine of the angle between normals above which contacts of a pair belong to the same face.
const SAME_FACE_COSINE: f64 = 0.9;

/// Contact point between two solids, or a solid and a side.
#[derive(Clone, Debug)]
struct RigidContact<const D: usize> {
    /// The solid that the normal points to, and the other; `None` for a side.
    pair: (usize, Option<usize>),
    /// Midpoint between the surfaces, m.
    at: Vector<D>,
    normal: Vector<D>,
    /// Distance beyond the activation distance of the barrier, m.
    gap: f64,
    /// Gap after the coming step without impulses, m.
    predicted_gap: f64,
    /// Required minimum separation speed, m/s.
    target_speed: f64,
    /// Accumulated normal impulse, N s.
    normal_impulse: f64,
    /// Accumulated tangential impulse, N s.
    tangential_impulse: Vector<D>,
}

impl<const D: usize> RigidContact<D> {
    /// The normal, oriented by the solids' numbers instead of their order in the pair.
    fn ordered_normal(&self) -> Vector<D> {
        if self.pair.1 > Some(self.pair.0) { -self.normal } else { self.normal }
    }
}

/// State of the impact solver.
struct ImpactSolver<'a, const D: usize> {
    model: &'a Model<D>,
    solids: &'a mut [SolidState<D>],
    /// Solids before the forces of this step, and after them (`forced`).
    before: &'a [SolidState<D>],
    forced: Vec<SolidState<D>>,
    /// Inverse mass and inertia; zero for solids that are not free.
    inverse_masses: Vec<(f64, Matrix<3>)>,
    times: StepTimes,
}

/// Applies the impacts of rigid solids that would come within the activation distance of the barrier in the coming step. `before` are the
/// solids before the forces of this step, `solids` those after them. Returns the work, J (2D: J/m), of solids with prescribed motion;
/// `record` counts unconverged rounds.
pub fn resolve_impacts<const D: usize>(
    model: &Model<D>,
    points: &CollisionPoints<D>,
    solids: &mut [SolidState<D>],
    before: &[SolidState<D>],
    times: StepTimes,
    record: &mut Repairs,
) -> f64 {
    if !model.solids.iter().any(|s| s.kind.is_free_rigid() && s.restitution > 0.0) {
        return 0.0;
    }
    let inverse_masses = model.solids.iter().zip(&*solids).map(|(s, now)| match s.kind {
        SolidKind::Rigid => (1.0 / s.mass_properties.mass, s.inverse_inertia(&now.as_rigid())),
        _ => (0.0, Matrix::zeros()),
    });
    let (inverse_masses, forced) = (inverse_masses.collect(), solids.to_vec());
    let mut impacts = ImpactSolver { model, solids, before, forced, inverse_masses, times };
    let mut work = 0.0;
    for _ in 0..MAX_ROUNDS {
        let hits = impacts.impacting_contacts(points);
        if hits.is_empty() {
            return work;
        }
        match impacts.round(hits, record) {
            Some(done) => work += done,
            None => return work,
        }
    }
    record.contact_rounds += 1;
    work
}

impl<const D: usize> ImpactSolver<'_, D> {
    /// Contacts of rigid solids that bounce, with their target speeds. A contact whose approach speed comes from the forces of this step
    /// alone is resting and does not bounce.
    fn impacting_contacts(&self, points: &CollisionPoints<D>) -> Vec<RigidContact<D>> {
        let (dx, ahead) = (self.model.grid.dx, self.times.lookahead);
        let mut hits = Vec::new();
        for mut c in self.nearby_contacts(points) {
            let approach = -self.relative_velocity(self.solids, &c).dot(&c.normal);
            let together = self.forced_approach_speed(&c);
            let resting = 2.0 * together.abs() + 1e-6 * dx / ahead;
            if approach > resting && c.gap < approach * ahead {
                c.target_speed = self.rebound_speed(&c, approach, together);
                hits.extend((c.target_speed > resting).then_some(c));
            }
        }
        hits.sort_by_key(|c| c.pair);
        hits.chunk_by(|a, b| a.pair == b.pair).flat_map(|of_pair| reduce_contacts(of_pair.to_vec())).collect()
    }

    /// Contacts within the activation distance of the barrier during the coming step, with at least one free solid.
    fn nearby_contacts(&self, points: &CollisionPoints<D>) -> Vec<RigidContact<D>> {
        let velocities = points.node_velocities(self.solids);
        let still = vec![Vector::zeros(); velocities.len()];
        let from = Configuration::new(self.model, self.solids, points, &still, 0.0);
        let to = Configuration::new(self.model, self.solids, points, &velocities, self.times.lookahead);
        let reach = BARRIER_REACH_CELLS * self.model.grid.dx;
        let meetings = CandidatePairs::sdf_pairs_along(Sweep { from: &from, to: &to }, reach);
        let free = |k: usize| self.model.solids[k].kind.is_free_rigid();
        let contact = |m: &SdfPair| {
            let owner = &points.owners[m.point() as usize];
            let PointOwner::Rigid { solid, .. } = *owner else { return None };
            let x = from.position(owner);
            let distance = m.distance(&from, &x);
            let (other, normal) = match *m {
                SdfPair::Rigid(_, other, part) => (Some(other), from.rigid_normal(other, part, &x)),
                SdfPair::Side(_, side) => (None, points.domain_sides[side].normal),
            };
            let radius = points.surface.radius(m.point());
            let gap =
                distance - points.thickness(m) - points.surface.activation_distance(m.point()).min(reach);
            let at = x - normal * (0.5 * (distance + radius));
            let tangential_impulse = Vector::zeros();
            let mut c = RigidContact {
                pair: (solid, other),
                at,
                normal,
                gap,
                predicted_gap: gap,
                target_speed: 0.0,
                normal_impulse: 0.0,
                tangential_impulse,
            };
            c.predicted_gap += self.times.lookahead * self.relative_velocity(self.solids, &c).dot(&normal);
            (free(solid) || other.is_some_and(free)).then_some(c)
        };
        meetings.iter().filter_map(contact).collect()
    }

    /// Relative velocity of the two solids at a contact, m/s.
    fn relative_velocity(&self, solids: &[SolidState<D>], c: &RigidContact<D>) -> Vector<D> {
        let velocity = |solid: usize| solids[solid].as_rigid().velocity_at(&c.at);
        velocity(c.pair.0) - c.pair.1.map_or(Vector::zeros(), velocity)
    }

    /// Approach speed that the forces of this step add, m/s.
    fn forced_approach_speed(&self, c: &RigidContact<D>) -> f64 {
        (self.relative_velocity(self.before, c) - self.relative_velocity(&self.forced, c)).dot(&c.normal)
    }

    /// Separation speed after a bounce. The impact acts slightly early, and velocities are half a step ahead of positions. The work of
    /// the forces on the way to the surface and back is therefore included, so that a ball rises as high as its restitution implies.
    fn rebound_speed(&self, c: &RigidContact<D>, approach: f64, together: f64) -> f64 {
        let restitution = self.combined_coefficient(c, |s| s.restitution);
        let pull = together / self.times.impulse_time;
        let (lead, fall) = (0.5 * pull * self.times.dt, 2.0 * pull * c.gap.max(0.0));
        let touching = (approach - lead).powi(2) + fall;
        (restitution * restitution * touching - fall).max(0.0).sqrt() - lead
    }

    /// Solves one round of impacts; returns the work of solids with prescribed motion. If the round would increase the energy, as several
    /// contacts with friction can, it is undone and none of them bounces.
    fn round(&mut self, mut hits: Vec<RigidContact<D>>, record: &mut Repairs) -> Option<f64> {
        let (start, energy) = (self.solids.to_vec(), self.energy());
        record.contact_sweeps += u64::from(!self.gauss_seidel(&mut hits));
        let (mut work, mut driven) = (0.0, false);
        for c in &hits {
            let impulse = c.normal * c.normal_impulse + c.tangential_impulse;
            for (k, sign) in [(Some(c.pair.0), -1.0), (c.pair.1, 1.0)] {
                let Some(k) = k.filter(|k| self.inverse_masses[*k].0 == 0.0) else { continue };
                work += sign * self.solids[k].as_rigid().velocity_at(&c.at).dot(&impulse);
                driven |= matches!(self.model.solids[k].kind, SolidKind::Prescribed(_));
            }
        }
        if driven || self.energy() <= energy * (1.0 + 1e-12) {
            return Some(work);
        }
        self.solids.clone_from_slice(&start);
        record.stopped_bounces += 1;
        None
    }

    fn energy(&self) -> f64 {
        let free = self.model.solids.iter().zip(&*self.solids).filter(|(s, _)| s.kind.is_free_rigid());
        free.map(|(s, now)| s.kinetic_energy(now)).sum()
    }

    /// Gauss–Seidel iteration. Returns whether it converged.
    fn gauss_seidel(&mut self, hits: &mut [RigidContact<D>]) -> bool {
        let of = |c: &RigidContact<D>, i: usize| self.solids[i].as_rigid().velocity_at(&c.at).norm();
        let fastest = |c: &RigidContact<D>| {
            c.pair.1.map_or(c.target_speed, |j| of(c, j).max(c.target_speed)).max(of(c, c.pair.0))
        };
        let scale = hits.iter().map(fastest).fold(0.0, f64::max);
        for sweep in 0..2 * MAX_SWEEPS {
            let mut change = 0.0f64;
            for n in 0..hits.len() {
                let k = if sweep % 2 == 0 { n } else { hits.len() - 1 - n };
                change = change.max(self.relax(&mut hits[k]));
            }
            if change <= SWEEP_TOLERANCE * scale {
                return true;
            }
        }
        false
    }

    /// Updates the impulses of one contact. Returns the change of its speed.
    fn relax(&mut self, c: &mut RigidContact<D>) -> f64 {
        let friction = self.combined_coefficient(c, |s| s.friction);
        let miss = c.target_speed - self.relative_velocity(self.solids, c).dot(&c.normal);
        let push = (c.normal_impulse + miss / self.inverse_effective_mass(c, &c.normal)).max(0.0);
        let pushed = c.normal * (push - c.normal_impulse);
        self.apply_impulse(c, &pushed);
        let speed = self.relative_velocity(self.solids, c);
        let across = speed - c.normal * speed.dot(&c.normal);
        let stop =
            across.try_normalize(0.0).map_or(across, |along| across / self.inverse_effective_mass(c, &along));
        let rub = (c.tangential_impulse - stop).cap_magnitude(friction * push);
        let rubbed = rub - c.tangential_impulse;
        self.apply_impulse(c, &rubbed);
        (c.normal_impulse, c.tangential_impulse) = (push, rub);
        let impulse = pushed + rubbed;
        impulse.try_normalize(0.0).map_or(0.0, |n| impulse.norm() * self.inverse_effective_mass(c, &n))
    }

    /// Change of the separation speed per impulse along a direction, 1/kg.
    fn inverse_effective_mass(&self, c: &RigidContact<D>, along: &Vector<D>) -> f64 {
        let of = |i: usize| {
            let turning = moment(&(c.at - self.solids[i].center_of_mass()), along);
            self.inverse_masses[i].0 + turning.dot(&(self.inverse_masses[i].1 * turning))
        };
        of(c.pair.0) + c.pair.1.map_or(0.0, of)
    }

    /// Adds an impulse to the first solid and subtracts it from the second.
    fn apply_impulse(&mut self, c: &RigidContact<D>, impulse: &Vector<D>) {
        let sides = [Some((c.pair.0, 1.0)), c.pair.1.map(|j| (j, -1.0))];
        for (i, sign) in sides.into_iter().flatten() {
            let (lightness, turn) = &self.inverse_masses[i];
            let Some(now) = self.solids[i].rigid_mut() else { continue };
            now.velocity += impulse * (sign * lightness);
            let spun = turn * moment(&(c.at - now.center), impulse) * sign;
            (0..3).for_each(|a| now.angular_velocity[a] += spun[a]);
        }
    }

    /// Coefficient of a pair: the geometric mean of the two solids'; at a side of the domain that of the solid.
    fn combined_coefficient(&self, c: &RigidContact<D>, of: impl Fn(&Solid<D>) -> f64) -> f64 {
        let first = of(&self.model.solids[c.pair.0]);
        (first * c.pair.1.map_or(first, |j| of(&self.model.solids[j]))).sqrt()
    }
}

/// Reduces the contacts of a pair to a few equivalent ones: for each face the one with the smallest predicted gap, then repeatedly the
/// one farthest from those kept.
fn reduce_contacts<const D: usize>(mut all: Vec<RigidContact<D>>) -> Vec<RigidContact<D>> {
    let mut kept: Vec<RigidContact<D>> = Vec::new();
    while let Some(first) = all.iter().min_by(|a, b| a.predicted_gap.total_cmp(&b.predicted_gap)).cloned() {
        let (group, rest): (Vec<_>, Vec<_>) =
            all.into_iter().partition(|c| c.ordered_normal().dot(&first.ordered_normal()) > SAME_FACE_COSINE);
        all = rest;
        let mut away: Vec<f64> = group.iter().map(|c| (c.at - first.at).norm_squared()).collect();
        kept.push(first);
        for _ in 1..1 << D {
            let far = away.iter().copied().enumerate().max_by(|a, b| a.1.total_cmp(&b.1));
            let Some((far, _)) = far.filter(|(_, distance)| *distance > 0.0) else { break };
            kept.push(group[far].clone());
            let at = group[far].at;
            group.iter().zip(&mut away).for_each(|(c, d)| *d = d.min((c.at - at).norm_squared()));
        }
    }
    kept
}
