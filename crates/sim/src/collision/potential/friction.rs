//! What rubs in a step, and the elastic slips of friction that are carried from step to step.

use super::barrier::Met;
use super::moments::{Felt, Moment};
use super::slips::{Rub, Slip, Slips, Touch, friction};
use super::total::Potential;
use crate::collision::broad_phase::Candidates;
use crate::collision::places::Places;
use crate::collision::points::{Meeting, Owner};
use meniscus_contact::{Kind, Rubbing, Stencil};
use meniscus_numerics::Vector;
use std::collections::BTreeMap;

impl<const D: usize> Potential<'_, D> {
    /// What rubs with these velocities.
    pub fn rubbing(&self, velocities: &[Vector<D>], candidates: &Candidates) -> Vec<Rub<D>> {
        let moments = self.moments(velocities);
        let from = &self.past.start.places;
        let mut rubs = Vec::new();
        for felt in moments.felt() {
            rubs.extend(self.rubbing_facets(from, &felt, candidates));
            let met = |m| self.rubbing_met(from, &felt, m, self.damped(m, velocities));
            rubs.extend(candidates.meetings.iter().filter_map(met));
        }
        let (friction, mut holds) = (friction(self.model), BTreeMap::<Touch, f64>::new());
        rubs.iter().for_each(|r| *holds.entry(r.touch).or_default() += r.rubbing.hold);
        for r in &mut rubs {
            let Some(slip) = self.slips.get(&r.touch) else { continue };
            r.rubbing.slip = friction.carried(&slip.way, slip.hold, holds[&r.touch]);
        }
        rubs
    }

    /// The slips that the next step starts from, with these velocities.
    pub fn next_slips(&self, velocities: &[Vector<D>]) -> Slips<D> {
        let places = self.places(velocities);
        // Sums over what is one contact: the hold, and the normal and the rate times the hold.
        let mut sums: BTreeMap<Touch, (Slip<D>, Vector<D>)> = BTreeMap::new();
        for r in &self.rubs {
            let to = r.owners.map(|o| places.at(&o));
            let Rubbing { hold, normal, slip, .. } = r.rubbing;
            let none = || (Slip { way: slip, rate: Vector::zeros(), hold: 0.0 }, Vector::zeros());
            let (sum, normals) = sums.entry(r.touch).or_insert_with(none);
            sum.hold += hold;
            sum.rate += r.rubbing.way(&r.from, &to) * (hold / self.ahead);
            *normals += normal * hold;
        }
        let mean = |(touch, (sum, normals)): (Touch, (Slip<D>, Vector<D>))| {
            let normal = normals.try_normalize(0.0).unwrap_or(Vector::zeros());
            let along = |way: Vector<D>| way - normal * way.dot(&normal);
            (touch, Slip { way: along(sum.way), rate: along(sum.rate / sum.hold), hold: sum.hold })
        };
        sums.into_iter().map(mean).collect()
    }

    /// The coefficient of friction of a solid and another, the geometric mean of both, or a side.
    fn coefficient(&self, first: usize, second: Option<usize>) -> f64 {
        let of = |k: usize| self.model.solids[k].friction;
        second.map_or(of(first), |second| (of(first) * of(second)).sqrt())
    }

    /// Points and facets, edges and edges that rub.
    fn rubbing_facets(
        &self,
        from: &Places<'_, D>,
        felt: &Felt<'_, D>,
        candidates: &Candidates,
    ) -> Vec<Rub<D>> {
        let Moment { places, at } = felt.now();
        let owners = &self.points.owners;
        let mut rubs = Vec::new();
        for c in self.felt_contacts(candidates, felt) {
            let points = c.stencil.points();
            let ends = [points[0], points[c.stencil.kind.first() - 1]];
            let (first, second) =
                (owners[points[0] as usize], owners[points[c.stencil.kind.first()] as usize]);
            let coefficient = self.coefficient(first.solid(), Some(second.solid()));
            let Some(rubbing) = Rubbing::new(&c, coefficient, at) else { continue };
            let mut own = [first; 4];
            own.iter_mut().zip(points).for_each(|(o, p)| *o = owners[*p as usize]);
            if let Owner::Rigid { solid, .. } = first {
                // Both get it at one place, that on the facet.
                let on: Vector<D> =
                    points.iter().zip(rubbing.weights).skip(1).map(|(p, w)| at[*p as usize] * -w).sum();
                own[0] = Owner::Rigid { solid, at: places.at_start(solid, &on) };
            }
            let mut stencil = c.stencil;
            stencil.points = [0, 1, 2, 3];
            rubs.push(Rub {
                touch: Touch { points: ends, other: second.solid() as u32 },
                owners: own,
                from: own.map(|o| from.at(&o)),
                rubbing: Rubbing { stencil, ..rubbing },
            });
        }
        rubs
    }

    /// A point and what has no facets, if they rub; `damped` is the force of their dashpot.
    fn rubbing_met(
        &self,
        from: &Places<'_, D>,
        felt: &Felt<'_, D>,
        meeting: &Meeting,
        damped: f64,
    ) -> Option<Rub<D>> {
        let Moment { places, at } = felt.now();
        let Met { point, distance, normal, other } = self.felt_met(meeting, felt)?;
        let owner = self.points.owners[point as usize];
        let (solid, other) = (owner.solid(), other.map(|o| o.solid()));
        let slope = self.barrier(point).of_distance(distance)[1];
        let force = damped - self.scale(meeting) * slope;
        let hold = self.coefficient(solid, other) * force;
        if hold <= 0.0 {
            return None;
        }
        let place = self.rubbing_place(meeting, at[point as usize], distance, normal);
        let at_place = |solid| Owner::Rigid { solid, at: places.at_start(solid, &place) };
        let mut owners = [owner; 4];
        if let Owner::Rigid { .. } = owner {
            owners = [at_place(solid); 4];
        }
        other.iter().for_each(|o| owners[1] = at_place(*o));
        // The other end of what rubs against a side does not move.
        let weights = if other.is_some() { [1.0, -1.0, 0.0, 0.0] } else { [1.0, 0.0, 0.0, 0.0] };
        let stencil = Stencil { kind: Kind::PointSegment, points: [0, 1, 2, 3] };
        let number = match *meeting {
            Meeting::Rigid(_, other, _) => other,
            Meeting::Side(_, side) => self.model.solids.len() + side,
        };
        Some(Rub {
            touch: Touch { points: [point; 2], other: number as u32 },
            owners,
            from: owners.map(|o| from.at(&o)),
            rubbing: Rubbing { stencil, weights, normal, hold, slip: Vector::zeros() },
        })
    }

    /// Where friction acts between a point at `x` and something without facets: midway between the two surfaces, so that both get it at
    /// one place; on a vertex of a solid that deforms at the vertex.
    fn rubbing_place(&self, meeting: &Meeting, x: Vector<D>, distance: f64, normal: Vector<D>) -> Vector<D> {
        let point = meeting.point();
        match self.points.owners[point as usize] {
            Owner::Vertex { .. } => x,
            Owner::Rigid { .. } => {
                let (radius, thickness) = (self.points.surface.radius(point), self.points.thickness(meeting));
                x - normal * (0.5 * (distance + thickness + radius))
            }
        }
    }
}
