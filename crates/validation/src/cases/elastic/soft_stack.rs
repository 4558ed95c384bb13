//! A stack of five deformable blocks.

use crate::measure::{at_most, bars, checks_or_failure};
use crate::setup::run_to;
use crate::soft::SoftMaterial;
use crate::solids_only::{
    ContactMonitor, GRAVITY, box_mesh, gravity, point_at, simulation_without_liquid, soft,
    vertex_area_vectors, vertices,
};
use crate::{Case, Check, Mode};
use meniscus_numerics::Vector;
use meniscus_numerics::grid::Grid;
use meniscus_sim::{Compiled, Simulation, StepError};

/// The case.
pub const CASE: Case = Case {
    name: "soft-stack",
    title: "Five soft blocks stand on each other",
    theory: "No liquid. Blocks 0.25 wide and 0.15 high on the floor of a box (E = 1e4, density 2, g = 10, friction 0.3, damped), one \
        second after they were put there, and for a second more. Statics: what presses on the lower side of block k is the \
        weight of all blocks from k on, W_k; without lateral contraction (ν = 0) a block is pressed together by the mean of the \
        loads on both of its sides, (W_k + W_(k+1))/2 over E A. Nothing pushes the blocks sideways, and the friction that is \
        needed for it is none: they stay where they are (a drift of 1e-3 of a width in a second would bring them down in ten \
        minutes). 6 cells a block's height (3D: 3), gap: 0.25 cells of 1/32; quick: 2D.",
    quick: true,
    run: |mode| checks_or_failure(NAME, run(mode)),
};

const NAME: &str = "soft-stack";
const BLOCKS: usize = 5;
const HALF_SIZE: [f64; 2] = [0.125, 0.075];
const DX: f64 = 1.0 / 32.0;
const YOUNG: f64 = 1e4;
const DENSITY: f64 = 2.0;
const STEP: f64 = 2.5e-3;
/// Time for the blocks to come to rest, and duration of the measurement.
const SETTLING_TIME: f64 = 1.0;

fn run(mode: Mode) -> Result<Vec<Check>, StepError> {
    let mut checks = check_stack::<2>([10, 6], 0.3, mode)?;
    checks.extend(check_stack::<2>([10, 6], 0.0, mode)?);
    if mode == Mode::Full {
        checks.extend(check_stack::<3>([4; 3], 0.3, mode)?);
    }
    Ok(checks)
}

fn stack<const D: usize>(n: [usize; D], poisson: f64) -> Result<Simulation<D>, StepError>
where
    Simulation<D>: Compiled<D>,
{
    let material = SoftMaterial { young: YOUNG, poisson, density: DENSITY, damping: 0.5 };
    let half = Vector::<D>::from_fn(|a, _| HALF_SIZE[usize::from(a + 1 == D)]);
    // Close to their distance at rest.
    let gap = 0.15 * DX;
    let place = |k: usize| point_at::<D>(0.5, gap + HALF_SIZE[1] + k as f64 * (2.0 * HALF_SIZE[1] + gap));
    let solids: Result<Vec<_>, _> =
        (0..BLOCKS).map(|k| soft(box_mesh(n, place(k), half), material, 0.3, Vec::new())).collect();
    Ok(simulation_without_liquid(Grid::new([32; D], DX), solids?, gravity(), STEP))
}

/// Height of a block between the means over its upper and its lower side. By virtual work with a uniform compression, its change without
/// lateral contraction depends on the loads alone, not on their distribution.
fn height<const D: usize>(simulation: &Simulation<D>, solid: usize) -> f64 {
    let Some(elastic) = simulation.model.solids[solid].elastic() else { return f64::NAN };
    let now = vertices(simulation, solid);
    let (mut sums, mut sizes) = ([0.0; 2], [0.0; 2]);
    for (x, area) in now.iter().zip(vertex_area_vectors(elastic, &elastic.rest_mesh().positions)) {
        let (area, side) = (area[D - 1].abs(), usize::from(area[D - 1] > 0.0));
        sums[side] += area * x[D - 1];
        sizes[side] += area;
    }
    sums[1] / sizes[1] - sums[0] / sizes[0]
}

/// Measurements of a stack at rest.
struct StackMeasure {
    /// Sums over the steps of the accelerations that the contacts give the blocks, upwards over gravity.
    contact_loads: [f64; BLOCKS],
    steps: f64,
    /// Largest displacements to the side and up or down.
    drift: [f64; 2],
}

/// Lets a stack come to rest, and measures it for a time.
fn measure_stack<const D: usize>(
    simulation: &mut Simulation<D>,
    watch: &mut ContactMonitor<D>,
    rest: f64,
    time: f64,
) -> Result<StackMeasure, StepError> {
    run_to(simulation, rest, |s, report| watch.observe(s, &report.diagnostics, true))?;
    let start: Vec<Vector<D>> = simulation.state.solids.iter().map(|s| s.center_of_mass()).collect();
    let mut found = StackMeasure { contact_loads: [0.0; BLOCKS], steps: 0.0, drift: [0.0; 2] };
    run_to(simulation, rest + time, |s, report| {
        watch.observe(s, &report.diagnostics, true);
        let solids = &s.state.solids;
        found.steps += 1.0;
        for ((now, then), load) in solids.iter().zip(&start).zip(&mut found.contact_loads) {
            *load += now.contact_acceleration[D - 1] / GRAVITY;
            let off = now.center_of_mass() - then;
            found.drift[0] = found.drift[0].max(off.rows(0, D - 1).norm());
            found.drift[1] = found.drift[1].max(off[D - 1].abs());
        }
    })?;
    Ok(found)
}

fn check_stack<const D: usize>(n: [usize; D], poisson: f64, mode: Mode) -> Result<Vec<Check>, StepError>
where
    Simulation<D>: Compiled<D>,
{
    let mut simulation = stack::<D>(n, poisson)?;
    let (rest, time) = if mode == Mode::Quick { (0.5, 0.25) } else { (SETTLING_TIME, 1.0) };
    let weights: Vec<f64> =
        simulation.model.solids.iter().map(|s| s.mass_properties.mass * GRAVITY).collect();
    let fall = weights.iter().sum::<f64>() * 2.0 * HALF_SIZE[1];
    let mut watch = ContactMonitor::new(&simulation.model, fall);
    let StackMeasure { contact_loads, steps, drift } =
        measure_stack(&mut simulation, &mut watch, rest, time)?;
    let what = |text: &str| format!("{text}, {D}D, ν = {poisson}");
    let mut checks = Vec::new();
    let bottom = (2.0 * HALF_SIZE[0]).powi(D as i32 - 1);
    for k in 0..BLOCKS {
        let above: f64 = weights[k..].iter().sum();
        let pushed: f64 = (k..BLOCKS).map(|j| weights[j] * contact_loads[j] / steps).sum();
        let text = what(&format!("force below block {} over the weight above", k + 1));
        checks.push(Check::relative(NAME, text, pushed / above, 1.0, bars(0.01, 1e-3)));
        if poisson == 0.0 {
            let told = (above - 0.5 * weights[k]) / (bottom * YOUNG);
            let pressed = 1.0 - height(&simulation, k) / (2.0 * HALF_SIZE[1]);
            let text = what(&format!("block {} is pressed together", k + 1));
            checks.push(Check::relative(NAME, text, pressed, told, bars(0.01, 3e-3)));
        }
    }
    let [aside, down] = drift.map(|way| way * (1.0 / (2.0 * HALF_SIZE[0] * time)));
    let creep = bars(1e-3, 1e-6);
    checks.extend([
        at_most(NAME, what("creep to the side in a second / width"), aside, creep),
        at_most(NAME, what("creep down in a second / width"), down, creep),
        watch.check_gap(NAME, what("narrowest gap / cell"), DX, 0.02),
        watch.check_rise(NAME, what("largest rise of the energy in a step / weight × height")),
    ]);
    Ok(checks)
}
