//! One time step of the liquid.
//!
//! Positions first, then one solve for the velocity: a capillary wave then obeys symplectic Euler, which neither
//! damps nor drives it (design, numerics §8).

use crate::ledger::Ledger;
use crate::liquid::curvature::{Beside, Curvature, Displacement, FilterStep, curvature};
use crate::liquid::ghost::{extend_into_solids, ghosts};
use crate::liquid::momentum::{FaceWalk, Moments, together};
use crate::liquid::pressure::{CutFace, Projection, cut_faces};
use crate::liquid::cube::CutCube;
use crate::liquid::transport::{advect_surface, advect_velocity, pack};
use crate::liquid::viscosity::Diffusion;
use crate::liquid::volume::{Group, Measured, astray, band_labels, follow, targets};
use crate::model::Model;
use crate::simulation::PhaseEnd;
use crate::solid::Motion;
use crate::state::{Drop, State};
use crate::workspace::{BAND, LAYERS, Workspace, component_of};
use meniscus_numerics::Vector;
use meniscus_numerics::grid::{Runs, Sampler, Segment};
use meniscus_numerics::level_set::{redistance, slope};
use meniscus_numerics::linalg::{SolveError, SolveReport};
use meniscus_numerics::par;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Layers of the band on which curvature is found.
const CURVED: usize = 5;
/// Cells that the interface may move before φ is made a distance again.
const DRIFT: f64 = 0.7;
/// Deviation of |∇φ| from one at the interface before φ is made a distance again.
const SLOPE: f64 = 0.1;
/// Layers of the band on which φ is made a distance in every step: all that the curvature sees.
const NEAR: usize = 6;

/// What a step found out.
pub struct StepResult {
    /// The pressure solve.
    pub solve: SolveReport,
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
    if !model.solids.is_empty() {
        move_solids(model, state, work, dt);
        phase_end("solids");
    }

    // (1) The surface moves with the flow and becomes a distance again.
    let show = |what: &str, state: &State<D>| if std::env::var("DUMP").is_ok_and(|v| v.parse() == Ok(state.step)) {
        let l = model.grid.lattice();
        let v: Vec<String> = [(7,5),(8,5),(9,5),(8,6),(9,6),(9,7),(10,7),(10,8),(11,8)].iter().map(|&(i,j)| format!("({i},{j}) {:7.4}", state.phi.data[l.index(std::array::from_fn(|a| if a == 0 { i } else { j }))] / model.grid.dx)).collect();
        eprintln!("{what:12} {}", v.join(" "));
        if what == "start" { for j in (4..10).rev() {
            let r: Vec<String> = (5..15).map(|i| { let u = |a: usize| { let f = model.grid.faces(a); state.velocity.axes[a][f.index(std::array::from_fn(|b| if b == 0 { i } else { j }))] }; format!("({:6.3},{:6.3})", u(0), u(1)) }).collect();
            eprintln!("{j} {}", r.join(" ")); } }
    };
    show("start", state);
    let before = move_surface(model, state, work, dt);
    show("moved+ext", state);
    phase_end("advect surface");
    keep_distance(model, state, work);
    phase_end("redistance");
    show("redistance", state);

    // (2) Every component keeps its volume, and the centre of mass of what touches nothing its path.
    let labels = band_labels(model, &work.band, &state.phi, &work.liquid);
    let change = keep_volume(model, state, work, &before, &labels, dt);
    phase_end("volume");
    show("volume", state);

    // (3) The velocity is carried along.
    let displacement = displacements(model, state, work, dt);
    move_velocity(model, state, work, dt);
    phase_end("advect velocity");
    if model.kinematic_viscosity > 0.0 {
        let mut diffusion = Diffusion {
            velocity: &mut state.velocity,
            phi: &state.phi,
            band: &work.band,
            liquid: &work.liquid,
            faces: work.known.liquid(),
        };
        diffusion.advance(model, dt)?;
        phase_end("viscosity");
    }

    // (4) The forces.
    let kick = kick(state.lead, dt);
    let solve = push(model, state, work, &change, displacement, (dt, kick), phase_end)?;
    (state.lead, state.kick) = (state.lead + kick - dt, kick);
    state.time += dt;
    state.step += 1;
    state.last_dt = dt;
    Ok(StepResult { solve, volume_jump: change.jump })
}

/// Brings the velocity half a step ahead of the positions, where leapfrog wants it: once, before the first step.
fn start<const D: usize>(
    model: &Model<D>,
    state: &mut State<D>,
    work: &mut Workspace<D>,
    dt: f64,
    phase_end: PhaseEnd<'_>,
) -> Result<(), SolveError> {
    let labels = band_labels(model, &work.band, &state.phi, &work.liquid);
    let Measured { cubes, volumes, centers } = work.measured_liquid(model, &labels).measure(&state.phi);
    let one = |c: usize| Group { old: vec![c], new: vec![c], whole: None };
    let mut groups: Vec<Group<D>> = (0..volumes.len()).map(one).collect();
    expect(model, state, work, &mut groups, 0.0);
    let targets = state.drops.iter().map(|d| d.target_volume).collect();
    let change = Change { groups, cubes, targets, volumes, centers, jump: 0.0 };
    let still = displacements(model, state, work, 0.0);
    work.mark_afresh(model);
    push(model, state, work, &change, still, (dt, 0.5 * dt), phase_end)?;
    (state.lead, state.kick) = (0.5 * dt, 0.5 * dt);
    Ok(())
}

/// For how long the forces act at the end of a step (leapfrog with steps of any length; design, numerics §8), so that the velocity is then half a step ahead of the positions
/// again: `dt` where it already was. After a step of another length within bounds, which the steps to come make good.
fn kick(lead: f64, dt: f64) -> f64 {
    (1.5 * dt - lead).clamp(0.5 * dt, 1.5 * dt)
}

/// Adds what gravity, surface tension and pressure do to the velocity in the time `kick`, in a step of `dt`;
/// `displacement` as [`displacements`] found it.
fn push<const D: usize>(
    model: &Model<D>,
    state: &mut State<D>,
    work: &mut Workspace<D>,
    change: &Change<D>,
    displacement: Vec<Displacement<D>>,
    (dt, kick): (f64, f64),
    phase_end: PhaseEnd<'_>,
) -> Result<SolveReport, SolveError> {
    fall(model, state, work, kick);

    // Surface tension as a pressure on the surface.
    let capillary = model.surface_tension * dt * kick / (model.density * model.grid.dx.powi(3));
    let filter = FilterStep { capillary, displacement };
    let phi = Sampler::cells(&model.grid, &state.phi.data, model.scalar_edges());
    let ghosts = ghosts(model, &state.solids, &state.phi, &work.band, &work.cut);
    let beside = Beside { solids: &work.cut, ghosts: &ghosts };
    let kappa = curvature(&model.grid, &work.band, CURVED, &phi, &change.cubes, &beside, &filter);
    let cut = cut_faces(model, &state.phi, &work.band, &work.liquid, &kappa, &work.cut);
    phase_end("curvature");
    if std::env::var("DUMP").is_ok_and(|v| v.parse() == Ok(state.step)) {
        for f in &cut {
            let x = model.grid.center(model.grid.lattice().coordinates(f.cell));
            let c = x / model.grid.dx;
            if c[0] < 32.0 && c[1] < 14.0 { eprintln!("cut {:?} axis {} sign {} theta {:.3} kappa {:.5} open {:.2} u {:.4}", c.as_slice(), f.axis, f.sign, f.theta, f.kappa, f.open, state.velocity.axes[f.axis][f.face]); }
        }
        let l = model.grid.lattice();
        for j in (3..11).rev() {
            let row: Vec<String> = (2..22).map(|i| format!("{:6.2}", state.phi.data[l.index(std::array::from_fn(|a| if a == 0 { i } else { j }))] / model.grid.dx)).collect();
            eprintln!("{j} {}", row.join(" "));
        }
    }

    // One solve for the pressure.
    let jump = model.surface_tension * kick / (model.density * model.grid.dx);
    let mut projection = Projection {
        velocity: &mut state.velocity,
        lambda: &mut state.lambda,
        phi: &state.phi,
        liquid: &work.liquid,
        faces: work.known.liquid(),
        cut: &cut,
        cut_cells: &work.cut,
        solids: &mut state.solids,
        jump,
    };
    let solve = work.pressure.project(model, &mut projection)?;
    phase_end("pressure");
    if std::env::var("DUMP").is_ok_and(|v| v.parse() == Ok(state.step)) {
        eprintln!("after projection");
        for f in &cut {
            let x = model.grid.center(model.grid.lattice().coordinates(f.cell));
            let c = x / model.grid.dx;
            if c[0] < 32.0 && c[1] < 9.0 { eprintln!("CUT {:?} axis {} theta {:.3} jump {:.6} lambda {:.6} u {:.5}", c.as_slice(), f.axis, f.theta, f.kappa * jump, state.lambda.data[f.cell], state.velocity.axes[f.axis][f.face]); }
        }
    }

    // Momentum that the discretisation lost comes back; the velocity extends beyond the liquid.
    let moments = keep_momentum(model, state, work, &cut, change, kick);
    work.extend(model, state);
    state.drops = drops(model, work, &cut, &moments, change);
    state.kinetic_energy = kinetic_energy(model, &moments);
    state.surface_area = surface_energy(model, &change.cubes);
    phase_end("momentum and extension");
    Ok(solve)
}

/// Moves φ; gives back the liquid cells before.
pub fn move_surface<const D: usize>(
    model: &Model<D>,
    state: &mut State<D>,
    work: &mut Workspace<D>,
    dt: f64,
) -> Runs {
    let values = advect_surface(model, &state.phi, &work.band, &state.velocity, dt);
    work.band.cells.iter().zip(values).for_each(|(&c, v)| state.phi.data[c as usize] = v);
    if std::env::var("DUMP").is_ok_and(|v| v.parse() == Ok(state.step)) {
        let l = model.grid.lattice();
        let v: Vec<String> = [(7,5),(8,5),(9,5),(8,6),(9,6),(9,7),(10,7),(10,8),(11,8)].iter().map(|&(i,j)| format!("({i},{j}) {:7.4}", state.phi.data[l.index(std::array::from_fn(|a| if a == 0 { i } else { j }))] / model.grid.dx)).collect();
        eprintln!("advected     {}", v.join(" "));
    }
    extend_into_solids(model, &state.solids, &mut state.phi, &work.band, &work.cut);
    state.drift += max_component(model, state, work) * dt / model.grid.dx;
    let before = std::mem::take(&mut work.liquid);
    let left = work.band.cells.clone();
    work.find_liquid(model, state);
    let limit = BAND * model.grid.dx;
    for cell in left {
        if work.band.slot(cell as usize).is_none() {
            let value = &mut state.phi.data[cell as usize];
            *value = limit.copysign(*value);
        }
    }
    before
}

/// Makes φ a distance again: around the surface in every step, farther off when the surface has moved enough or its
/// slope has become wrong.
///
/// The curvature is only as smooth as φ: noise of the transport that is left from step to step grows (measured: a
/// drop's frequency wrong by 5 %, where it is 0.3 % if φ is a distance in every step).
pub(crate) fn keep_distance<const D: usize>(model: &Model<D>, state: &mut State<D>, work: &Workspace<D>) {
    let sampler = Sampler::cells(&model.grid, &state.phi.data, model.scalar_edges());
    let edge = &work.band.cells[work.band.first_layers(1)];
    let wrong = |c: &&u32| (slope(&model.grid, &state.phi.data, &sampler, **c as usize) - 1.0).abs() > SLOPE;
    let all = state.drift > DRIFT || edge.par_iter().filter(wrong).count() * 100 > edge.len();
    let layers = if all { LAYERS } else { NEAR };
    let values = redistance(&model.grid, &work.band, layers, &state.phi.data, &sampler, BAND * model.grid.dx);
    work.band.cells.iter().zip(values).for_each(|(&c, v)| state.phi.data[c as usize] = v);
    if all {
        state.drift = 0.0;
    }
}

/// What became of the components in a step.
pub struct Change<const D: usize> {
    groups: Vec<Group<D>>,
    cubes: Vec<CutCube>,
    /// Volumes that the components must have.
    pub targets: Vec<f64>,
    volumes: Vec<f64>,
    centers: Vec<Vector<D>>,
    jump: f64,
}

/// Follows the components and puts their volumes and centres right.
pub fn keep_volume<const D: usize>(
    model: &Model<D>,
    state: &mut State<D>,
    work: &Workspace<D>,
    before: &Runs,
    labels: &[u32],
    dt: f64,
) -> Change<D> {
    let liquid = work.measured_liquid(model, labels);
    let measured = liquid.measure(&state.phi);
    let raw = measured.volumes.clone();
    let mut groups = follow(before, &work.liquid, &state.drops, &measured.centers, dt);
    expect(model, state, work, &mut groups, dt);
    let (targets, lost) = targets(&groups, &state.drops, &raw);
    state.lost_volume += lost;
    let jump = (0..raw.len()).map(|c| depth(model, raw[c] - targets[c], targets[c])).fold(0.0, f64::max);
    let limit = BAND * model.grid.dx;
    let Measured { cubes, volumes, mut centers } =
        liquid.correct(&mut state.phi, measured, &targets, &groups, limit);
    // Where the surface could not follow all the way, the books do.
    let rest = astray(&groups, &targets, &centers);
    centers.iter_mut().zip(rest).for_each(|(center, rest)| *center += rest);
    Change { groups, cubes, targets, volumes, centers, jump }
}

/// Thickness, in cells, of a layer of volume `change` on a ball of volume `whole`.
fn depth<const D: usize>(model: &Model<D>, change: f64, whole: f64) -> f64 {
    let unit = if D == 2 { PI } else { 4.0 / 3.0 * PI };
    let radius = (whole / unit).max(0.0).powf(1.0 / D as f64).max(0.5 * model.grid.dx);
    change.abs() / (D as f64 * unit * radius.powi(D as i32 - 1) * model.grid.dx)
}

/// Finds out what every group that touches no side of the domain must be after the step.
fn expect<const D: usize>(
    model: &Model<D>,
    state: &State<D>,
    work: &Workspace<D>,
    groups: &mut [Group<D>],
    dt: f64,
) {
    if !model.numerics.restore_momentum {
        return;
    }
    let (near, upper) = (0.75 * model.grid.dx, model.grid.upper());
    let boxes = boxes(model, &work.liquid);
    let wetting = work.wetting(model);
    let touches =
        |&j: &usize| wetting[j] || (0..D).any(|a| boxes[j].0[a] < near || boxes[j].1[a] > upper[a] - near);
    for group in groups {
        if !group.old.is_empty() && !group.new.is_empty() && !group.new.iter().any(touches) {
            let mut whole = together(group.old.iter().map(|&i| state.drops[i].whole()));
            whole.center += whole.velocity * dt;
            group.whole = Some(whole);
        }
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

/// The books of a new state: drops, energies. The velocity must be known on the liquid's faces.
pub fn open_books<const D: usize>(model: &Model<D>, state: &mut State<D>, work: &Workspace<D>) {
    let labels = band_labels(model, &work.band, &state.phi, &work.liquid);
    let Measured { cubes, volumes, centers } = work.measured_liquid(model, &labels).measure(&state.phi);
    let change = Change { groups: Vec::new(), cubes, targets: volumes.clone(), volumes, centers, jump: 0.0 };
    let flat = Curvature { kappa: Vec::new(), known: Vec::new() };
    let cut = cut_faces(model, &state.phi, &work.band, &work.liquid, &flat, &work.cut);
    let moments = keep_momentum(model, state, work, &cut, &change, 0.0);
    state.drops = drops(model, work, &cut, &moments, &change);
    state.kinetic_energy = kinetic_energy(model, &moments);
    state.surface_area = surface_energy(model, &change.cubes);
}

/// The surface's energy over its tension, m² (2D: m).
fn surface_energy<const D: usize>(model: &Model<D>, cubes: &[CutCube]) -> f64 {
    cubes.iter().map(CutCube::energy).sum::<f64>() * model.grid.face_area()
}

fn keep_momentum<const D: usize>(
    model: &Model<D>,
    state: &mut State<D>,
    work: &Workspace<D>,
    cut: &[CutFace],
    change: &Change<D>,
    dt: f64,
) -> Vec<Moments<D>> {
    let rows = work.liquid.row_starts(&model.grid);
    let label = |cell: usize| component_of(&work.liquid, &rows, model.grid.cells[0], cell);
    let walk = FaceWalk {
        model,
        phi: &state.phi,
        faces: work.known.liquid(),
        open: (!work.cut.wet.is_empty()).then_some(&work.cut.open),
        cut,
        label: &label,
        components: work.liquid.components as usize,
    };
    walk.restore(&mut state.velocity, &change.groups, &change.targets, &change.centers, dt)
}

/// ½ ρ ∫ u², J.
fn kinetic_energy<const D: usize>(model: &Model<D>, moments: &[Moments<D>]) -> f64 {
    0.5 * model.density * model.grid.cell_volume() * moments.iter().map(|m| m.energy).sum::<f64>()
}

/// Box of the cell centres of every component.
fn boxes<const D: usize>(model: &Model<D>, liquid: &Runs) -> Vec<(Vector<D>, Vector<D>)> {
    let lattice = model.grid.lattice();
    let far: Vector<D> = Vector::repeat(f64::INFINITY);
    let mut out = vec![(far, -far); liquid.components as usize];
    for run in &liquid.runs {
        let at = lattice.coordinates(run.row as usize * lattice.extent[0]);
        let end = |i: u32| {
            let mut cell = at;
            cell[0] = i as usize;
            model.grid.center(cell)
        };
        let (low, high) = &mut out[run.component as usize];
        *low = low.inf(&end(run.start));
        *high = high.sup(&end(run.end - 1));
    }
    out
}

/// The components as drops.
fn drops<const D: usize>(
    model: &Model<D>,
    work: &Workspace<D>,
    cut: &[CutFace],
    moments: &[Moments<D>],
    change: &Change<D>,
) -> Vec<Drop<D>> {
    let rows = work.liquid.row_starts(&model.grid);
    let half = 0.5 * model.grid.dx;
    let mut drops: Vec<Drop<D>> = boxes(model, &work.liquid)
        .into_iter()
        .zip(moments)
        .enumerate()
        .map(|(c, ((low, high), m))| {
            let whole = m.weighing(change.targets[c]).whole(change.centers[c]);
            Drop {
                target_volume: change.targets[c],
                volume: change.volumes[c],
                centroid: whole.center,
                // Outermost centres, or the wall behind them; the surface's place follows.
                lower: low.map(|x| if x < 1.5 * half { 0.0 } else { x }),
                upper: Vector::from_fn(|a, _| {
                    let side = model.grid.upper()[a];
                    if high[a] > side - 1.5 * half { side } else { high[a] }
                }),
                velocity: whole.velocity,
                spin: whole.spin,
            }
        })
        .collect();
    for f in cut {
        let drop = &mut drops[component_of(&work.liquid, &rows, model.grid.cells[0], f.cell) as usize];
        let x = model.grid.center(model.grid.lattice().coordinates(f.cell))[f.axis];
        let surface = x + f.sign * f.theta * model.grid.dx;
        drop.lower[f.axis] = drop.lower[f.axis].min(surface);
        drop.upper[f.axis] = drop.upper[f.axis].max(surface);
    }
    drops
}

/// Largest velocity component on the liquid's faces, m/s.
pub fn max_component<const D: usize>(model: &Model<D>, state: &State<D>, work: &Workspace<D>) -> f64 {
    (0..D)
        .map(|a| {
            let row = model.grid.faces(a).extent[0];
            let values = &state.velocity.axes[a];
            let stretch = |s: &Segment| {
                values[s.row * row + s.start..s.row * row + s.end].iter().fold(0.0f64, |m, v| m.max(v.abs()))
            };
            work.known.liquid()[a].par_iter().map(stretch).reduce(|| 0.0, f64::max)
        })
        .fold(0.0, f64::max)
}

/// Energy of the liquid in gravity, J.
pub fn potential_energy<const D: usize>(model: &Model<D>, state: &State<D>) -> f64 {
    let lift = |d: &Drop<D>| -d.target_volume * model.gravity.dot(&d.centroid);
    model.density * state.drops.iter().map(lift).sum::<f64>()
}

/// The books of a state.
pub fn ledger<const D: usize>(model: &Model<D>, state: &State<D>, work: &Workspace<D>) -> Ledger<D> {
    let drops = &state.drops;
    let all = together(drops.iter().map(Drop::whole));
    let mass = model.density * all.mass;
    let excess = || drops.iter().map(|d| d.volume - d.target_volume);
    let misplaced = excess().map(f64::abs).sum::<f64>().copysign(excess().sum());
    Ledger {
        volume: drops.iter().map(|d| d.volume).sum(),
        target_volume: all.mass,
        volume_error: misplaced / all.mass.max(f64::MIN_POSITIVE),
        centroid: all.center,
        momentum: all.velocity * mass,
        angular_momentum: all.about(&Vector::zeros()).map(|l| model.density * l),
        kinetic_energy: state.kinetic_energy,
        surface_energy: model.surface_tension * state.surface_area,
        potential_energy: potential_energy(model, state),
        max_speed: max_component(model, state, work),
        divergence_max: crate::liquid::pressure::divergence_max(model, state, &work.liquid, &work.cut),
    }
}
