//! A collapsing column of water.

use crate::measure::{at_most, bars, checks_or_failure};
use crate::setup::{at_rest, run_to, unit_model};
use crate::{Case, Check, Mode};
use meniscus_numerics::Vector;
use meniscus_numerics::grid::Grid;
use meniscus_sim::{Component, Model, StepError, Wall};
use std::f64::consts::SQRT_2;

/// The case.
pub const CASE: Case = Case {
    name: "dam-break",
    title: "Dam break",
    theory: "A column of water, a = 5.715 cm wide and 2a high, collapses along a floor. Position x/a of the front \
        against the experiments of Martin and Moyce (Phil. Trans. R. Soc. A 244, 1952; digitised values) at T = \
        t√(2g/a): largest and mean relative deviation; and the height of the column (their table 6). The simulation \
        has no wall friction and no gate, so its front runs ahead; the deviation that is left when the release is \
        delayed by the time that fits best (T ≤ 0.5) tells how much of it is the gate. That the equations are solved \
        right is judged apart from the experiment: without surface tension, front and height against potential flow \
        (boundary integrals in place of a grid, 160 nodes; its energy holds to 1 %). It leads the experiment by 13 to \
        20 %. 2D; full: 40 cells per a; quick: 16, bar 15 % (potential flow: 2 %, quick 5 %).",
    quick: false,
    run: |mode| checks_or_failure("dam-break", run(mode)),
};

/// Width of the column, m.
const WIDTH: f64 = 0.05715;
/// Gravity, m/s².
const GRAVITY: f64 = 9.81;

/// T and measured x/a.
const MEASURED_FRONT: [(f64, f64); 6] =
    [(0.832, 1.217), (1.219, 1.474), (1.997, 2.292), (2.547, 2.995), (3.345, 4.134), (4.034, 4.944)];

/// t√(g/a) and measured height of the column for T ≤ 4 (table 6, as transcribed in TormodLandet/Ocellaris).
const MEASURED_HEIGHT: [(f64, f64); 12] = [
    (0.56, 0.94),
    (0.77, 0.89),
    (0.93, 0.83),
    (1.08, 0.78),
    (1.28, 0.72),
    (1.46, 0.67),
    (1.66, 0.61),
    (1.84, 0.56),
    (2.00, 0.50),
    (2.21, 0.44),
    (2.45, 0.39),
    (2.70, 0.33),
];

/// T, x/a and height of potential flow.
const POTENTIAL_FLOW: [(f64, f64, f64); 10] = [
    (0.4, 1.121, 0.982),
    (0.8, 1.386, 0.931),
    (1.2, 1.747, 0.853),
    (1.6, 2.181, 0.759),
    (2.0, 2.677, 0.665),
    (2.4, 3.223, 0.579),
    (2.8, 3.813, 0.502),
    (3.2, 4.438, 0.432),
    (3.6, 5.097, 0.371),
    (4.0, 5.782, 0.319),
];

/// Largest tested delay of the release, in units of T.
const MAX_RELEASE_DELAY: f64 = 0.5;

/// Linear interpolation of a series at a time.
fn interpolate(times: &[f64], values: &[f64], time: f64) -> f64 {
    let k = times.partition_point(|t| *t < time).clamp(1, times.len() - 1);
    let part = (time - times[k - 1]) / (times[k] - times[k - 1]);
    values[k - 1] + part * (values[k] - values[k - 1])
}

/// A collapse: T, x/a of the front and height of the column at every step.
struct Collapse {
    times: Vec<f64>,
    fronts: Vec<f64>,
    heights: Vec<f64>,
    volume_error: f64,
}

impl Collapse {
    fn front(&self, time: f64) -> f64 {
        interpolate(&self.times, &self.fronts, time)
    }

    fn height(&self, time: f64) -> f64 {
        interpolate(&self.times, &self.heights, time)
    }
}

fn collapse(cells: usize, surface_tension: f64) -> Result<Collapse, StepError> {
    let dx = WIDTH / cells as f64;
    let model = Model {
        density: 998.0,
        kinematic_viscosity: 1e-6,
        surface_tension,
        gravity: Vector::<2>::new(0.0, -GRAVITY),
        ..unit_model(Grid::<2>::new([6 * cells, 5 * cells / 2], dx), [[Wall::Slip; 2]; 2])
    };
    let distance = |x: &Vector<2>| {
        let (right, top) = (x[0] - WIDTH, x[1] - 2.0 * WIDTH);
        right.max(top).min(0.0) + right.max(0.0).hypot(top.max(0.0))
    };
    let mut sim = at_rest(model, &distance);
    let unit = (2.0 * GRAVITY / WIDTH).sqrt();
    let mut c = Collapse { times: vec![0.0], fronts: vec![1.0], heights: vec![1.0], volume_error: 0.0 };
    run_to(
        &mut sim,
        (MEASURED_FRONT[MEASURED_FRONT.len() - 1].0 + MAX_RELEASE_DELAY) / unit,
        |sim, report| {
            let largest = |a: &&Component<2>, b: &&Component<2>| a.target_volume.total_cmp(&b.target_volume);
            let upper = sim.state.components.iter().max_by(largest).map_or(Vector::zeros(), |d| d.upper);
            c.times.push(sim.state.time * unit);
            c.fronts.push(upper[0] / WIDTH);
            c.heights.push(upper[1] / (2.0 * WIDTH));
            c.volume_error = c.volume_error.max(report.diagnostics.volume_error.abs());
        },
    )?;
    Ok(c)
}

/// The largest absolute value of some relative deviations.
fn largest(deviations: impl Iterator<Item = f64>) -> f64 {
    deviations.fold(0.0, |m, e| m.max(e.abs()))
}

fn percent(deviations: &[f64]) -> String {
    deviations.iter().map(|e| format!("{:+.1}", 100.0 * e)).collect::<Vec<_>>().join(", ")
}

fn run(mode: Mode) -> Result<Vec<Check>, StepError> {
    let (cells, must, exact) = if mode == Mode::Quick { (16, 0.15, 0.05) } else { (40, 0.08, 0.02) };
    let water = collapse(cells, 0.0728)?;
    let ideal = collapse(cells, 0.0)?;
    let off = |delay: f64| MEASURED_FRONT.map(|(time, measured)| water.front(time - delay) / measured - 1.0);
    let size = |delay: f64| largest(off(delay).into_iter());
    let mean = off(0.0).iter().map(|e| e.abs()).sum::<f64>() / MEASURED_FRONT.len() as f64;
    // The delay of the release that fits the measured front best.
    let delays = (0..=100).map(|k| MAX_RELEASE_DELAY * f64::from(k) / 100.0);
    let delay = delays.min_by(|a, b| size(*a).total_cmp(&size(*b))).unwrap_or(0.0);
    let sunk = MEASURED_HEIGHT.map(|(time, measured)| water.height(SQRT_2 * time) / measured - 1.0);
    let lead = largest(POTENTIAL_FLOW.iter().map(|p| ideal.front(p.0) / p.1 - 1.0));
    let fall = largest(POTENTIAL_FLOW.iter().map(|p| ideal.height(p.0) / p.2 - 1.0));
    let front = format!("largest deviation of the front (all: {} %)", percent(&off(0.0)));
    let (late, all) = (format!("{delay:.2}"), percent(&off(delay)));
    let later = format!("largest deviation, released ΔT = {late} later (all: {all} %)");
    let column = format!("largest deviation of the column's height (all: {} %)", percent(&sunk));
    let case = "dam-break";
    Ok(vec![
        at_most(case, front, size(0.0), bars(must, 0.05)),
        at_most(case, "mean deviation of the front", mean, bars(must, 0.05)),
        at_most(case, later, size(delay), bars(must, 0.05)),
        at_most(case, column, largest(sunk.into_iter()), bars(must, 0.05)),
        at_most(case, "front against potential flow", lead, bars(exact, 0.005)),
        at_most(case, "height of the column against potential flow", fall, bars(exact, 0.005)),
        at_most(case, "volume error", water.volume_error, bars(1e-4, 1e-8)),
    ])
}
