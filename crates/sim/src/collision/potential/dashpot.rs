//! Damping of contacts between rigid solids.
//!
//! A rigid solid has no dissipation of its own in which it would come to rest on another one: on the barrier alone it swings for ever, and
//! as a contact that swings holds friction's force in turns, what should stay creeps and what should slide slowly slides too far. So the
//! barrier `B` of a pair of rigid solids has a dashpot beside it, which acts while they approach and never pulls (one-sided Kelvin–Voigt;
//! the spring-dashpot contact of P. A. Cundall, O. D. L. Strack 1979, with the normal force not below zero):
//!
//! ```text
//! h ½ c min(v_n, 0)²,   c = (τ − a) B''(d)
//! ```
//!
//! with the velocity `v_n` with which they part, the distance `d` where the step starts, and the time `h` for which forces act. The
//! barrier at the end of the coming step, after `a`, damps as `a B''` does by itself; with `τ = 2 √(m/k)` the damping of a solid that rests
//! on one side is critical. Limit: bounces are events ([`crate::collision::impact`]), which this leaves alone only outside the barrier's reach.

use super::barrier::SdfContact;
use super::incremental_potential::{Potential, SolidTerm};
use super::term::{PotentialTerm, distance_derivatives};
use crate::collision::configuration::NodeJacobian;
use crate::collision::points::{PointOwner, SdfPair};
use meniscus_numerics::Vector;

/// A dashpot between a point of a rigid solid and what it meets.
struct Dashpot<const D: usize> {
    /// How velocities of nodes move both where the step starts.
    node_jacobians: Vec<Vec<NodeJacobian<D>>>,
    /// Direction away from the other.
    normal: Vector<D>,
    /// `c`, kg/s (2D: kg/(m s)).
    coefficient: f64,
}

impl<const D: usize> Dashpot<D> {
    /// The velocity with which both approach, m/s; none below 0.
    fn approach_speed(&self, velocities: &[Vector<D>]) -> f64 {
        let of = |levers: &Vec<NodeJacobian<D>>| {
            levers.iter().map(|(node, by)| by * velocities[*node]).sum::<Vector<D>>()
        };
        let apart = self.node_jacobians.iter().zip([1.0, -1.0]).map(|(levers, sign)| of(levers) * sign);
        (-self.normal.dot(&apart.sum::<Vector<D>>())).max(0.0)
    }
}

impl<const D: usize> Potential<'_, D> {
    /// `τ` of the slowest free rigid solid, s: `m` is its mass, `k` the stiffness around half the reach of the barrier under one of the
    /// `2 D` sides of its surface. At least the length of the coming step.
    pub fn settling_time(&self) -> f64 {
        let [_, _, bend] = self.barrier.derivatives_by_distance(0.5 * self.barrier.activation_distance);
        let of = |(k, part): (usize, &SolidTerm<'_, D>)| match part {
            SolidTerm::Free(rigid) if self.points.mean_side_areas[k] > 0.0 => {
                2.0 * (rigid.mass / (bend * self.points.mean_side_areas[k] * self.barrier_stiffness(k, None)))
                    .sqrt()
            }
            _ => 0.0,
        };
        self.parts.iter().enumerate().map(of).fold(self.lookahead, f64::max)
    }

    fn dashpot(&self, meeting: &SdfPair) -> Option<Dashpot<D>> {
        let owner = &self.points.owners[meeting.point() as usize];
        let excess = self.settling_time - self.lookahead;
        if excess <= 0.0 || matches!(owner, PointOwner::Vertex { .. }) {
            return None;
        }
        let start = &self.old_levels.start;
        let SdfContact { point, distance, normal, other } =
            self.sdf_contact(meeting, &start.configuration, &start.positions)?;
        let [_, _, bend] = self.point_barrier(point).derivatives_by_distance(distance);
        let coefficient = excess * self.barrier_force_scale(meeting) * bend;
        let node_jacobians = [Some(*owner), other]
            .into_iter()
            .flatten()
            .map(|o| start.configuration.node_jacobians(&o))
            .collect();
        Some(Dashpot { node_jacobians, normal, coefficient })
    }

    /// The force of the dashpot of a pair, N (2D: N/m).
    pub fn damping_force(&self, meeting: &SdfPair, velocities: &[Vector<D>]) -> f64 {
        self.dashpot(meeting).map_or(0.0, |dashpot| dashpot.coefficient * dashpot.approach_speed(velocities))
    }

    /// The dissipation potential of all dashpots over `h`, W (2D: W/m).
    pub fn dissipation(&self, velocities: &[Vector<D>], meetings: &[SdfPair]) -> f64 {
        let of = |m: &SdfPair| {
            self.dashpot(m)
                .map_or(0.0, |dashpot| 0.5 * dashpot.coefficient * dashpot.approach_speed(velocities).powi(2))
        };
        meetings.iter().map(of).sum()
    }

    /// The terms of all dashpots.
    pub fn damping_terms(&self, velocities: &[Vector<D>], meetings: &[SdfPair]) -> Vec<PotentialTerm<D>> {
        let of = |m: &SdfPair| {
            let dashpot = self.dashpot(m)?;
            let approach = dashpot.approach_speed(velocities);
            let Dashpot { node_jacobians, normal, coefficient } = dashpot;
            let (slope, bend) = (-coefficient * approach, if approach > 0.0 { coefficient } else { 0.0 });
            // Velocities are the places after a second.
            Some(PotentialTerm {
                derivatives: distance_derivatives(&normal, node_jacobians.len(), slope, bend),
                node_jacobians,
                time: 1.0,
            })
        };
        meetings.iter().filter_map(of).collect()
    }
}
