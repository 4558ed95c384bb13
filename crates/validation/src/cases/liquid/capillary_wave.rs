//! Prosperetti's capillary wave.

use crate::measure::{SurfacePoint, bars, checks_or_failure, surface_points};
use crate::setup::{at_rest, model, run_to};
use crate::{Case, Check, Mode};
use meniscus_numerics::Vector;
use meniscus_numerics::grid::Grid;
use meniscus_sim::{Simulation, StepError, Wall};
use std::f64::consts::{PI, TAU};

/// The case.
pub const CASE: Case = Case {
    name: "capillary-wave",
    title: "Viscous capillary wave",
    theory: "A standing wave of length 1 and height 0.01 (γ = 100, ρ = 1, depth 1.5, slip sides) on a viscous \
        liquid under nothing, released at rest, against the exact linear solution of the initial-value problem \
        (Prosperetti, Phys. Fluids 24, 1981, one fluid; the values of a/a0 were computed from it and checked \
        by Laplace inversion): root mean square of (a − a_exact)/a0 over ω0 t = 1, 2, π, 5, 2π, 10, 4π, 20. \
        The Laplace values are for ν = 0.01, 0.1 and 1; for ν = 0 they are cos ω0 t. Steps of a quarter of the \
        explicit capillary limit. Full: 32 cells per length; quick: 16, bar 8 %.",
    quick: false,
    run: |mode| checks_or_failure("capillary-wave", run(mode)),
};

/// Depth of the liquid.
const DEPTH: f64 = 1.507_3;
/// Amplitude of the wave.
const AMPLITUDE: f64 = 0.01;
/// Frequency of the inviscid wave, √(γk³/ρ).
const OMEGA: f64 = 157.496_1;

/// Times ω0 t of the table.
const TIMES: [f64; 8] = [1.0, 2.0, PI, 5.0, TAU, 10.0, 2.0 * TAU, 20.0];

/// Viscosity and a/a0 at these times.
const EXACT: [(f64, [f64; 8]); 3] = [
    (0.01, [0.541770, -0.407793, -0.985282, 0.271580, 0.970218, -0.803095, 0.941204, 0.377379]),
    (0.1, [0.553915, -0.342070, -0.877068, 0.172686, 0.758063, -0.574403, 0.571863, 0.224056]),
    (1.0, [0.638962, 0.033272, -0.358906, -0.170569, 0.062745, -0.023406, -0.013845, -0.001372]),
];

fn run(mode: Mode) -> Result<Vec<Check>, StepError> {
    let (cells, must) = if mode == Mode::Quick { (16, 0.08) } else { (32, 0.02) };
    let inviscid = (0.0, TIMES.map(f64::cos));
    let mut checks = Vec::new();
    for (viscosity, exact) in [inviscid].iter().chain(&EXACT) {
        let found = wave(cells, *viscosity)?;
        let square: f64 = found.iter().zip(exact).map(|(a, e)| (a - e).powi(2)).sum();
        let rms = (square / exact.len() as f64).sqrt();
        let quantity = format!("RMS error / a0, ν = {viscosity}");
        checks.push(Check::absolute("capillary-wave", quantity, rms, 0.0, bars(must, 0.007)));
    }
    Ok(checks)
}

/// Relative amplitudes at the times of the table.
fn wave(cells: usize, viscosity: f64) -> Result<Vec<f64>, StepError> {
    let dx = 1.0 / cells as f64;
    let grid = Grid::<2>::new([cells, 2 * cells], dx);
    let mut model = model(grid, [[Wall::Slip; 2]; 2]);
    model.kinematic_viscosity = viscosity;
    model.numerics.tolerance = 1e-8;
    model.numerics.capillary_step = 0.25;
    let distance = |x: &Vector<2>| wave_distance(x);
    let mut sim = at_rest(model, &distance);
    let mut found = Vec::new();
    for time in TIMES {
        run_to(&mut sim, time / OMEGA, |_, _| ())?;
        found.push(amplitude(&sim) / AMPLITUDE);
    }
    Ok(found)
}

/// Signed distance to y = depth + height cos 2πx; Newton iteration for the closest point.
fn wave_distance(x: &Vector<2>) -> f64 {
    let level = |s: f64| DEPTH + AMPLITUDE * (TAU * s).cos() - x[1];
    let mut s = x[0];
    for _ in 0..20 {
        let (slope, bend) = (-AMPLITUDE * TAU * (TAU * s).sin(), -AMPLITUDE * TAU * TAU * (TAU * s).cos());
        let (gap, y) = (s - x[0], level(s));
        s -= (gap + y * slope) / (1.0 + slope * slope + y * bend).max(0.2);
    }
    -(s - x[0]).hypot(level(s)).copysign(level(x[0]))
}

/// Amplitude of the wave: crossings of the columns, projected on cos 2πx.
fn amplitude(sim: &Simulation<2>) -> f64 {
    let dx = sim.model.grid.dx;
    let column = |p: &SurfacePoint<2>| ((p.at[0] / dx - 0.5).fract() - 0.5).abs() > 0.5 - 1e-9;
    let points = surface_points(&sim.model, &sim.state.phi);
    points.iter().filter(|p| column(p)).map(|p| 2.0 * dx * (p.at[1] - DEPTH) * (TAU * p.at[0]).cos()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::setup::TENSION;
    use meniscus_numerics::grid::CellField;

    #[test]
    fn the_wave_is_measured() {
        let grid = Grid::<2>::new([32, 64], 1.0 / 32.0);
        let model = model(grid, [[Wall::Slip; 2]; 2]);
        let mut sim = at_rest(model, &|x: &Vector<2>| wave_distance(x));
        assert!((amplitude(&sim) / AMPLITUDE - 1.0).abs() < 1e-4, "{}", amplitude(&sim));
        sim.state.phi = CellField::new(grid, 1.0);
        assert_eq!(amplitude(&sim), 0.0);
        assert!((OMEGA - (TENSION * TAU.powi(3)).sqrt()).abs() < 1e-4);
    }
}
