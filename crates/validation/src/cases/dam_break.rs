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
        front runs ahead early. 2D; full: 40 cells per a; quick: 16, bar 15 %.",
    quick: true,
    run: |mode| settle("dam-break", run(mode)),
};

/// Width of the column, m.
const WIDTH: f64 = 0.05715;
/// Gravity, m/s².
const GRAVITY: f64 = 9.81;

/// T and x/a as measured.
const FRONT: [(f64, f64); 6] =
    [(0.832, 1.217), (1.219, 1.474), (1.997, 2.292), (2.547, 2.995), (3.345, 4.134), (4.034, 4.944)];

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
    let (mut worst, mut mean, mut volume): (f64, f64, f64) = (0.0, 0.0, 0.0);
    let mut list = Vec::new();
    for (time, measured) in FRONT {
        run_to(&mut sim, time / (2.0 * GRAVITY / WIDTH).sqrt(), |_, report| {
            volume = volume.max(report.ledger.volume_error);
        })?;
        let largest = |a: &&Drop<2>, b: &&Drop<2>| a.target_volume.total_cmp(&b.target_volume);
        let front = sim.state.drops.iter().max_by(largest).map_or(0.0, |d| d.upper[0]) / WIDTH;
        let off = front / measured - 1.0;
        list.push(format!("{:+.1}", 100.0 * off));
        mean += off.abs() / FRONT.len() as f64;
        if off.abs() > worst.abs() {
            worst = off;
        }
    }
    let largest = format!("largest deviation of the front (all: {} %)", list.join(", "));
    Ok(vec![
        at_most("dam-break", &largest, worst, must, Some(0.05), ""),
        at_most("dam-break", "mean deviation of the front", mean, must, Some(0.05), ""),
        at_most("dam-break", "volume error", volume, 1e-4, Some(1e-8), ""),
    ])
}
