//! One time step of the liquid and the solids.
//!
//! Positions are advanced first, then one solve gives the velocity. A capillary wave thus obeys symplectic Euler, which neither
//! damps nor amplifies it.

use super::diagnostics::{effective_surface_area, kinetic_energy, measure_components};
use super::repairs::Repairs;
use super::transport::{
    CURVATURE_LAYERS, interface_displacements, move_interface, move_velocity, restore_signed_distance,
};
use super::workspace::Workspace;
use crate::components::restoration::{restore_advected_momentum, restore_momentum, subtract_solid_impulses};
use crate::components::tracking::{ComponentChange, predict_motions, restore_volume};
use crate::contact_line::friction::{DraggedFace, LineFriction};
use crate::contact_line::hysteresis::pin_contact_lines;
use crate::coupling::solve::{PressureSolution, PressureStep, prescribed_solid_work, solve_pressure};
use crate::flow::outflow::remove_outflow;
use crate::flow::pressure::FlowSolves;
use crate::free_surface::curvature::{
    FilterStep, InterfaceDisplacement, InterfaceLayers, SolidContext, curvature,
};
use crate::free_surface::extension::ghost_cells;
use crate::free_surface::interface_faces::{InterfaceFace, interface_faces};
use crate::model::Model;
use crate::model::time_step::{
    MAX_DT_GROWTH, PhaseEnd, StepTimes, impulse_time, lookahead_time, unbounded_impulse_time,
};
use crate::solid::{SolidState, Solids};
use crate::state::State;
use meniscus_numerics::grid::Sampler;
use meniscus_numerics::linalg::SolveError;
use meniscus_numerics::par;

/// Result of a step that is not accepted yet.
pub struct StepResult {
    /// The solves, those of the last Newton iteration if there are any.
    pub solves: FlowSolves,
    /// Newton iterations for solids and pressure.
    pub newton_iterations: u64,
    /// Work done by solids of prescribed motion, J.
    pub prescribed_work: f64,
    /// Largest volume error of a component before its correction, as the thickness of a layer on a ball of its volume, in cells.
    pub volume_error_cells: f64,
}

/// Durations of a step, and the displacement of the interface in it, for [`apply_forces`].
struct ForceStep<const D: usize> {
    /// Step length, s.
    dt: f64,
    /// Time for which the forces act, s.
    impulse_time: f64,
    /// Displacements of the interface in the step.
    displacements: Vec<InterfaceDisplacement<D>>,
}

/// Advances the state by `dt` seconds.
///
/// # Errors
/// Those of the pressure solve. The state is then inconsistent and must be discarded.
pub fn step<const D: usize>(
    model: &Model<D>,
    state: &mut State<D>,
    work: &mut Workspace<D>,
    dt: f64,
    phase_end: PhaseEnd<'_>,
) -> Result<StepResult, SolveError> {
    if state.step == 0 {
        initial_half_step(model, state, work, dt, phase_end)?;
    }
    let impulse_time = limited_impulse_time(state, work, dt);

    // (0) The solids move, and with them what they leave open of faces and cells.
    let (solids_before, surfaces_before) = (state.solids.clone(), work.surfaces.clone());
    if !model.solids.is_empty() {
        move_solids(model, state, work, dt);
        phase_end("solids");
    }

    // (1) The interface moves, φ becomes a distance again, and lines that hysteresis holds stay where they are. For the interface, faces
    // that solids close in part have the velocity of the liquid around them.
    let solids_before = Solids { model, states: &solids_before, surfaces: &surfaces_before };
    work.swap_cut_face_velocities(&mut state.velocity);
    let liquid_before = move_interface(state, work, solids_before, dt);
    work.swap_cut_face_velocities(&mut state.velocity);
    phase_end("advect surface");
    restore_signed_distance(model, state, work);
    phase_end("redistance");
    pin_contact_lines(model, state, work);

    // (2) Every component has its volume again, and the centre of mass of one that touches nothing is on its path.
    let mut change = restore_volume(model, state, work, &liquid_before, dt);
    work.repairs.add(&change.repairs);
    phase_end("volume");

    // (3) The velocity moves to the faces of the new liquid, and components held by solids have their momentum again.
    let displacements = interface_displacements(model, state, work, dt);
    move_velocity(model, state, work, dt);
    let carried = restore_advected_momentum(model, state, work, &change);
    work.repairs.add(&carried);
    phase_end("advect velocity");

    // (4) Gravity, surface tension, pressure, contact and viscosity act on liquid and solids.
    let forces = ForceStep { dt, impulse_time, displacements };
    let result = apply_forces(model, state, work, &mut change, forces, phase_end)?;
    state.impulse_time = impulse_time;
    state.time += dt;
    state.step += 1;
    state.last_dt = dt;

    // (5) Liquid beyond open sides is removed.
    remove_outflow(model, state, work);
    Ok(StepResult { volume_error_cells: change.volume_error_cells, ..result })
}

/// The impulse time of a step of `dt` s; counts where its bounds change it.
fn limited_impulse_time<const D: usize>(state: &State<D>, work: &mut Workspace<D>, dt: f64) -> f64 {
    let limited = impulse_time(state.velocity_lead, dt);
    work.repairs.limited_kicks += u64::from(limited != unbounded_impulse_time(state.velocity_lead, dt));
    limited
}

/// Advances the velocity by half a step ahead of the positions, as leapfrog requires; once, before the first step.
fn initial_half_step<const D: usize>(
    model: &Model<D>,
    state: &mut State<D>,
    work: &mut Workspace<D>,
    dt: f64,
    phase_end: PhaseEnd<'_>,
) -> Result<(), SolveError> {
    pin_contact_lines(model, state, work);
    let mut change = ComponentChange::unchanged(model, state, work);
    change.target_volumes = state.components.iter().map(|d| d.target_volume).collect();
    predict_motions(model, state, work, &mut change.groups, &[], 0.0);
    let displacements = interface_displacements(model, state, work, 0.0);
    work.reset_known_faces(model);
    state.velocity_lead = dt;
    let forces = ForceStep { dt, impulse_time: 0.5 * dt, displacements };
    apply_forces(model, state, work, &mut change, forces, phase_end)?;
    state.impulse_time = 0.5 * dt;
    Ok(())
}

/// Adds the impulses of all forces to the velocities of liquid and solids; the velocity is then free of divergence, and is known
/// beyond the liquid.
fn apply_forces<const D: usize>(
    model: &Model<D>,
    state: &mut State<D>,
    work: &mut Workspace<D>,
    change: &mut ComponentChange<D>,
    forces: ForceStep<D>,
    phase_end: PhaseEnd<'_>,
) -> Result<StepResult, SolveError> {
    let (dt, impulse_time) = (forces.dt, forces.impulse_time);
    let solids_before = state.solids.clone();
    apply_gravity(model, state, work, impulse_time);
    let Interface { faces, mut dragged } = find_interface(model, state, work, change, &solids_before, forces);
    phase_end("curvature");

    // One solve for the pressure. The liquid loses the impulses that pressure and contact line give to solids.
    let times = begin_impulse(model, state, dt, impulse_time);
    let pressure_step = PressureStep {
        solids_before: &solids_before,
        interface_faces: &faces,
        dragged_faces: &mut dragged,
        times,
    };
    let PressureSolution { solves, solid_impulses, contact_work, newton_iterations } =
        solve_pressure(model, state, work, change, pressure_step, phase_end)?;
    let prescribed_work = prescribed_solid_work(model, state, &solid_impulses) + contact_work;
    subtract_solid_impulses(model, &mut change.groups, &solid_impulses);
    phase_end("pressure");

    // Momentum lost by the discretisation is restored; the velocity is extended beyond the liquid.
    let restored = restore_momentum(model, state, work, &faces, &change.momentum_targets(impulse_time));
    let slip_unknown = work.extend_velocity(model, state);
    work.repairs.add(&Repairs {
        momentum_restored: restored.momentum,
        spin_restored: restored.angular_momentum,
        unrestored: restored.unrestored,
        unlabelled: restored.unlabelled,
        slip_unknown,
        ..solid_repairs(model, state)
    });
    state.components = measure_components(model, work, &faces, &restored.moments, change);
    state.kinetic_energy = kinetic_energy(model, &restored.moments, &change.target_volumes);
    state.effective_surface_area = effective_surface_area(model, &change.dual_cells);
    phase_end("momentum and extension");
    Ok(StepResult { solves, newton_iterations, prescribed_work, volume_error_cells: 0.0 })
}

/// The faces at the interface, where surface tension is a jump of the pressure, and those that contact lines drag.
struct Interface {
    faces: Vec<InterfaceFace>,
    dragged: Vec<DraggedFace>,
}

/// Finds where the interface cuts faces, with its curvature there, and the friction of the contact lines.
fn find_interface<const D: usize>(
    model: &Model<D>,
    state: &State<D>,
    work: &mut Workspace<D>,
    change: &ComponentChange<D>,
    solids_before: &[SolidState<D>],
    forces: ForceStep<D>,
) -> Interface {
    let ForceStep { dt, impulse_time, displacements } = forces;
    let capillary_cfl_squared =
        model.surface_tension * dt * impulse_time / (model.density * model.grid.dx.powi(3));
    let filter = FilterStep { capillary_cfl_squared, displacements };
    let phi = Sampler::cells(&model.grid, &state.phi.data, model.scalar_boundary());
    let [solids, solids_before] =
        [&state.solids, solids_before].map(|states| Solids { model, states, surfaces: &work.surfaces });
    let ghosts = ghost_cells(solids, state, &work.band, &work.cut_cells);
    let beside =
        SolidContext { cut_cells: &work.cut_cells, ghosts: &ghosts, bond_vector: model.cell_bond_vector() };
    let layers = InterfaceLayers {
        grid: &model.grid,
        band: &work.band,
        layers: CURVATURE_LAYERS,
        phi: &phi,
        dual_cells: &change.dual_cells,
    };
    let kappa = curvature(&layers, &beside, &filter);
    let mut faces = interface_faces(model, &state.phi, &work.band, &kappa, &work.cut_cells);
    work.repairs.add(&kappa.repairs);
    work.repairs.unknown_curvatures += faces.iter().filter(|face| !face.is_curvature_known).count() as u64;
    let lines = LineFriction {
        state,
        solids_before,
        dual_cells: &change.dual_cells,
        cut_cells: &work.cut_cells,
        impulse_time,
    };
    let dragged = lines.dragged_faces(&mut faces);
    Interface { faces, dragged }
}

/// Advances the velocity's lead to the end of the impulse, and returns the times of the step.
fn begin_impulse<const D: usize>(
    model: &Model<D>,
    state: &mut State<D>,
    dt: f64,
    impulse_time: f64,
) -> StepTimes {
    // Before the first step there are no old positions: its impulse time is centred on the start.
    let is_first = state.last_dt == 0.0;
    state.collision_free_dt =
        if is_first { MAX_DT_GROWTH * dt } else { lookahead_time(model, &state.solids, dt) };
    state.velocity_lead += impulse_time - dt;
    let velocity_lead = if is_first { 0.5 * impulse_time } else { state.velocity_lead };
    StepTimes { dt, impulse_time, velocity_lead, lookahead: state.collision_free_dt, is_first }
}

/// Elements near inversion and singular inertias of a state, and the neglected weight of the liquid.
fn solid_repairs<const D: usize>(model: &Model<D>, state: &State<D>) -> Repairs {
    let mut repairs = Repairs { weight_left_out: model.neglected_weight_fraction(), ..Repairs::default() };
    for (elastic, now) in model.deformable_solids(&state.solids) {
        repairs.crushed_elements += elastic.crushed_elements(&now.positions) as u64;
    }
    for (solid, now) in model.solids.iter().zip(&state.solids).filter(|(s, _)| s.kind.is_free_rigid()) {
        let is_singular = solid.inverse_inertia(&now.as_rigid()).norm_squared() == 0.0;
        repairs.singular_inertia += u64::from(is_singular);
    }
    repairs
}

/// Moves the solids and updates the cut cells.
fn move_solids<const D: usize>(model: &Model<D>, state: &mut State<D>, work: &mut Workspace<D>, dt: f64) {
    let (time, all) = (state.time, model.solids.iter());
    all.zip(&mut state.solids).for_each(|(solid, now)| solid.advance(now, time, dt));
    crate::collision::potential::slips::advance_slips(model, &mut state.elastic_slips, dt);
    work.update_solids(model, state);
}

/// Adds gravity for `dt` (s) to the velocities of liquid and free rigid solids; deformable solids have it among their loads.
fn apply_gravity<const D: usize>(model: &Model<D>, state: &mut State<D>, work: &Workspace<D>, dt: f64) {
    for (now, solid) in state.solids.iter_mut().zip(&model.solids) {
        if let Some(rigid) = solid.free_rigid_mut(now) {
            rigid.velocity += model.gravity * dt;
        }
    }
    for a in (0..D).filter(|&a| model.gravity[a] != 0.0) {
        let velocity_change = model.gravity[a] * dt;
        let lattice = model.grid.face_lattice(a);
        let row = lattice.extent[0];
        par::for_each_segment(
            &mut state.velocity.axes[a],
            row,
            &work.known_faces.liquid_faces()[a],
            |s, part| {
                let mut at = lattice.coordinates(s.row * row);
                for (i, u) in part.iter_mut().enumerate() {
                    at[0] = s.start + i;
                    *u += if model.on_closed_side(a, at[a]) { 0.0 } else { velocity_change };
                }
            },
        );
    }
}
