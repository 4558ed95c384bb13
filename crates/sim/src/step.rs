//! One time step of the liquid.
//!
//! Positions first, then one solve for the velocity: a capillary wave then obeys symplectic Euler, which neither
//! damps nor drives it (design, numerics §8).

use crate::ledger::Ledger;
use crate::liquid::curvature::{Curvature, FilterStep, curvature};
use crate::liquid::momentum::{FaceWalk, Moments};
use crate::liquid::pressure::{CutFace, Projection, cut_faces};
use crate::liquid::surface::CutCube;
use crate::liquid::transport::{advect_surface, advect_velocity, pack};
use crate::liquid::viscosity::Diffusion;
use crate::liquid::volume::{Group, Measured, band_labels, follow, targets};
use crate::model::Model;
use crate::simulation::PhaseEnd;
use crate::state::{Drop, State};
use crate::workspace::{BAND, Workspace, component_of};
use meniscus_numerics::Vector;
use meniscus_numerics::grid::{Runs, Sampler, Segment};
use meniscus_numerics::level_set::{redistance, slope};
use meniscus_numerics::linalg::{SolveError, SolveReport};
use meniscus_numerics::par;
use rayon::prelude::*;

/// Layers of the band on which curvature is found.
const CURVED: usize = 5;
/// Cells that the interface may move before φ is made a distance again.
const DRIFT: f64 = 0.7;
/// Deviation of |∇φ| from one at the interface before φ is made a distance again.
const SLOPE: f64 = 0.1;

/// What a step found out.
pub struct StepResult {
    /// The pressure solve.
    pub solve: SolveReport,
    /// Largest relative change of a component's volume before it was put right.
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
    // (1) The surface moves with the flow and becomes a distance again where needed.
    let before = move_surface(model, state, work, dt);
    phase_end("advect surface");
    keep_distance(model, state, work);
    phase_end("redistance");

    // (2) Every component keeps its volume.
    let labels = band_labels(model, &work.band, &state.phi, &work.liquid);
    let change = keep_volume(model, state, work, &before, &labels, dt);
    phase_end("volume");

    // (3) The velocity is carried along and falls.
    let displacement = normal_displacement(model, state, work, dt);
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

    // (4) Surface tension as a pressure on the surface.
    let capillary = model.surface_tension * dt * dt / (model.density * model.grid.dx.powi(3));
    let filter = FilterStep { capillary, displacement };
    let kappa = curvature(&model.grid, &work.band, CURVED, &change.cubes, &filter);
    let cut = cut_faces(model, &state.phi, &work.band, &work.liquid, &kappa);
    phase_end("curvature");

    // (5) One solve for the pressure.
    let jump = model.surface_tension * dt / (model.density * model.grid.dx);
    let mut projection = Projection {
        velocity: &mut state.velocity,
        lambda: &mut state.lambda,
        phi: &state.phi,
        liquid: &work.liquid,
        faces: work.known.liquid(),
        cut: &cut,
        jump,
    };
    let solve = work.pressure.project(model, &mut projection)?;
    phase_end("pressure");

    // (6) Momentum that the discretisation lost comes back; the velocity extends beyond the liquid.
    let moments = keep_momentum(model, state, work, &cut, &change, dt);
    work.extend(model, state);
    state.drops = drops(model, work, &cut, &moments, &change);
    state.kinetic_energy = kinetic_energy(model, &moments);
    state.surface_area = change.cubes.iter().map(|c| c.area).sum::<f64>() * model.grid.face_area();
    phase_end("momentum and extension");

    state.time += dt;
    state.step += 1;
    state.last_dt = dt;
    Ok(StepResult { solve, volume_jump: change.jump })
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

/// Makes φ a distance again when the surface has moved enough or its slope has become wrong.
///
/// This costs a gently swinging drop about 2 % of amplitude a period at 16 cells a radius (it moves the linear crossings
/// by 1e-3 cells). Keeping φ near the surface while its slope is right removes that loss but was measured to fail where
/// drops merge.
pub(crate) fn keep_distance<const D: usize>(model: &Model<D>, state: &mut State<D>, work: &Workspace<D>) {
    let dx = model.grid.dx;
    let sampler = Sampler::cells(&model.grid, &state.phi.data, model.scalar_edges());
    let edge = &work.band.cells[work.band.first_layers(1)];
    let deviation = |&c: &u32| (slope(&model.grid, &state.phi.data, &sampler, c as usize) - 1.0).abs();
    let skewed = edge.par_iter().map(deviation).filter(|d| *d > SLOPE).count() * 100 > edge.len();
    if state.drift <= DRIFT && !skewed {
        return;
    }
    let values = redistance(&model.grid, &work.band, &state.phi.data, &sampler, BAND * dx);
    work.band.cells.iter().zip(values).for_each(|(&c, v)| state.phi.data[c as usize] = v);
    state.drift = 0.0;
}

/// What became of the components in a step.
pub struct Change {
    groups: Vec<Group>,
    cubes: Vec<CutCube>,
    /// Volumes that the components must have.
    pub targets: Vec<f64>,
    volumes: Vec<f64>,
    jump: f64,
}

/// Follows the components and puts their volumes right.
pub fn keep_volume<const D: usize>(
    model: &Model<D>,
    state: &mut State<D>,
    work: &Workspace<D>,
    before: &Runs,
    labels: &[u32],
    dt: f64,
) -> Change {
    let liquid = work.measured_liquid(model, labels);
    let measured = liquid.measure(&state.phi);
    let raw = measured.volumes.clone();
    let centers: Vec<Vector<D>> = boxes(model, &work.liquid).iter().map(|(c, _, _)| *c).collect();
    let groups = follow(before, &work.liquid, &state.drops, &centers, dt);
    let (targets, lost) = targets(&groups, &state.drops, &raw);
    state.lost_volume += lost;
    let relative = |c: usize| (raw[c] - targets[c]).abs() / targets[c].abs().max(1e-300);
    let jump = (0..raw.len()).map(relative).fold(0.0, f64::max);
    let limit = BAND * model.grid.dx;
    let Measured { cubes, volumes } = liquid.correct(&mut state.phi, measured, &targets, limit);
    Change { groups, cubes, targets, volumes, jump }
}

/// How far the surface moves along its normal in a step, in cells, on the first layers of the band.
fn normal_displacement<const D: usize>(
    model: &Model<D>,
    state: &State<D>,
    work: &Workspace<D>,
    dt: f64,
) -> Vec<f64> {
    let sampler = Sampler::cells(&model.grid, &state.phi.data, model.scalar_edges());
    let lattice = model.grid.lattice();
    work.band.cells[work.band.first_layers(CURVED)]
        .par_iter()
        .map(|&c| {
            let at = lattice.coordinates(c as usize);
            let (mut along, mut square) = (0.0, 0.0);
            for a in 0..D {
                let faces = model.grid.faces(a);
                let f = faces.index(at);
                let u = 0.5 * (state.velocity.axes[a][f] + state.velocity.axes[a][f + faces.stride[a]]);
                let (mut up, mut down) = (at.map(|i| i as isize), at.map(|i| i as isize));
                up[a] += 1;
                down[a] -= 1;
                let slope = sampler.value(up) - sampler.value(down);
                along += u * slope;
                square += slope * slope;
            }
            if square > 0.0 { along / square.sqrt() * dt / model.grid.dx } else { 0.0 }
        })
        .collect()
}

/// Carries the velocity to the new liquid's faces and adds gravity.
fn move_velocity<const D: usize>(model: &Model<D>, state: &mut State<D>, work: &mut Workspace<D>, dt: f64) {
    let faces: [Vec<Segment>; D] = std::array::from_fn(|a| work.liquid.faces(&model.grid, a));
    let values = advect_velocity(model, &state.velocity, &faces, dt);
    work.known.clear(&mut state.velocity);
    for a in 0..D {
        let fall = model.gravity[a] * dt;
        let lattice = model.grid.faces(a);
        let packed = pack(&faces[a]);
        let starts: Vec<usize> = packed.iter().map(|s| s.start).collect();
        let index = |s: &Segment| faces[a].partition_point(|o| (o.row, o.start) < (s.row, s.start));
        par::for_each_segment(&mut state.velocity.axes[a], lattice.extent[0], &faces[a], |s, part| {
            let from = starts[index(s)];
            let mut at = lattice.coordinates(s.row * lattice.extent[0]);
            for (i, u) in part.iter_mut().enumerate() {
                at[0] = s.start + i;
                *u = if model.closed(a, at[a]) { 0.0 } else { values[a][from + i] + fall };
            }
        });
    }
    work.known.set_liquid(faces);
}

/// The books of a new state: drops, energies. The velocity must be known on the liquid's faces.
pub fn open_books<const D: usize>(model: &Model<D>, state: &mut State<D>, work: &Workspace<D>) {
    let labels = band_labels(model, &work.band, &state.phi, &work.liquid);
    let Measured { cubes, volumes } = work.measured_liquid(model, &labels).measure(&state.phi);
    let change = Change { groups: Vec::new(), cubes, targets: volumes.clone(), volumes, jump: 0.0 };
    let flat = Curvature { kappa: Vec::new(), known: Vec::new() };
    let cut = cut_faces(model, &state.phi, &work.band, &work.liquid, &flat);
    let moments = keep_momentum(model, state, work, &cut, &change, 0.0);
    state.drops = drops(model, work, &cut, &moments, &change);
    state.kinetic_energy = kinetic_energy(model, &moments);
    state.surface_area = change.cubes.iter().map(|c| c.area).sum::<f64>() * model.grid.face_area();
}

fn keep_momentum<const D: usize>(
    model: &Model<D>,
    state: &mut State<D>,
    work: &Workspace<D>,
    cut: &[CutFace],
    change: &Change,
    dt: f64,
) -> Vec<Moments<D>> {
    let rows = work.liquid.row_starts(&model.grid);
    let label = |cell: usize| component_of(&work.liquid, &rows, model.grid.cells[0], cell);
    let walk = FaceWalk {
        model,
        phi: &state.phi,
        faces: work.known.liquid(),
        cut,
        label: &label,
        components: work.liquid.components as usize,
    };
    if !model.numerics.restore_momentum {
        return walk.moments(&state.velocity);
    }
    let upper = model.grid.upper();
    let half = 0.75 * model.grid.dx;
    let touching: Vec<bool> = boxes(model, &work.liquid)
        .iter()
        .map(|(_, low, high)| (0..D).any(|a| low[a] < half || high[a] > upper[a] - half))
        .collect();
    walk.restore(&mut state.velocity, &change.groups, &state.drops, &change.targets, &touching, dt)
}

/// ½ ρ ∫ u², J.
fn kinetic_energy<const D: usize>(model: &Model<D>, moments: &[Moments<D>]) -> f64 {
    0.5 * model.density * model.grid.cell_volume() * moments.iter().map(|m| m.energy).sum::<f64>()
}

/// Centre and box of the cell centres of every component.
fn boxes<const D: usize>(model: &Model<D>, liquid: &Runs) -> Vec<(Vector<D>, Vector<D>, Vector<D>)> {
    let lattice = model.grid.lattice();
    let far: Vector<D> = Vector::repeat(f64::INFINITY);
    let mut out = vec![(0.0, Vector::<D>::zeros(), far, -far); liquid.components as usize];
    for run in &liquid.runs {
        let at = lattice.coordinates(run.row as usize * lattice.extent[0]);
        let end = |i: u32| {
            let mut cell = at;
            cell[0] = i as usize;
            model.grid.center(cell)
        };
        let (first, last, n) = (end(run.start), end(run.end - 1), (run.end - run.start) as f64);
        let b = &mut out[run.component as usize];
        b.0 += n;
        b.1 += (first + last) * (0.5 * n);
        b.2 = b.2.inf(&first);
        b.3 = b.3.sup(&last);
    }
    out.into_iter().map(|(n, sum, low, high)| (sum / n, low, high)).collect()
}

/// The components as drops.
fn drops<const D: usize>(
    model: &Model<D>,
    work: &Workspace<D>,
    cut: &[CutFace],
    moments: &[Moments<D>],
    change: &Change,
) -> Vec<Drop<D>> {
    let rows = work.liquid.row_starts(&model.grid);
    let half = 0.5 * model.grid.dx;
    let mut drops: Vec<Drop<D>> = boxes(model, &work.liquid)
        .into_iter()
        .zip(moments)
        .enumerate()
        .map(|(c, ((_, low, high), m))| {
            Drop {
                target_volume: change.targets[c],
                volume: change.volumes[c],
                centroid: m.centroid(),
                // Outermost centres, or the wall behind them; the surface's place follows.
                lower: low.map(|x| if x < 1.5 * half { 0.0 } else { x }),
                upper: Vector::from_fn(|a, _| {
                    let side = model.grid.upper()[a];
                    if high[a] > side - 1.5 * half { side } else { high[a] }
                }),
                velocity: m.velocity(),
                spin: m.weighing(change.targets[c]).spin(),
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

/// The books of a state.
pub fn ledger<const D: usize>(model: &Model<D>, state: &State<D>, work: &Workspace<D>) -> Ledger<D> {
    let drops = &state.drops;
    let total: f64 = drops.iter().map(|d| d.target_volume).sum();
    let sum = |f: &dyn Fn(&Drop<D>) -> Vector<D>| {
        drops.iter().fold(Vector::zeros(), |s: Vector<D>, d| s + f(d) * d.target_volume)
    };
    let momentum = sum(&|d| d.velocity) * model.density;
    let centroid = if total > 0.0 { sum(&|d| d.centroid) / total } else { Vector::zeros() };
    let mut angular = [0.0; 3];
    for d in drops {
        for &(a, b, place) in &crate::liquid::momentum::PLANES[..if D == 2 { 1 } else { 3 }] {
            let orbit = d.centroid[a] * d.velocity[b] - d.centroid[b] * d.velocity[a];
            angular[place] += model.density * (d.spin[place] + d.target_volume * orbit);
        }
    }
    let error = |d: &Drop<D>| (d.volume / d.target_volume - 1.0).abs();
    Ledger {
        volume: drops.iter().map(|d| d.volume).sum(),
        target_volume: total,
        volume_error: drops.iter().map(error).fold(0.0, f64::max),
        centroid,
        momentum,
        angular_momentum: angular,
        kinetic_energy: state.kinetic_energy,
        surface_energy: model.surface_tension * state.surface_area,
        potential_energy: -model.density * total * model.gravity.dot(&centroid),
        max_speed: max_component(model, state, work),
        divergence_max: crate::liquid::pressure::divergence_max(model, &state.velocity, &work.liquid),
    }
}
