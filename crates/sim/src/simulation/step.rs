//! One time step of the liquid.
//!
//! Positions are advanced first, then one solve gives the velocity. A capillary wave thus obeys symplectic Euler, which neither
//! damps nor amplifies it.

use super::diagnostics::{
    effective_surface_area, kinetic_energy, max_velocity_component, measure_components,
};
use super::workspace::Workspace;
use crate::components::restoration::{restore_advected_momentum, restore_momentum, subtract_solid_impulses};
use crate::components::tracking::{ComponentChange, predict_motions, restore_volume};
use crate::components::volume::band_labels;
use crate::contact_line::friction::LineFriction;
use crate::contact_line::hysteresis::pin_contact_lines;
use crate::coupling::solve::{PressureSolution, PressureStep, prescribed_solid_work, solve_pressure};
use crate::flow::advection::{advect_interface, advect_velocity, pack};
use crate::flow::outflow::remove_outflow;
use crate::free_surface::curvature::{
    FilterStep, InterfaceDisplacement, InterfaceLayers, SolidContext, curvature,
};
use crate::free_surface::extension::{extend_into_solids, ghost_cells};
use crate::free_surface::interface_faces::interface_faces;
use crate::model::Model;
use crate::model::resolution::{BAND_LAYERS, BAND_WIDTH_CELLS, GRADIENT_NORM_TOLERANCE};
use crate::model::time_step::{
    MAX_DT_GROWTH, PhaseEnd, StepTimes, impulse_time, lookahead_time, unbounded_impulse_time,
};
use crate::repairs::Repairs;
use crate::solid::{Motion, SolidState};
use crate::state::State;
use meniscus_numerics::grid::{Runs, Sampler, Segment};
use meniscus_numerics::level_set::{interface_gradient_norm, redistance};
use meniscus_numerics::linalg::{SolveError, SolveReport};
use meniscus_numerics::{Vector, par};
use rayon::prelude::*;

/// Layers of the band in which the curvature is computed.
const CURVATURE_LAYERS: usize = 5;
/// Displacement of the interface, in cells, after which φ is redistanced in the whole band.
const REDISTANCE_DISPLACEMENT_CELLS: f64 = 0.7;
/// Layers of the band redistanced in every step: the stencil of the curvature.
const REDISTANCE_LAYERS: usize = 6;

/// Value of φ, in cells, for deleted residue in a solid: air, and changed as little as possible.
const RESIDUE_PHI_CELLS: f64 = 0.01;

/// Relaxation factor of redistancing within solids. No force smooths φ there, and redistancing inverts a zigzag of two cells'
/// period: with factor 1 it persists and disturbs drops at rest (u_rms 1e-2).
const SOLID_REDISTANCE_RELAXATION: f64 = 0.5;

/// Result of a step.
pub struct StepResult {
    /// The pressure solves, those of the last Newton iteration if there are any.
    pub solves: [SolveReport; 2],
    /// Newton iterations for solids and pressure.
    pub newton_iterations: u64,
    /// Work done by solids of prescribed motion, J.
    pub prescribed_work: f64,
    /// Largest volume error of a component before its correction, as the thickness of a layer on a ball of its volume, in cells.
    pub volume_error_cells: f64,
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

    // (0) The solids move.
    let before = state.solids.clone();
    if !model.solids.is_empty() {
        move_solids(model, state, work, dt);
        phase_end("solids");
    }

    // (1) to (3) The liquid moves.
    let (unbounded, impulse_time) =
        (unbounded_impulse_time(state.velocity_lead, dt), impulse_time(state.velocity_lead, dt));
    work.repairs.limited_kicks += u64::from(impulse_time != unbounded);
    let (mut change, displacement) = move_liquid(model, state, work, &before, dt, phase_end);

    // (4) Forces and viscosity act.
    let pushed = apply_forces(model, state, work, &mut change, displacement, (dt, impulse_time), phase_end)?;
    state.impulse_time = impulse_time;
    state.time += dt;
    state.step += 1;
    state.last_dt = dt;

    // (5) Liquid beyond open sides is removed.
    remove_outflow(model, state, work);
    Ok(StepResult { volume_error_cells: change.volume_error_cells, ..pushed })
}

/// Moves the liquid; returns the change of its components and the displacement of the interface. `solids` are those before the step.
fn move_liquid<const D: usize>(
    model: &Model<D>,
    state: &mut State<D>,
    work: &mut Workspace<D>,
    solids: &[SolidState<D>],
    dt: f64,
    phase_end: PhaseEnd<'_>,
) -> (ComponentChange<D>, Vec<InterfaceDisplacement<D>>) {
    // (1) The interface is advected and φ redistanced.
    let before = move_interface(model, state, work, solids, dt);
    phase_end("advect surface");
    restore_signed_distance(model, state, work);
    phase_end("redistance");
    pin_contact_lines(model, state, work);

    // (2) The volume of every component is restored, and the centre of mass of one that touches nothing is put back on its path.
    let change = restore_volume(model, state, work, &before, dt);
    work.repairs.add(&change.repairs);
    phase_end("volume");

    // (3) The velocity is advected.
    let displacement = interface_displacements(model, state, work, dt);
    move_velocity(model, state, work, dt);
    let carried = restore_advected_momentum(model, state, work, &change);
    work.repairs.add(&carried);
    phase_end("advect velocity");
    (change, displacement)
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
    let still = interface_displacements(model, state, work, 0.0);
    work.reset_known_faces(model);
    state.velocity_lead = dt;
    apply_forces(model, state, work, &mut change, still, (dt, 0.5 * dt), phase_end)?;
    state.impulse_time = 0.5 * dt;
    Ok(())
}

/// Adds the impulses of gravity, surface tension and pressure over `impulse_time`, in a step of `dt`, to the velocity. The
/// `displacements` are those of [`interface_displacements`]. Returns the work of solids, too.
fn apply_forces<const D: usize>(
    model: &Model<D>,
    state: &mut State<D>,
    work: &mut Workspace<D>,
    change: &mut ComponentChange<D>,
    displacements: Vec<InterfaceDisplacement<D>>,
    (dt, impulse_time): (f64, f64),
    phase_end: PhaseEnd<'_>,
) -> Result<StepResult, SolveError> {
    let before = state.solids.clone();
    apply_gravity(model, state, work, impulse_time);

    // Surface tension is a pressure jump at the interface.
    let capillary_cfl_squared =
        model.surface_tension * dt * impulse_time / (model.density * model.grid.dx.powi(3));
    let filter = FilterStep { capillary_cfl_squared, displacements };
    let phi = Sampler::cells(&model.grid, &state.phi.data, model.scalar_boundary());
    let ghosts = ghost_cells(model, state, &work.band, &work.cut_cells);
    let beside =
        SolidContext { cut_cells: &work.cut_cells, ghosts: &ghosts, bond_vector: model.cell_bond_vector() };
    let interface = InterfaceLayers {
        grid: &model.grid,
        band: &work.band,
        layers: CURVATURE_LAYERS,
        phi: &phi,
        dual_cells: &change.dual_cells,
    };
    let kappa = curvature(&interface, &beside, &filter);
    let mut interface_faces = interface_faces(model, &state.phi, &work.band, &kappa, &work.cut_cells);
    work.repairs.add(&kappa.repairs);
    work.repairs.unknown_curvatures +=
        interface_faces.iter().filter(|face| !face.is_curvature_known).count() as u64;
    let lines = LineFriction {
        model,
        state,
        solids_before: &before,
        dual_cells: &change.dual_cells,
        cut_cells: &work.cut_cells,
        impulse_time,
    };
    let mut dragged = lines.dragged_faces(&mut interface_faces);
    phase_end("curvature");

    // One solve for the pressure. The liquid loses the impulses that pressure and contact line give to solids.
    state.collision_free_dt =
        if state.last_dt > 0.0 { lookahead_time(model, &state.solids, dt) } else { MAX_DT_GROWTH * dt };
    state.velocity_lead += impulse_time - dt;
    // Before the first step there are no old positions: its impulse time is centred on the start.
    let is_first = state.last_dt == 0.0;
    let velocity_lead = if is_first { 0.5 * impulse_time } else { state.velocity_lead };
    let times = StepTimes { dt, impulse_time, velocity_lead, lookahead: state.collision_free_dt, is_first };
    let pressure_step = PressureStep {
        solids_before: &before,
        interface_faces: &interface_faces,
        dragged_faces: &mut dragged,
        times,
    };
    let PressureSolution { solves, solid_impulses, contact_work, newton_iterations } =
        solve_pressure(model, state, work, change, pressure_step, phase_end)?;
    let prescribed_work = prescribed_solid_work(model, state, &solid_impulses) + contact_work;
    subtract_solid_impulses(model, &mut change.groups, &solid_impulses);
    phase_end("pressure");

    // Momentum lost by the discretisation is restored; the velocity is extended beyond the liquid.
    let restored =
        restore_momentum(model, state, work, &interface_faces, &change.momentum_targets(impulse_time));
    let slip_unknown = work.extend_velocity(model, state);
    work.repairs.add(&Repairs {
        momentum_restored: restored.momentum,
        spin_restored: restored.angular_momentum,
        unrestored: restored.unrestored,
        unlabelled: restored.unlabelled,
        slip_unknown,
        ..solid_repairs(model, state)
    });
    state.components = measure_components(model, work, &interface_faces, &restored.moments, change);
    state.kinetic_energy = kinetic_energy(model, &restored.moments, &change.target_volumes);
    state.effective_surface_area = effective_surface_area(model, &change.dual_cells);
    phase_end("momentum and extension");
    Ok(StepResult { solves, newton_iterations, prescribed_work, volume_error_cells: 0.0 })
}

/// Elements near inversion and singular inertias of a state, and the neglected weight of the liquid.
fn solid_repairs<const D: usize>(model: &Model<D>, state: &State<D>) -> Repairs {
    let mut repairs = Repairs { weight_left_out: model.neglected_weight_fraction(), ..Repairs::default() };
    for (solid, now) in model.solids.iter().zip(&state.solids) {
        let soft = solid.elastic().zip(now.soft.as_ref());
        let crushed = soft.map_or(0, |(elastic, soft)| elastic.crushed_elements(&soft.state.positions));
        repairs.crushed_elements += crushed as u64;
        let is_singular = solid.motion == Motion::Free && solid.inverse_inertia(now).norm_squared() == 0.0;
        repairs.singular_inertia += u64::from(is_singular);
    }
    repairs
}

/// Advects φ and returns the liquid cells before. `solids` are those before the step.
pub fn move_interface<const D: usize>(
    model: &Model<D>,
    state: &mut State<D>,
    work: &mut Workspace<D>,
    solids: &[SolidState<D>],
    dt: f64,
) -> Runs {
    let values = advect_interface(model, &state.phi, &work.band, &state.velocity, dt);
    work.band.cells.iter().zip(values).for_each(|(&c, v)| state.phi.data[c as usize] = v);
    let extended = extend_into_solids(model, state, &work.band, &work.cut_cells, solids);
    (work.non_distance_cells, work.overwritten_phi) = (extended.non_distance_cells, extended.overwritten_phi);
    let displacement_cells = max_velocity_component(model, state, work) * dt / model.grid.dx;
    state.displacement_since_redistancing += displacement_cells;
    let before = std::mem::take(&mut work.liquid);
    let old_band_cells = work.band.cells.clone();
    work.find_liquid(model, state);
    let spurious = work.find_spurious_components(model, &before, displacement_cells.ceil().max(1.0) as usize);
    if !spurious.cells.is_empty() {
        let volume = component_volumes(model, state, work);
        let sum = |some: &[u32]| some.iter().map(|c| volume[*c as usize].max(0.0)).sum::<f64>();
        work.repairs.deleted_cells += spurious.cells.len() as u64;
        work.repairs.deleted_volume += sum(&spurious.components);
        work.repairs.leaked_volume += sum(&spurious.leaked);
        spurious.cells.iter().for_each(|&c| state.phi.data[c] = RESIDUE_PHI_CELLS * model.grid.dx);
        work.find_liquid(model, state);
    }
    let limit = BAND_WIDTH_CELLS * model.grid.dx;
    for cell in old_band_cells {
        if work.band.slot(cell as usize).is_none() {
            let value = &mut state.phi.data[cell as usize];
            *value = limit.copysign(*value);
        }
    }
    before
}

/// Volumes of the components outside solids, m³ (2D: m²).
fn component_volumes<const D: usize>(model: &Model<D>, state: &State<D>, work: &Workspace<D>) -> Vec<f64> {
    let labels = band_labels(model, &work.band, &state.phi, &work.liquid);
    work.volume_correction(model, &labels).measure(&state.phi).volumes
}

/// Redistances φ: near the interface in every step, in the whole band if the interface has moved enough or |∇φ| is wrong.
///
/// The curvature is only as smooth as φ, and noise of the advection that persists grows: the frequency of a drop is then wrong by 5 %,
/// with redistancing in every step by 0.3 %.
pub(crate) fn restore_signed_distance<const D: usize>(
    model: &Model<D>,
    state: &mut State<D>,
    work: &Workspace<D>,
) {
    let sampler = Sampler::cells(&model.grid, &state.phi.data, model.scalar_boundary());
    let first_layer = &work.band.cells[work.band.first_layers(1)];
    let outside = |c: u32| work.cut_cells.distance_cells(c as usize) >= 0.0;
    let is_not_distance = |c: u32| {
        (interface_gradient_norm(&model.grid, &state.phi.data, &sampler, c as usize) - 1.0).abs()
            > GRADIENT_NORM_TOLERANCE
    };
    let count = first_layer.par_iter().filter(|c| outside(**c) && is_not_distance(**c)).count();
    let full_band = state.displacement_since_redistancing > REDISTANCE_DISPLACEMENT_CELLS
        || count * 100 > first_layer.len();
    let layers = if full_band { BAND_LAYERS } else { REDISTANCE_LAYERS };
    let values = redistance(
        &model.grid,
        &work.band,
        layers,
        &state.phi.data,
        &sampler,
        BAND_WIDTH_CELLS * model.grid.dx,
    );
    let cells =
        work.band.cells.iter().zip(values).filter(|(c, _)| work.non_distance_cells.binary_search(c).is_err());
    cells.for_each(|(&c, v)| {
        let value = &mut state.phi.data[c as usize];
        *value += if outside(c) { v - *value } else { SOLID_REDISTANCE_RELAXATION * (v - *value) };
    });
    if full_band {
        state.displacement_since_redistancing = 0.0;
    }
}

/// Displacement of the interface in a step, on the first layers of the band.
fn interface_displacements<const D: usize>(
    model: &Model<D>,
    state: &State<D>,
    work: &Workspace<D>,
    dt: f64,
) -> Vec<InterfaceDisplacement<D>> {
    let sampler = Sampler::cells(&model.grid, &state.phi.data, model.scalar_boundary());
    let lattice = model.grid.lattice();
    work.band.cells[work.band.first_layers(CURVATURE_LAYERS)]
        .par_iter()
        .map(|&c| {
            let at = lattice.coordinates(c as usize);
            let mut displacement_cells = Vector::zeros();
            for a in 0..D {
                let faces = model.grid.face_lattice(a);
                let f = faces.index(at);
                let u = 0.5 * (state.velocity.axes[a][f] + state.velocity.axes[a][f + faces.stride[a]]);
                displacement_cells[a] = u * dt / model.grid.dx;
            }
            InterfaceDisplacement {
                normal: sampler.gradient(at).try_normalize(0.0).unwrap_or(Vector::zeros()),
                displacement_cells,
            }
        })
        .collect()
}

/// Advects the velocity to the faces of the new liquid.
fn move_velocity<const D: usize>(model: &Model<D>, state: &mut State<D>, work: &mut Workspace<D>, dt: f64) {
    let faces: [Vec<Segment>; D] = std::array::from_fn(|a| work.liquid.faces(&model.grid, a));
    let values = advect_velocity(model, &state.velocity, &faces, dt);
    work.known_faces.clear_with_velocity(&mut state.velocity);
    for a in 0..D {
        let lattice = model.grid.face_lattice(a);
        let packed = pack(&faces[a]);
        let starts: Vec<usize> = packed.iter().map(|s| s.start).collect();
        let index = |s: &Segment| faces[a].partition_point(|o| (o.row, o.start) < (s.row, s.start));
        par::for_each_segment(&mut state.velocity.axes[a], lattice.extent[0], &faces[a], |s, part| {
            let from = starts[index(s)];
            let mut at = lattice.coordinates(s.row * lattice.extent[0]);
            for (i, u) in part.iter_mut().enumerate() {
                at[0] = s.start + i;
                *u = if model.on_closed_side(a, at[a]) { 0.0 } else { values[a][from + i] };
            }
        });
    }
    work.known_faces.set_liquid_faces(faces);
    work.known_faces.unmark_closed_faces(&work.cut_cells.closed_faces);
}

/// Moves the solids and updates the cut cells.
fn move_solids<const D: usize>(model: &Model<D>, state: &mut State<D>, work: &mut Workspace<D>, dt: f64) {
    let (time, all) = (state.time, model.solids.iter());
    all.zip(&mut state.solids).for_each(|(solid, now)| solid.advance(now, time, dt));
    crate::collision::potential::slips::advance_slips(model, &mut state.elastic_slips, dt);
    work.update_cut_cells(model, state);
}

/// Adds gravity to the velocity.
fn apply_gravity<const D: usize>(model: &Model<D>, state: &mut State<D>, work: &Workspace<D>, dt: f64) {
    for (now, solid) in state.solids.iter_mut().zip(&model.solids) {
        now.velocity += if solid.motion == Motion::Free { model.gravity * dt } else { Vector::zeros() };
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
