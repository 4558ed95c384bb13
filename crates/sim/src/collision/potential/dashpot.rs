//! Damping of contacts between rigid solids.
//!
//! The barrier alone does not dissipate, so a rigid solid would oscillate on another one forever. The oscillating normal force would make
//! friction intermittent: resting solids would creep, and slowly sliding ones slide too far. Each barrier `B` between rigid solids
//! therefore has a parallel dashpot that acts on approach and never pulls (one-sided Kelvin–Voigt; spring-dashpot contact of P. A.
//! Cundall, O. D. L. Strack 1979, with a non-negative normal force):
//!
//! ```text
//! h ½ c min(v_n, 0)²,   c = (τ − a) B''(d)
//! ```
//!
//! Here `v_n` is the separation velocity, `d` the distance at the start of the coming step, and `h` the impulse time. The barrier at the
//! end of that step, after `a`, itself damps as `a B''`. With `τ = 2 √(m/k)` the damping of a solid that rests on one side is critical.
//! Limit: bounces ([`crate::collision::impact`]) are unaffected only outside the barrier's activation distance.

use super::barrier::SdfContact;
use super::incremental_potential::{Potential, SolidTerm};
use super::term::{PotentialTerm, distance_derivatives};
use crate::collision::configuration::NodeJacobian;
use crate::collision::points::{PointOwner, SdfPair};
use meniscus_numerics::Vector;

/// A dashpot between a point of a rigid solid and another rigid solid or side.
struct Dashpot<const D: usize> {
    /// Jacobians of both points at the start of the coming step.
    node_jacobians: Vec<Vec<NodeJacobian<D>>>,
    /// Direction from the other feature to the point.
    normal: Vector<D>,
    /// `c`, kg/s (2D: kg/(m s)).
    coefficient: f64,
}

impl<const D: usize> Dashpot<D> {
    /// Approach speed, m/s; 0 on separation.
    fn approach_speed(&self, velocities: &[Vector<D>]) -> f64 {
        let of = |levers: &Vec<NodeJacobian<D>>| {
            levers.iter().map(|(node, by)| by * velocities[*node]).sum::<Vector<D>>()
        };
        let apart = self.node_jacobians.iter().zip([1.0, -1.0]).map(|(levers, sign)| of(levers) * sign);
        (-self.normal.dot(&apart.sum::<Vector<D>>())).max(0.0)
    }
}

impl<const D: usize> Potential<'_, D> {
    /// Settling time `τ` of the slowest free rigid solid, s, at least the length of the coming step. `m` is its mass, `k` the barrier's
    /// tangent stiffness at half the activation distance under one of the `2 D` sides of its surface.
    pub fn settling_time(&self) -> f64 {
        let [_, _, bend] = self.barrier.derivatives_by_distance(0.5 * self.barrier.activation_distance);
        let of = |(k, part): (usize, &SolidTerm<'_, D>)| match part {
            SolidTerm::Rigid(rigid) if self.points.mean_side_areas[k] > 0.0 => {
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
        if excess <= 0.0 || !matches!(owner, PointOwner::Rigid { .. }) {
            return None;
        }
        let start = &self.old_levels.start;
        let SdfContact { point, distance, normal, other } = self.sdf_contact(meeting, start)?;
        let [_, _, bend] = self.point_barrier(point).derivatives_by_distance(distance);
        let coefficient = excess * self.barrier_force_scale(meeting) * bend;
        let node_jacobians = [Some(*owner), other]
            .into_iter()
            .flatten()
            .map(|o| start.configuration.node_jacobians(&o))
            .collect();
        Some(Dashpot { node_jacobians, normal, coefficient })
    }

    /// Force of the dashpot of a pair, N (2D: N/m).
    pub fn damping_force(&self, meeting: &SdfPair, velocities: &[Vector<D>]) -> f64 {
        self.dashpot(meeting).map_or(0.0, |dashpot| dashpot.coefficient * dashpot.approach_speed(velocities))
    }

    /// Dissipation potential of all dashpots over `h`, W (2D: W/m).
    pub fn dissipation(&self, velocities: &[Vector<D>], meetings: &[SdfPair]) -> f64 {
        let of = |m: &SdfPair| {
            self.dashpot(m)
                .map_or(0.0, |dashpot| 0.5 * dashpot.coefficient * dashpot.approach_speed(velocities).powi(2))
        };
        meetings.iter().map(of).sum()
    }

    /// Terms of all dashpots.
    pub fn damping_terms(&self, velocities: &[Vector<D>], meetings: &[SdfPair]) -> Vec<PotentialTerm<D>> {
        let of = |m: &SdfPair| {
            let dashpot = self.dashpot(m)?;
            let approach = dashpot.approach_speed(velocities);
            let Dashpot { node_jacobians, normal, coefficient } = dashpot;
            let (slope, bend) = (-coefficient * approach, if approach > 0.0 { coefficient } else { 0.0 });
            // Velocities are displacements after one second.
            Some(PotentialTerm {
                derivatives: distance_derivatives(&normal, node_jacobians.len(), slope, bend),
                node_jacobians,
                time: 1.0,
            })
        };
        meetings.iter().filter_map(of).collect()
    }
}
