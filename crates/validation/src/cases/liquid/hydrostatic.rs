//! A tank at rest.

use crate::measure::{at_most, bars, checks_or_failure};
use crate::setup::{TENSION, at_rest, model};
use crate::{Case, Check, Mode};
use meniscus_numerics::Vector;
use meniscus_numerics::grid::Grid;
use meniscus_sim::{Compiled, Simulation, StepError, Wall};

/// The case.
pub const CASE: Case = Case {
    name: "hydrostatic",
    title: "Tank at rest",
    theory: "Liquid with a level between the grid's points in a tank with slip walls (height H = 0.5, g = 10) stays \
        at rest: the pressure is ρg(H − y). Largest speed over √(gH) in the last of 200 steps of default length, \
        pressure tolerance 1e-10, with and without surface tension; and the pressure at the bottom.",
    quick: true,
    run: |mode| checks_or_failure("hydrostatic", run(mode)),
};

const GRAVITY: f64 = 10.0;

fn run(mode: Mode) -> Result<Vec<Check>, StepError> {
    let cells = if mode == Mode::Quick { 16 } else { 32 };
    let mut checks = Vec::new();
    for tension in [0.0, TENSION] {
        checks.extend(tank::<2>(cells, tension)?);
        checks.extend(tank::<3>(cells, tension)?);
    }
    Ok(checks)
}

fn tank<const D: usize>(cells: usize, tension: f64) -> Result<Vec<Check>, StepError>
where
    Simulation<D>: Compiled<D>,
{
    let dx = 1.0 / cells as f64;
    let height = 0.5 + 0.367_879_441 * dx;
    let mut model = model(Grid::<D>::new([cells; D], dx), [[Wall::Slip; 2]; D]);
    model.surface_tension = tension;
    model.gravity[D - 1] = -GRAVITY;
    model.numerics.tolerance = 1e-10;
    model.numerics.max_step = 0.01;
    let distance = |x: &Vector<D>| x[D - 1] - height;
    let mut sim = at_rest(model, &distance);
    let (mut speed, mut steps) = (0.0, 0);
    while steps < 200 {
        speed = sim.step(f64::INFINITY, &mut |_| ())?.diagnostics.max_speed;
        steps += 1;
    }
    let pressure = sim.state.pressure(sim.model.density, 0);
    let bottom = sim.model.density * GRAVITY * (height - 0.5 * dx);
    let unit = (GRAVITY * height).sqrt();
    let speeds = format!("max|u| / √(gH), {D}D, γ = {tension}");
    let bottoms = format!("pressure at the bottom, {D}D, γ = {tension}");
    Ok(vec![
        at_most("hydrostatic", speeds, speed / unit, bars(1e-6, 1e-12)),
        Check::relative("hydrostatic", bottoms, pressure, bottom, bars(1e-6, 1e-10)),
    ])
}
