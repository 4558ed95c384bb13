//! One time step of the liquid.
//!
//! Positions first, then one solve for the velocity: a capillary wave then obeys symplectic Euler, which neither
//! damps nor drives it (design, numerics §8).

use super::diagnostics::{drops, kinetic_energy, max_component, surface_energy};
use super::workspace::Workspace;
use crate::components::restoration::{give_back, keep_carried, keep_momentum};
use crate::components::tracking::{Change, expect, keep_volume};
use crate::components::volume::band_labels;
use crate::contact_line::friction::drag;
use crate::contact_line::hysteresis::hold_lines;
use crate::coupling::solve::{Pressed, press, stirred};
use crate::flow::advection::{advect_surface, advect_velocity, pack};
use crate::flow::outflow::drain;
use crate::free_surface::curvature::{Beside, Displacement, FilterStep, curvature};
use crate::free_surface::extension::{extend_into_solids, ghosts};
use crate::free_surface::interface_faces::cut_faces;
use crate::model::Model;
use crate::model::resolution::{BAND, LAYERS, SLOPE};
use crate::model::time_step::{GROWTH, PhaseEnd, Times, clear_time, kick, wanted_kick};
use crate::repairs::Repairs;
use crate::solid::{Motion, SolidState};
use crate::state::State;
use meniscus_numerics::grid::{Runs, Sampler, Segment};
use meniscus_numerics::level_set::{redistance, slope};
use meniscus_numerics::linalg::{SolveError, SolveReport};
use meniscus_numerics::{Vector, par};
use rayon::prelude::*;

/// Layers of the band on which curvature is found.
const CURVED: usize = 5;
/// Cells that the interface may move before φ is made a distance again.
const DRIFT: f64 = 0.7;
/// Layers of the band on which φ is made a distance in every step: all that the curvature sees.
const NEAR: usize = 6;

/// φ, in cells, of what a receding line leaves behind in a solid: no liquid, and else as little changed as can be.
const LEFT_BEHIND: f64 = 0.01;

/// Part of the way to a distance that φ goes in a step within solids. There no force smooths it, and redistancing turns a
/// zigzag of the period of two cells into its opposite: all the way it stays for ever and stirs drops at rest (u_rms 1e-2).
const WITHIN: f64 = 0.5;

/// What a step found out.
pub struct StepResult {
    /// The pressure solves, the last of Newton's iterations where there are any.
    pub solves: [SolveReport; 2],
    /// Newton's iterations for solids and pressure.
    pub newton_iterations: u64,
    /// Work that solids which go as told did, J.
    pub stirred: f64,
    /// What a component's volume was wrong by before it was put right, as a layer on a ball of its volume, in cells.
    pub volume_jump: f64,
}

/// Advances the state by `dt` seconds.
///
/// # Errors
/// The pressure solve's; the state is then between two times and must be thrown away.
pub fn step<const D: usize>(
    model: &Model<D>,
    state: &mut State<D>,
    work: &mut Workspace<D>,
    dt: f64,
    phase_end: PhaseEnd<'_>,
) -> Result<StepResult, SolveError> {
    if state.step == 0 {
        start(model, state, work, dt, phase_end)?;
    }

    // (0) The solids move.
    let before = state.solids.clone();
    if !model.solids.is_empty() {
        move_solids(model, state, work, dt);
        phase_end("solids");
    }

    // (1) to (3) The liquid moves.
    let (wanted, kick) = (wanted_kick(state.lead, dt), kick(state.lead, dt));
    work.repairs.limited_kicks += u64::from(kick != wanted);
    let (mut change, displacement) = move_liquid(model, state, work, &before, dt, phase_end);

    // (4) The forces, and viscosity.
    let pushed = push(model, state, work, &mut change, displacement, (dt, kick), phase_end)?;
    state.kick = kick;
    state.time += dt;
    state.step += 1;
    state.last_dt = dt;

    // (6) What has passed an open side is gone.
    drain(model, state, work);
    Ok(StepResult { volume_jump: change.jump, ..pushed })
}

/// Moves the liquid; gives back how it has changed, and how its surface moves. `solids` is where they were before.
fn move_liquid<const D: usize>(
    model: &Model<D>,
    state: &mut State<D>,
    work: &mut Workspace<D>,
    solids: &[SolidState<D>],
    dt: f64,
    phase_end: PhaseEnd<'_>,
) -> (Change<D>, Vec<Displacement<D>>) {
    // (1) The surface moves with the flow and becomes a distance again.
    let before = move_surface(model, state, work, solids, dt);
    phase_end("advect surface");
    keep_distance(model, state, work);
    phase_end("redistance");
    hold_lines(model, state, work);

    // (2) Every component keeps its volume, and the centre of mass of what touches nothing its path.
    let change = keep_volume(model, state, work, &before, dt);
    work.repairs.add(&change.repairs);
    phase_end("volume");

    // (3) The velocity is carried along.
    let displacement = displacements(model, state, work, dt);
    move_velocity(model, state, work, dt);
    let carried = keep_carried(model, state, work, &change);
    work.repairs.add(&carried);
    phase_end("advect velocity");
    (change, displacement)
}

/// Brings the velocity half a step ahead of the positions, where leapfrog wants it: once, before the first step.
fn start<const D: usize>(
    model: &Model<D>,
    state: &mut State<D>,
    work: &mut Workspace<D>,
    dt: f64,
    phase_end: PhaseEnd<'_>,
) -> Result<(), SolveError> {
    hold_lines(model, state, work);
    let mut change = Change::none(model, state, work);
    change.targets = state.drops.iter().map(|d| d.target_volume).collect();
    expect(model, state, work, &mut change.groups, &[], 0.0);
    let still = displacements(model, state, work, 0.0);
    work.mark_afresh(model);
    state.lead = dt;
    push(model, state, work, &mut change, still, (dt, 0.5 * dt), phase_end)?;
    state.kick = 0.5 * dt;
    Ok(())
}

/// Adds what gravity, surface tension and pressure do to the velocity in the time `kick`, in a step of `dt`;
/// `displacement` as [`displacements`] found it. Gives back the work of solids, too.
fn push<const D: usize>(
    model: &Model<D>,
    state: &mut State<D>,
    work: &mut Workspace<D>,
    change: &mut Change<D>,
    displacement: Vec<Displacement<D>>,
    (dt, kick): (f64, f64),
    phase_end: PhaseEnd<'_>,
) -> Result<StepResult, SolveError> {
    let before = state.solids.clone();
    fall(model, state, work, kick);

    // Surface tension as a pressure on the surface.
    let capillary = model.surface_tension * dt * kick / (model.density * model.grid.dx.powi(3));
    let filter = FilterStep { capillary, displacement };
    let phi = Sampler::cells(&model.grid, &state.phi.data, model.scalar_edges());
    let ghosts = ghosts(model, state, &work.band, &work.cut);
    let beside = Beside { solids: &work.cut, ghosts: &ghosts, weight: model.weight() };
    let kappa = curvature(&model.grid, &work.band, CURVED, &phi, &change.cubes, &beside, &filter);
    let mut cut = cut_faces(model, &state.phi, &work.band, &kappa, &work.cut);
    work.repairs.add(&kappa.repairs);
    work.repairs.unknown_curvatures += cut.iter().filter(|face| !face.known).count() as u64;
    let mut dragged = drag(model, (state, &before), &change.cubes, (&mut cut, &work.cut), kick);
    phase_end("curvature");

    // One solve for the pressure; what it and the contact line give to solids, the liquid gives.
    state.clear = if state.last_dt > 0.0 { clear_time(model, &state.solids, dt) } else { GROWTH * dt };
    state.lead += kick - dt;
    // Before the first step there are no old positions: its forces act about the start.
    let first = state.last_dt == 0.0;
    let lead = if first { 0.5 * kick } else { state.lead };
    let times = Times { dt, kick, lead, ahead: state.clear, first };
    let Pressed { solves, given, contacts, iterations } =
        press(model, (state, &before), work, change, (&cut, &mut dragged), times, phase_end)?;
    let stirred = stirred(model, state, &given) + contacts;
    give_back(model, &mut change.groups, &given);
    phase_end("pressure");

    // Momentum that the discretisation lost comes back; the velocity extends beyond the liquid.
    let kept = keep_momentum(model, state, work, &cut, (change, &change.groups), kick);
    let slip_unknown = work.extend(model, state);
    work.repairs.add(&Repairs {
        momentum_restored: kept.momentum,
        spin_restored: kept.spin,
        unrestored: kept.unrestored,
        unlabelled: kept.unlabelled,
        slip_unknown,
        ..of_solids(model, state)
    });
    state.drops = drops(model, work, &cut, &kept.moments, change);
    state.kinetic_energy = kinetic_energy(model, &kept.moments, &change.targets);
    state.surface_area = surface_energy(model, &change.cubes);
    phase_end("momentum and extension");
    Ok(StepResult { solves, newton_iterations: iterations, stirred, volume_jump: 0.0 })
}

/// What holds elements upright and what nothing turns, in a state; what of the liquid's weight the model leaves out.
fn of_solids<const D: usize>(model: &Model<D>, state: &State<D>) -> Repairs {
    let mut repairs = Repairs { weight_left_out: model.weight_left_out(), ..Repairs::default() };
    for (solid, now) in model.solids.iter().zip(&state.solids) {
        let soft = solid.elastic().zip(now.soft.as_ref());
        let crushed = soft.map_or(0, |(elastic, soft)| elastic.crushed_elements(&soft.body.positions));
        repairs.crushed_elements += crushed as u64;
        let stuck = solid.motion == Motion::Free && solid.inverse_inertia(now).norm_squared() == 0.0;
        repairs.singular_inertia += u64::from(stuck);
    }
    repairs
}

/// Moves φ; gives back the liquid cells before. `solids` is where they were before.
pub fn move_surface<const D: usize>(
    model: &Model<D>,
    state: &mut State<D>,
    work: &mut Workspace<D>,
    solids: &[SolidState<D>],
    dt: f64,
) -> Runs {
    let values = advect_surface(model, &state.phi, &work.band, &state.velocity, dt);
    work.band.cells.iter().zip(values).for_each(|(&c, v)| state.phi.data[c as usize] = v);
    let extended = extend_into_solids(model, state, &work.band, &work.cut, solids);
    (work.apart, work.beyond) = (extended.apart, extended.beyond);
    let way = max_component(model, state, work) * dt / model.grid.dx;
    state.drift += way;
    let before = std::mem::take(&mut work.liquid);
    let left = work.band.cells.clone();
    work.find_liquid(model, state);
    let strays = work.strays(model, &before, way.ceil().max(1.0) as usize);
    if !strays.cells.is_empty() {
        let volume = volumes(model, state, work);
        let sum = |some: &[u32]| some.iter().map(|c| volume[*c as usize].max(0.0)).sum::<f64>();
        work.repairs.deleted_cells += strays.cells.len() as u64;
        work.repairs.deleted_volume += sum(&strays.components);
        work.repairs.leaked_volume += sum(&strays.leaked);
        strays.cells.iter().for_each(|&c| state.phi.data[c] = LEFT_BEHIND * model.grid.dx);
        work.find_liquid(model, state);
    }
    let limit = BAND * model.grid.dx;
    for cell in left {
        if work.band.slot(cell as usize).is_none() {
            let value = &mut state.phi.data[cell as usize];
            *value = limit.copysign(*value);
        }
    }
    before
}

/// Volumes of the components, m³ (2D: m²), outside of solids.
fn volumes<const D: usize>(model: &Model<D>, state: &State<D>, work: &Workspace<D>) -> Vec<f64> {
    let labels = band_labels(model, &work.band, &state.phi, &work.liquid);
    work.measured_liquid(model, &labels).measure(&state.phi).volumes
}

/// Makes φ a distance again: around the surface in every step, farther off when the surface has moved enough or its
/// slope has become wrong.
///
/// The curvature is only as smooth as φ: noise of the transport that is left from step to step grows (measured: a
/// drop's frequency wrong by 5 %, where it is 0.3 % if φ is a distance in every step).
pub(crate) fn keep_distance<const D: usize>(model: &Model<D>, state: &mut State<D>, work: &Workspace<D>) {
    let sampler = Sampler::cells(&model.grid, &state.phi.data, model.scalar_edges());
    let edge = &work.band.cells[work.band.first_layers(1)];
    let outside = |c: u32| work.cut.distance(c as usize) >= 0.0;
    let wrong = |c: u32| (slope(&model.grid, &state.phi.data, &sampler, c as usize) - 1.0).abs() > SLOPE;
    let count = edge.par_iter().filter(|c| outside(**c) && wrong(**c)).count();
    let all = state.drift > DRIFT || count * 100 > edge.len();
    let layers = if all { LAYERS } else { NEAR };
    let values = redistance(&model.grid, &work.band, layers, &state.phi.data, &sampler, BAND * model.grid.dx);
    let cells = work.band.cells.iter().zip(values).filter(|(c, _)| work.apart.binary_search(c).is_err());
    cells.for_each(|(&c, v)| {
        let value = &mut state.phi.data[c as usize];
        *value += if outside(c) { v - *value } else { WITHIN * (v - *value) };
    });
    if all {
        state.drift = 0.0;
    }
}

/// How the surface moves in a step, on the first layers of the band.
fn displacements<const D: usize>(
    model: &Model<D>,
    state: &State<D>,
    work: &Workspace<D>,
    dt: f64,
) -> Vec<Displacement<D>> {
    let sampler = Sampler::cells(&model.grid, &state.phi.data, model.scalar_edges());
    let lattice = model.grid.lattice();
    work.band.cells[work.band.first_layers(CURVED)]
        .par_iter()
        .map(|&c| {
            let at = lattice.coordinates(c as usize);
            let mut path = Vector::zeros();
            for a in 0..D {
                let faces = model.grid.faces(a);
                let f = faces.index(at);
                let u = 0.5 * (state.velocity.axes[a][f] + state.velocity.axes[a][f + faces.stride[a]]);
                path[a] = u * dt / model.grid.dx;
            }
            Displacement { normal: sampler.slope(at).try_normalize(0.0).unwrap_or(Vector::zeros()), path }
        })
        .collect()
}

/// Carries the velocity to the new liquid's faces.
fn move_velocity<const D: usize>(model: &Model<D>, state: &mut State<D>, work: &mut Workspace<D>, dt: f64) {
    let faces: [Vec<Segment>; D] = std::array::from_fn(|a| work.liquid.faces(&model.grid, a));
    let values = advect_velocity(model, &state.velocity, &faces, dt);
    work.known.clear(&mut state.velocity);
    for a in 0..D {
        let lattice = model.grid.faces(a);
        let packed = pack(&faces[a]);
        let starts: Vec<usize> = packed.iter().map(|s| s.start).collect();
        let index = |s: &Segment| faces[a].partition_point(|o| (o.row, o.start) < (s.row, s.start));
        par::for_each_segment(&mut state.velocity.axes[a], lattice.extent[0], &faces[a], |s, part| {
            let from = starts[index(s)];
            let mut at = lattice.coordinates(s.row * lattice.extent[0]);
            for (i, u) in part.iter_mut().enumerate() {
                at[0] = s.start + i;
                *u = if model.closed(a, at[a]) { 0.0 } else { values[a][from + i] };
            }
        });
    }
    work.known.set_liquid(faces);
    work.known.forget_shut(&work.cut.shut);
}

/// Moves the solids and finds what they cut.
fn move_solids<const D: usize>(model: &Model<D>, state: &mut State<D>, work: &mut Workspace<D>, dt: f64) {
    let (time, all) = (state.time, model.solids.iter());
    all.zip(&mut state.solids).for_each(|(solid, now)| solid.advance(now, time, dt));
    crate::collision::potential::slips::advance(model, &mut state.slips, dt);
    work.follow_solids(model, state);
}

/// Adds gravity to the velocity.
fn fall<const D: usize>(model: &Model<D>, state: &mut State<D>, work: &Workspace<D>, dt: f64) {
    for (now, solid) in state.solids.iter_mut().zip(&model.solids) {
        now.velocity += if solid.motion == Motion::Free { model.gravity * dt } else { Vector::zeros() };
    }
    for a in (0..D).filter(|&a| model.gravity[a] != 0.0) {
        let fall = model.gravity[a] * dt;
        let lattice = model.grid.faces(a);
        let row = lattice.extent[0];
        par::for_each_segment(&mut state.velocity.axes[a], row, &work.known.liquid()[a], |s, part| {
            let mut at = lattice.coordinates(s.row * row);
            for (i, u) in part.iter_mut().enumerate() {
                at[0] = s.start + i;
                *u += if model.closed(a, at[a]) { 0.0 } else { fall };
            }
        });
    }
}
