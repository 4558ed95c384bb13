//! Each solid's own term of a step's potential, and the loads on deformable solids.

use super::incremental_potential::{RigidTerm, SolidTerm};
use crate::coupling::impulses::CouplingImpulses;
use crate::model::Model;
use crate::model::time_step::StepTimes;
use crate::solid::{RigidKinematics, Solid, SolidState, angular_to_node};
use meniscus_elastic::{Elastic, ElasticState, IncrementalPotential, StiffnessBlock};
use meniscus_numerics::{Matrix, Vector};

/// Loads on a deformable solid in a step.
pub struct DeformableLoads<const D: usize> {
    /// Impulses of all forces but the pressure on its vertices, N s.
    impulses: Vec<Vector<D>>,
    /// Stiffness of forces other than the elastic ones.
    extra_stiffness: Vec<StiffnessBlock<D>>,
}

impl<const D: usize> DeformableLoads<D> {
    /// Loads on all solids. `line` holds the impulses of contact lines in the time `impulse_time` (s).
    pub fn of_solids(
        model: &Model<D>,
        line: &CouplingImpulses<D>,
        extra_stiffness: Vec<Vec<StiffnessBlock<D>>>,
        impulse_time: f64,
    ) -> Vec<Option<Self>> {
        let start = |(k, extra_stiffness): (usize, Vec<StiffnessBlock<D>>)| {
            let elastic = model.solids[k].elastic()?;
            let mut impulses: Vec<Vector<D>> =
                elastic.masses().iter().map(|m| model.gravity * (m * impulse_time)).collect();
            line.point_impulses
                .get(&(k as u32))
                .iter()
                .for_each(|grips| crate::solid::surface::distribute_to_vertices(grips, &mut impulses));
            Some(Self { impulses, extra_stiffness })
        };
        extra_stiffness.into_iter().enumerate().map(start).collect()
    }
}

/// The terms of all solids, which are in the state `before` when the forces act. `forced` holds the velocities of rigid solids after all
/// forces but pressure and contacts.
pub fn solid_terms<'a, const D: usize>(
    model: &'a Model<D>,
    before: &'a [SolidState<D>],
    forced: &[SolidState<D>],
    loads: &'a [Option<DeformableLoads<D>>],
    times: StepTimes,
) -> Vec<SolidTerm<'a, D>> {
    let term = |k: usize| {
        let (solid, before) = (&model.solids[k], &before[k]);
        if let (Some(elastic), Some(body), Some(loads)) = (solid.elastic(), before.as_deformable(), &loads[k])
        {
            return SolidTerm::Deformable(deformable_term(elastic, &body.vertices, loads, times));
        }
        match before.rigid().filter(|_| solid.kind.is_free_rigid()) {
            Some(rigid) => SolidTerm::Rigid(rigid_term(solid, rigid, &forced[k].as_rigid())),
            None => SolidTerm::Prescribed,
        }
    };
    (0..model.solids.len()).map(term).collect()
}

/// The term of a deformable solid under these loads; its lagged parts are not evaluated yet.
fn deformable_term<'a, const D: usize>(
    elastic: &'a Elastic<D>,
    state: &'a ElasticState<D>,
    loads: &'a DeformableLoads<D>,
    times: StepTimes,
) -> IncrementalPotential<'a, D> {
    // Initial velocities that disagree with the anchors decay with the full lead; the centred scheme would reverse them.
    let has_anchors = times.is_first && elastic.anchored().contains(&true);
    IncrementalPotential {
        elastic,
        state,
        viscosity_positions: state.positions.clone(),
        discrete_gradient_correction: vec![Vector::zeros(); loads.impulses.len()],
        extra_stiffness: &loads.extra_stiffness,
        impulses: &loads.impulses,
        impulse_time: times.impulse_time,
        velocity_lead: if has_anchors { times.impulse_time } else { times.velocity_lead },
        lookahead: times.lookahead,
    }
}

/// The term of a free rigid solid, which is least at the velocities of `forced`.
fn rigid_term<const D: usize>(
    solid: &Solid<D>,
    before: &RigidKinematics<D>,
    forced: &RigidKinematics<D>,
) -> RigidTerm<D> {
    let inertia = solid.inertia(before);
    RigidTerm {
        mass: solid.mass_properties.mass,
        inertia: Matrix::<D>::from_fn(|r, c| match D {
            2 if r == 0 && c == 0 => inertia[(2, 2)],
            2 => f64::from(u8::from(r == c)),
            _ => inertia[(r, c)],
        }),
        target_velocities: [forced.velocity, angular_to_node(&forced.angular_velocity)],
    }
}
