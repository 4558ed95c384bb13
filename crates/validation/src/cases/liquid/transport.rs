//! Surfaces in prescribed flows: Zalesak's disc and the vortex in a box.

use crate::measure::{at_most, bars, volume_and_centroid};
use crate::setup::model;
use crate::{Bars, Case, Check, Mode};
use meniscus_numerics::Vector;
use meniscus_numerics::grid::{CellField, Grid, Sampler};
use meniscus_sim::{Model, PrescribedFlow, Wall};
use std::f64::consts::{PI, TAU};

/// Zalesak's disc.
pub const ZALESAK: Case = Case {
    name: "zalesak",
    title: "Zalesak's disc",
    theory: "A slotted disc (radius 15, slot 5 × 25, area 582.2) turns once about (50, 50) in 100 × 100 cells, 628 \
        steps. Relative change of the area, and the L1 error ∫|H(φ) − H(φ_exact)| over the length of the exact \
        outline, with and without the simulator's volume correction (which can hide a loss of shape in the area, not \
        in L1). Bars of L1: 0.61, a fifth-order level set, and 0.07, particle level set (Enright, Fedkiw, Ferziger, \
        Mitchell, J. Comput. Phys. 183, 2002, from memory). Quick is the same.",
    quick: true,
    run: |_| zalesak(),
};

/// The vortex in a box.
pub const VORTEX: Case = Case {
    name: "vortex",
    title: "Vortex in a box",
    theory: "A disc (radius 0.15 at (0.5, 0.75)) is drawn into a spiral by the stream function sin²πx sin²πy / π, which \
        turns back by cos πt/T, T = 8: at t = T the disc should be back. Area and L1 error as in zalesak. Bars of L1: \
        0.031, a fifth-order level set in 128² cells, and 1.4e-3, particle level set (Enright et al. 2002, from \
        memory). Full: 128² cells; quick: 64², T = 4, bar of the area without correction 10 %.",
    quick: false,
    run: vortex,
};

/// Result of a run.
struct AdvectionResult {
    area: f64,
    error: f64,
}

fn zalesak() -> Vec<Check> {
    let grid = Grid::<2>::new([100, 100], 1.0);
    let about = Vector::<2>::new(50.0, 50.0);
    let flow = |x: &Vector<2>, _: f64| Vector::<2>::new(about[1] - x[1], x[0] - about[0]) * (TAU / 628.0);
    let length = outline_length();
    let run = |keep| advect(grid, &slotted, &flow, 628, 1.0, keep);
    checks("zalesak", &run, length, 582.207, bars(0.01, 0.0031), bars(0.61, 0.07))
}

fn vortex(mode: Mode) -> Vec<Check> {
    let (cells, period, area) = if mode == Mode::Quick { (64, 4.0, 0.1) } else { (128, 8.0, 0.01) };
    let grid = Grid::<2>::new([cells; 2], 1.0 / cells as f64);
    let steps = (period * cells as f64 / 0.5).round() as usize;
    let dt = period / steps as f64;
    let disc = |x: &Vector<2>| (x - Vector::<2>::new(0.5, 0.75)).norm() - 0.15;
    let flow = move |x: &Vector<2>, t: f64| {
        let (sx, sy) = ((PI * x[0]).sin(), (PI * x[1]).sin());
        let turn = (PI * t / period).cos();
        Vector::<2>::new(-sx * sx * (TAU * x[1]).sin(), sy * sy * (TAU * x[0]).sin()) * turn
    };
    let run = |keep| advect(grid, &disc, &flow, steps, dt, keep);
    checks("vortex", &run, TAU * 0.15, PI * 0.0225, bars(area, 0.0071), bars(0.031, 0.0014))
}

/// Area and L1 error with the volume correction off and on.
fn checks(
    case: &str,
    run: &dyn Fn(bool) -> AdvectionResult,
    length: f64,
    area: f64,
    of_area: Bars,
    of_error: Bars,
) -> Vec<Check> {
    let mut checks = Vec::new();
    for (keep, text) in [(false, "volume correction off"), (true, "volume correction on")] {
        let outcome = run(keep);
        let quantity = format!("area, {text}");
        checks.push(Check::relative(case, quantity, outcome.area, area, of_area));
        let quantity = format!("L1 error, {text}");
        checks.push(at_most(case, quantity, outcome.error / length, of_error));
    }
    checks
}

/// Advects a shape that returns to its initial position.
fn advect(
    grid: Grid<2>,
    distance: &(dyn Fn(&Vector<2>) -> f64 + Sync),
    flow: &dyn Fn(&Vector<2>, f64) -> Vector<2>,
    steps: usize,
    dt: f64,
    keep: bool,
) -> AdvectionResult {
    let mut liquid = PrescribedFlow::new(model(grid, [[Wall::Slip; 2]; 2]), distance);
    let start = liquid.state.phi.clone();
    for step in 0..steps {
        let middle = (step as f64 + 0.5) * dt;
        liquid.step(&|x: &Vector<2>| flow(x, middle), dt, keep);
    }
    let (area, _) = volume_and_centroid(&liquid.model, &liquid.state.phi);
    AdvectionResult { area, error: symmetric_difference_area(&liquid.model, &start, &liquid.state.phi) }
}

/// Area where two fields differ in sign, by ten by ten points in every cell near either surface.
fn symmetric_difference_area(model: &Model<2>, a: &CellField<2>, b: &CellField<2>) -> f64 {
    let (grid, edges) = (&model.grid, model.scalar_boundary());
    let samplers = [a, b].map(|field| Sampler::cells(grid, &field.data, edges));
    let lattice = grid.lattice();
    let fine = 10;
    let mut points = 0;
    for i in 0..lattice.len() {
        let near = |f: &CellField<2>| f.data[i].abs() < 1.5 * grid.dx;
        if !near(a) && !near(b) && (a.data[i] < 0.0) == (b.data[i] < 0.0) {
            continue;
        }
        let center = grid.center(lattice.coordinates(i));
        for k in 0..fine * fine {
            let part = |n: usize| ((n as f64 + 0.5) / fine as f64 - 0.5) * grid.dx;
            let x = center + Vector::<2>::new(part(k % fine), part(k / fine));
            points += usize::from((samplers[0].cubic(&x) < 0.0) != (samplers[1].cubic(&x) < 0.0));
        }
    }
    points as f64 * grid.cell_volume() / (fine * fine) as f64
}

/// Half the width of the slot, and its upper end.
const SLOT: (f64, f64) = (2.5, 85.0);
/// Centre and radius of the disc.
const DISC: ([f64; 2], f64) = ([50.0, 75.0], 15.0);

/// Signed distance to the slotted disc.
fn slotted(x: &Vector<2>) -> f64 {
    let (px, py) = ((x[0] - DISC.0[0]).abs(), x[1] - DISC.0[1]);
    let top = SLOT.1 - DISC.0[1];
    // Where the slot's sides meet the circle.
    let foot = -(DISC.1 * DISC.1 - SLOT.0 * SLOT.0).sqrt();
    let disc = px.hypot(py) - DISC.1;
    let inside = disc < 0.0 && !(px < SLOT.0 && py < top);
    let mut size = (px - SLOT.0).hypot(py - py.clamp(foot, top)).min((px - px.min(SLOT.0)).hypot(py - top));
    // The circle counts where its closest point is outside the slot.
    if px * -foot >= -py * SLOT.0 || py > 0.0 {
        size = size.min(disc.abs());
    }
    if inside { -size } else { size }
}

/// Length of the slotted disc's outline.
fn outline_length() -> f64 {
    let foot = (DISC.1 * DISC.1 - SLOT.0 * SLOT.0).sqrt();
    let arc = TAU - 2.0 * (SLOT.0 / DISC.1).asin();
    arc * DISC.1 + 2.0 * (foot + SLOT.1 - DISC.0[1]) + 2.0 * SLOT.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slotted_disc_has_its_area() {
        let n = 800;
        let at = |i: i32| (f64::from(i) + 0.5) * 40.0 / f64::from(n);
        let inside = |k: &i32| slotted(&Vector::<2>::new(30.0 + at(k % n), 55.0 + at(k / n))) < 0.0;
        let area = (0..n * n).filter(inside).count() as f64 * (40.0 / f64::from(n)).powi(2);
        assert!((area - 582.207).abs() < 0.5, "{area}");
        assert!((slotted(&Vector::<2>::new(50.0, 70.0)) - 2.5).abs() < 1e-12);
        assert!((slotted(&Vector::<2>::new(40.0, 75.0)) + 5.0).abs() < 1e-12);
    }
}
