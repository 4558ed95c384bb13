//! Section 4.2: the solids between coupled solves.
//!
//! ```text
//! (M_s − Δt D_s) v_s^{n+1} = M_s v_s^n + Δt f(q_s^n) + Δt M_s g                                   Eq. 7, with E5
//! ```
//!
//! Elasticity and gravity act explicitly ([`explicit_velocities`]); damping is in the matrix of the coupled system
//! ([`SolidUnknowns::implicit_forces`](super::coupling::solids::SolidUnknowns::implicit_forces)).
//!
//! Limit: explicit elasticity is stable up to `Δt ω = √2` of the highest vibration in the scheme of Section 6. With
//! [`implicit_elasticity`](super::Errata::implicit_elasticity) (E27) the change of the elastic forces by the new velocity is in that matrix,
//! too. A vibration of frequency `ω` then shrinks by `1/(1 + ½ (Δt ω)²)` a step.

use crate::model::Model;
use crate::solid::{SolidKind, SolidState, Solids};
use meniscus_numerics::Vector;

/// Velocities of the nodes of each solid after the explicit forces of its present positions have acted for `dt` (s), m/s (angular ones
/// rad/s); those of prescribed nodes are as they are.
pub fn explicit_velocities<const D: usize>(solids: Solids<'_, D>, dt: f64) -> Vec<Vec<Vector<D>>> {
    let gravity = solids.model.gravity;
    let of = |solid: crate::SolidView<'_, D>| {
        let mut nodes = solid.state.node_velocities();
        let forces = match (solid.elastic(), solid.state.as_deformable()) {
            (Some(elastic), Some(body)) => elastic.forces(&body.vertices.positions),
            _ => Vec::new(),
        };
        let is_rigid = solid.elastic().is_none();
        let masses = solid.node_masses(solid.state);
        let prescribed = solid.prescribed_nodes();
        for (node, v) in nodes.iter_mut().enumerate().filter(|(node, _)| !prescribed[*node]) {
            if !(is_rigid && node == 1) {
                let elastic = forces.get(node).map_or(Vector::zeros(), |force| force / masses[node]);
                *v += (gravity + elastic) * dt;
            }
        }
        nodes
    };
    solids.iter().map(of).collect()
}

/// Sets the velocities of what moves as prescribed to those of a step of `dt` (s) from `time` (s).
pub fn set_prescribed_velocities<const D: usize>(
    model: &Model<D>,
    states: &mut [SolidState<D>],
    time: f64,
    dt: f64,
) {
    for (solid, now) in model.solids.iter().zip(states) {
        if let (Some(elastic), Some(body)) = (solid.elastic(), now.deformable_mut()) {
            for (v, velocity) in elastic.anchored_velocities(body.vertices.time, dt) {
                body.vertices.velocities[v] = velocity;
            }
        } else if let (SolidKind::Prescribed(path), Some(rigid)) = (&solid.kind, now.rigid_mut()) {
            rigid.velocity = path.mean_velocity(time + dt, dt);
            rigid.angular_velocity = path.angular_velocity;
        }
    }
}
