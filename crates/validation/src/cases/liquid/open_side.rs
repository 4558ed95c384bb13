//! Outflow through open sides.

use crate::measure::{at_most, bars, checks_or_failure};
use crate::setup::{at_rest, in_flight, model};
use crate::{Case, Check, Mode};
use meniscus_numerics::Vector;
use meniscus_numerics::grid::Grid;
use meniscus_sim::{Compiled, Diagnostics, Simulation, StepError, Wall};
use std::f64::consts::PI;

/// The case.
pub const CASE: Case = Case {
    name: "open-side",
    title: "Liquid that leaves",
    theory: "Beyond an open side is air. A column of liquid (height H = 0.6, g = 1) between slip walls over an open bottom \
        falls freely: t²g/2 of its height has left. A ball of radius R = 0.2 at We = ρU²·2R/γ = 400 flies out at \
        right angles: when its centre is at the side half of its volume has left. In both the energy of what is \
        left and of what has left never rises, over its start.",
    quick: true,
    run: |mode| checks_or_failure("open-side", run(mode)),
};

/// Radius of the ball.
const RADIUS: f64 = 0.2;
/// Tolerance of the column's share, whose surfaces stay flat: a fiftieth of a cell of 1/16 over its height of 0.6.
const COLUMN_TOLERANCE: f64 = 0.002;
/// Tolerance of the growth of the energy: half of that allowed in the project's scenes.
const ENERGY_TOLERANCE: f64 = 0.005;

fn run(mode: Mode) -> Result<Vec<Check>, StepError> {
    let cells = if mode == Mode::Quick { 32 } else { 64 };
    let mut checks = column::<2>(cells)?;
    checks.extend(ball::<2>(cells)?);
    checks.extend(column::<3>(cells / 2)?);
    checks.extend(ball::<3>(cells)?);
    Ok(checks)
}

/// Kinetic and other energy of the remaining liquid and of the outflow.
fn energies<const D: usize>(sim: &Simulation<D>, ledger: &Diagnostics<D>) -> [f64; 2] {
    let stored = ledger.surface_energy + ledger.potential_energy + sim.state.outflow_stored_energy;
    [ledger.kinetic_energy + sim.state.outflow_kinetic_energy, stored]
}

/// Runs until `end`. Returns the share of the volume that left, and the largest growth of the energy over `scale`.
fn run_outflow<const D: usize>(
    sim: &mut Simulation<D>,
    end: f64,
    scale: f64,
) -> Result<(f64, f64), StepError> {
    let start = sim.diagnostics();
    let [mut before, stored] = energies(sim, &start);
    let (first, mut growth) = (before + stored, 0.0f64);
    while sim.state.time < end * (1.0 - 1e-12) {
        let ledger = sim.step(end - sim.state.time, &mut |_| ())?.diagnostics;
        let [kinetic, stored] = energies(sim, &ledger);
        // The velocity leads the positions by half a step.
        growth = growth.max((0.5 * (before + kinetic) + stored - first) / scale);
        before = kinetic;
    }
    Ok((sim.state.outflow_volume / start.volume, growth))
}

fn column<const D: usize>(cells: usize) -> Result<Vec<Check>, StepError>
where
    Simulation<D>: Compiled<D>,
{
    let (height, end) = (0.6, 0.6);
    let mut walls = [[Wall::Slip; 2]; D];
    walls[D - 1][0] = Wall::Open;
    let mut model = model(Grid::<D>::new([cells; D], 1.0 / cells as f64), walls).with_open_sides();
    model.gravity[D - 1] = -1.0;
    let distance = |x: &Vector<D>| x[D - 1] - height;
    let mut sim = at_rest(model, &distance);
    let scale = sim.diagnostics().potential_energy;
    let (left, growth) = run_outflow(&mut sim, end, scale)?;
    let (share, energy) =
        (format!("share of a column that has left, {D}D"), format!("its energy's growth, {D}D"));
    let exact = 0.5 * end * end / height;
    Ok(vec![
        Check::relative("open-side", share, left, exact, bars(COLUMN_TOLERANCE, 1e-3)),
        at_most("open-side", energy, growth, bars(ENERGY_TOLERANCE, 1e-3)),
    ])
}

fn ball<const D: usize>(cells: usize) -> Result<Vec<Check>, StepError>
where
    Simulation<D>: Compiled<D>,
{
    let mut model =
        model(Grid::<D>::new([cells; D], 1.0 / cells as f64), [[Wall::Open; 2]; D]).with_open_sides();
    model.surface_tension = model.density * 2.0 * RADIUS / 400.0;
    let mut center = Vector::<D>::repeat(0.5);
    center[0] = 0.7;
    let distance = |x: &Vector<D>| (x - center).norm() - RADIUS;
    let velocity = Vector::from_fn(|a, _| if a == 0 { 1.0 } else { 0.0 });
    let mut sim = in_flight(model, &distance, velocity);
    let volume = if D == 2 { PI * RADIUS.powi(2) } else { 4.0 / 3.0 * PI * RADIUS.powi(3) };
    let scale = 0.5 * sim.model.density * volume;
    let (left, growth) = run_outflow(&mut sim, 0.3, scale)?;
    let (share, energy) =
        (format!("share of a ball that has left, {D}D"), format!("its energy's growth, {D}D"));
    // The surface is of second order: its error is that of a chord of a cell.
    let bar = (1.0 / (cells as f64 * RADIUS)).powi(2).min(0.02);
    Ok(vec![
        Check::relative("open-side", share, left, 0.5, bars(bar, 0.25 * bar)),
        at_most("open-side", energy, growth, bars(ENERGY_TOLERANCE, 1e-3)),
    ])
}
