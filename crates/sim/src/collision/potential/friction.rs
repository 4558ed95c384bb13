//! Friction contacts of a step, and the elastic slips that are carried from step to step.

use super::barrier::SdfContact;
use super::incremental_potential::Potential;
use super::slips::{ContactKey, FrictionContact, Slip, Slips, friction_law};
use super::time_levels::BarrierLevel;
use crate::collision::broad_phase::CandidatePairs;
use crate::collision::configuration::Configuration;
use crate::collision::points::{PointOwner, SdfPair};
use meniscus_contact::{FrictionPair, Stencil, StencilKind};
use meniscus_numerics::Vector;
use std::collections::BTreeMap;

impl<const D: usize> Potential<'_, D> {
    /// Friction contacts with the normal forces at these velocities.
    pub fn friction_contacts(
        &self,
        velocities: &[Vector<D>],
        candidates: &CandidatePairs,
    ) -> Vec<FrictionContact<D>> {
        let moments = self.time_levels(velocities);
        let from = &self.old_levels.start.configuration;
        let mut rubs = Vec::new();
        for felt in moments.barrier_levels() {
            rubs.extend(self.mesh_friction(from, &felt, candidates));
            let met = |m| self.sdf_friction(from, &felt, m, self.damping_force(m, velocities));
            rubs.extend(candidates.sdf_pairs.iter().filter_map(met));
        }
        let (friction, mut holds) = (friction_law(self.model), BTreeMap::<ContactKey, f64>::new());
        rubs.iter().for_each(|r| *holds.entry(r.key).or_default() += r.rubbing.friction_limit);
        for r in &mut rubs {
            let Some(slip) = self.elastic_slips.get(&r.key) else { continue };
            r.rubbing.slip = friction.rescaled_slip(&slip.displacement, slip.friction_limit, holds[&r.key]);
        }
        rubs
    }

    /// Elastic slips at the start of the next step, with these velocities.
    pub fn next_slips(&self, velocities: &[Vector<D>]) -> Slips<D> {
        let places = self.configuration(velocities);
        // Sums over each contact: the friction limit, and the normal and the rate weighted by it.
        let mut sums: BTreeMap<ContactKey, (Slip<D>, Vector<D>)> = BTreeMap::new();
        for r in &self.friction_contacts {
            let to = r.owners.map(|o| places.position(&o));
            let FrictionPair { friction_limit, normal, slip, .. } = r.rubbing;
            let none =
                || (Slip { displacement: slip, rate: Vector::zeros(), friction_limit: 0.0 }, Vector::zeros());
            let (sum, normals) = sums.entry(r.key).or_insert_with(none);
            sum.friction_limit += friction_limit;
            sum.rate += r.rubbing.tangential_displacement(&r.start_positions, &to)
                * (friction_limit / self.lookahead);
            *normals += normal * friction_limit;
        }
        let mean = |(touch, (sum, normals)): (ContactKey, (Slip<D>, Vector<D>))| {
            let normal = normals.try_normalize(0.0).unwrap_or(Vector::zeros());
            let along = |way: Vector<D>| way - normal * way.dot(&normal);
            (
                touch,
                Slip {
                    displacement: along(sum.displacement),
                    rate: along(sum.rate / sum.friction_limit),
                    friction_limit: sum.friction_limit,
                },
            )
        };
        sums.into_iter().map(mean).collect()
    }

    /// Friction coefficient of two solids, the geometric mean of both, or of a solid and a side.
    fn friction_coefficient(&self, first: usize, second: Option<usize>) -> f64 {
        let of = |k: usize| self.model.solids[k].friction;
        second.map_or(of(first), |second| (of(first) * of(second)).sqrt())
    }

    /// Friction of point–facet and edge–edge contacts.
    fn mesh_friction(
        &self,
        from: &Configuration<'_, D>,
        felt: &BarrierLevel<'_, D>,
        candidates: &CandidatePairs,
    ) -> Vec<FrictionContact<D>> {
        let now = felt.time_level();
        let owners = &self.points.owners;
        let mut rubs = Vec::new();
        for c in self.active_contacts(candidates, felt) {
            let points = c.stencil.points();
            let ends = [points[0], points[c.stencil.kind.first_count() - 1]];
            let (first, second) =
                (owners[points[0] as usize], owners[points[c.stencil.kind.first_count()] as usize]);
            let coefficient = self.friction_coefficient(first.solid(), Some(second.solid()));
            let Some(rubbing) = FrictionPair::new(&c, coefficient, now.positions()) else { continue };
            let mut own = [first; 4];
            own.iter_mut().zip(points).for_each(|(o, p)| *o = owners[*p as usize]);
            if let PointOwner::Rigid { solid, .. } = first {
                // Both solids receive the force at one point, on the facet.
                let on: Vector<D> = points
                    .iter()
                    .zip(rubbing.weights)
                    .skip(1)
                    .map(|(p, w)| now.positions()[*p as usize] * -w)
                    .sum();
                own[0] = PointOwner::Rigid { solid, at: now.configuration.to_reference(solid, &on) };
            }
            let mut stencil = c.stencil;
            stencil.points = [0, 1, 2, 3];
            rubs.push(FrictionContact {
                key: ContactKey { points: ends, other: second.solid() as u32 },
                owners: own,
                start_positions: own.map(|o| from.position(&o)),
                rubbing: FrictionPair { stencil, ..rubbing },
            });
        }
        rubs
    }

    /// Friction of a point with a rigid solid or side; `damped` is the force of the pair's dashpot.
    fn sdf_friction(
        &self,
        from: &Configuration<'_, D>,
        felt: &BarrierLevel<'_, D>,
        meeting: &SdfPair,
        damped: f64,
    ) -> Option<FrictionContact<D>> {
        let now = felt.time_level();
        let SdfContact { point, distance, normal, other } = self.active_sdf_contact(meeting, felt)?;
        let owner = self.points.owners[point as usize];
        let (solid, other) = (owner.solid(), other.map(|o| o.solid()));
        let slope = self.point_barrier(point).derivatives_by_distance(distance)[1];
        let force = damped - self.barrier_force_scale(meeting) * slope;
        let friction_limit = self.friction_coefficient(solid, other) * force;
        if friction_limit <= 0.0 {
            return None;
        }
        let place = self.friction_point(meeting, now.positions()[point as usize], distance, normal);
        let at_place = |solid| PointOwner::Rigid { solid, at: now.configuration.to_reference(solid, &place) };
        let mut owners = [owner; 4];
        if let PointOwner::Rigid { .. } = owner {
            owners = [at_place(solid); 4];
        }
        other.iter().for_each(|o| owners[1] = at_place(*o));
        // A side does not move.
        let weights = if other.is_some() { [1.0, -1.0, 0.0, 0.0] } else { [1.0, 0.0, 0.0, 0.0] };
        let stencil = Stencil { kind: StencilKind::PointSegment, points: [0, 1, 2, 3] };
        let number = match *meeting {
            SdfPair::Rigid(_, other, _) => other,
            SdfPair::Side(_, side) => self.model.solids.len() + side,
        };
        Some(FrictionContact {
            key: ContactKey { points: [point; 2], other: number as u32 },
            owners,
            start_positions: owners.map(|o| from.position(&o)),
            rubbing: FrictionPair { stencil, weights, normal, friction_limit, slip: Vector::zeros() },
        })
    }

    /// Point where friction acts between a point at `x` and a rigid solid or side: midway between the two surfaces, so that both receive
    /// the force at one point. At a vertex of a deformable solid it is the vertex.
    fn friction_point(&self, meeting: &SdfPair, x: Vector<D>, distance: f64, normal: Vector<D>) -> Vector<D> {
        let point = meeting.point();
        match self.points.owners[point as usize] {
            PointOwner::Vertex { .. } | PointOwner::FacetCenter { .. } => x,
            PointOwner::Rigid { .. } => {
                let (radius, thickness) = (self.points.surface.radius(point), self.points.thickness(meeting));
                x - normal * (0.5 * (distance + thickness + radius))
            }
        }
    }
}
