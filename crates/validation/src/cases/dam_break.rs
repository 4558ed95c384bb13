//! A collapsing column of water.

use crate::measure::{at_most, settle};
use crate::setup::run_to;
use crate::{Case, Check, Mode};
use meniscus_numerics::Vector;
use meniscus_numerics::grid::Grid;
use meniscus_sim::{Body, Drop, Model, Numerics, Simulation, StepError, Wall};

/// The case.
pub const CASE: Case = Case {
    name: "dam-break",
    title: "Dam break",
    theory: "A column of water, a = 5.715 cm wide and 2a high, collapses along a floor. Position x/a of the front \
        against the experiments of Martin and Moyce (Phil. Trans. R. Soc. A 244, 1952; digitised values) at T = \
        t√(2g/a): largest and mean relative deviation. The simulation has no wall friction and no gate, so its \
        front runs ahead; the deviation that is left when the release is delayed by the time that fits best \
        (T ≤ 0.5) tells how much of it is the gate. 2D; full: 40 cells per a; quick: 16, bar 15 %.",
    quick: false,
    run: |mode| settle("dam-break", run(mode)),
};

/// Width of the column, m.
const WIDTH: f64 = 0.05715;
/// Gravity, m/s².
const GRAVITY: f64 = 9.81;

/// T and x/a as measured.
const FRONT: [(f64, f64); 6] =
    [(0.832, 1.217), (1.219, 1.474), (1.997, 2.292), (2.547, 2.995), (3.345, 4.134), (4.034, 4.944)];

/// Longest delay of the release that is tried, in units of T.
const SHIFT: f64 = 0.5;

/// The value of a series at a time, linear between its points.
fn at(times: &[f64], values: &[f64], time: f64) -> f64 {
    let k = times.partition_point(|t| *t < time).clamp(1, times.len() - 1);
    let part = (time - times[k - 1]) / (times[k] - times[k - 1]);
    values[k - 1] + part * (values[k] - values[k - 1])
}

fn run(mode: Mode) -> Result<Vec<Check>, StepError> {
    let (cells, must) = if mode == Mode::Quick { (16, 0.15) } else { (40, 0.08) };
    let dx = WIDTH / cells as f64;
    let model = Model {
        grid: Grid::<2>::new([6 * cells, 5 * cells / 2], dx),
        walls: [[Wall::Slip; 2]; 2],
        density: 998.0,
        kinematic_viscosity: 1e-6,
        surface_tension: 0.0728,
        gravity: Vector::<2>::new(0.0, -GRAVITY),
        numerics: Numerics::default(),
    };
    let distance = |x: &Vector<2>| {
        let (right, top) = (x[0] - WIDTH, x[1] - 2.0 * WIDTH);
        right.max(top).min(0.0) + right.max(0.0).hypot(top.max(0.0))
    };
    let mut sim = Simulation::new(model, &[Body { distance: &distance, velocity: Vector::zeros() }]);
    let unit = (2.0 * GRAVITY / WIDTH).sqrt();
    let mut volume: f64 = 0.0;
    let (mut times, mut fronts) = (vec![0.0], vec![1.0]);
    run_to(&mut sim, (FRONT[FRONT.len() - 1].0 + SHIFT) / unit, |sim, report| {
        volume = volume.max(report.ledger.volume_error);
        let largest = |a: &&Drop<2>, b: &&Drop<2>| a.target_volume.total_cmp(&b.target_volume);
        times.push(sim.state.time * unit);
        fronts.push(sim.state.drops.iter().max_by(largest).map_or(0.0, |d| d.upper[0]) / WIDTH);
    })?;
    let off = |shift: f64| FRONT.map(|(time, measured)| at(&times, &fronts, time - shift) / measured - 1.0);
    let size = |off: [f64; 6]| off.iter().fold(0.0, |m: f64, e| m.max(e.abs()));
    let mean = |off: [f64; 6]| off.iter().map(|e| e.abs()).sum::<f64>() / 6.0;
    let worst = size(off(0.0));
    let list: Vec<String> = off(0.0).iter().map(|e| format!("{:+.1}", 100.0 * e)).collect();
    // The delay of the release that fits the measured front best.
    let delays = (0..=100).map(|k| SHIFT * f64::from(k) / 100.0);
    let delay = delays.min_by(|a, b| size(off(*a)).total_cmp(&size(off(*b)))).unwrap_or(0.0);
    let late: Vec<String> = off(delay).iter().map(|e| format!("{:+.1}", 100.0 * e)).collect();
    let largest = format!("largest deviation of the front (all: {} %)", list.join(", "));
    let later = format!("largest deviation, released ΔT = {delay:.2} later (all: {} %)", late.join(", "));
    Ok(vec![
        at_most("dam-break", &largest, worst, must, Some(0.05), ""),
        at_most("dam-break", "mean deviation of the front", mean(off(0.0)), must, Some(0.05), ""),
        at_most("dam-break", &later, size(off(delay)), must, Some(0.05), ""),
        at_most("dam-break", "volume error", volume, 1e-4, Some(1e-8), ""),
    ])
}
