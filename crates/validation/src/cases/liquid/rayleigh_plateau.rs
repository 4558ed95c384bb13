//! Breakup of a liquid column.

use crate::measure::{bars, checks_or_failure, fit_growth, surface_points};
use crate::setup::{RADIUS, TENSION, at_rest, grid_offset, model, run_to};
use crate::{Case, Check, Mode};
use meniscus_numerics::Vector;
use meniscus_numerics::fit::least_squares;
use meniscus_numerics::grid::Grid;
use meniscus_sim::{Simulation, StepError, Wall};
use std::f64::consts::PI;

/// The case.
pub const CASE: Case = Case {
    name: "rayleigh-plateau",
    title: "Break-up of a liquid column",
    theory: "A column of radius R = 0.5 (γ = 100, ρ = 1, ν = 0) with the perturbation 0.01 R cos kx, kR = 0.7, between \
        slip walls half a wave apart, released at rest: it grows like cosh σt with σ² = γ/(ρR³) kR I1(kR)/I0(kR) \
        (1 − k²R²) (Rayleigh 1878). The rate is fitted to the amplitude over 0 < σt < 2. Full: 16 cells per \
        radius; quick: 8, bar 20 %.",
    quick: true,
    run: |mode| checks_or_failure("rayleigh-plateau", run(mode)),
};

/// Wave number times radius.
const WAVENUMBER_TIMES_RADIUS: f64 = 0.7;
/// Relative initial amplitude.
const AMPLITUDE: f64 = 0.01;

/// Rayleigh's growth rate, 1/s.
fn growth_rate() -> f64 {
    let factor = WAVENUMBER_TIMES_RADIUS * bessel(1, WAVENUMBER_TIMES_RADIUS)
        / bessel(0, WAVENUMBER_TIMES_RADIUS)
        * (1.0 - WAVENUMBER_TIMES_RADIUS * WAVENUMBER_TIMES_RADIUS);
    (TENSION / RADIUS.powi(3) * factor).sqrt()
}

/// The modified Bessel function I_n by its series.
fn bessel(n: i32, x: f64) -> f64 {
    let mut term = (1..=n).fold(1.0, |t, i| t * 0.5 * x / f64::from(i));
    let mut sum = 0.0;
    for k in 1..60 {
        sum += term;
        term *= 0.25 * x * x / (f64::from(k) * f64::from(k + n));
    }
    sum
}

fn run(mode: Mode) -> Result<Vec<Check>, StepError> {
    let (length, must) = if mode == Mode::Quick { (36, 0.2) } else { (72, 0.08) };
    let sigma = measured_growth_rate(length)?;
    let cells = length as f64 * WAVENUMBER_TIMES_RADIUS / PI;
    let quantity = format!("growth rate, {cells:.1} cells per radius");
    Ok(vec![
        Check::relative("rayleigh-plateau", quantity, sigma, growth_rate(), bars(must, 0.03)).in_unit("1/s"),
    ])
}

fn measured_growth_rate(length: usize) -> Result<f64, StepError> {
    let wave = WAVENUMBER_TIMES_RADIUS / RADIUS;
    let dx = PI / wave / length as f64;
    let wide = (3.2 * RADIUS / dx).ceil() as usize;
    let grid = Grid::<3>::new([length, wide, wide], dx);
    let mut model = model(grid, [[Wall::Slip; 2], [Wall::Open; 2], [Wall::Open; 2]]);
    model.numerics.tolerance = 1e-8;
    model.numerics.capillary_step = 2.0;
    let axis = grid.domain_upper() * 0.5 + grid_offset::<3>(dx);
    let distance = |x: &Vector<3>| {
        let slope = -RADIUS * AMPLITUDE * wave * (wave * x[0]).sin();
        let radius = RADIUS * (1.0 + AMPLITUDE * (wave * x[0]).cos());
        ((x[1] - axis[1]).hypot(x[2] - axis[2]) - radius) / slope.hypot(1.0)
    };
    let mut sim = at_rest(model, &distance);
    let amplitude = |sim: &Simulation<3>| {
        let points = surface_points(&sim.model, &sim.state.phi);
        let fit = least_squares(points.iter().map(|p| {
            let d = [p.at[1] - axis[1], p.at[2] - axis[2]];
            let r = d[0].hypot(d[1]);
            (p.area, [1.0, (wave * p.at[0]).cos(), (2.0 * wave * p.at[0]).cos(), d[0] / r, d[1] / r], r)
        }));
        fit.map_or(f64::NAN, |f| f[1])
    };
    let (mut times, mut values) = (vec![0.0], vec![amplitude(&sim)]);
    run_to(&mut sim, 2.0 / growth_rate(), |sim, _| {
        times.push(sim.state.time);
        values.push(amplitude(sim));
    })?;
    Ok(fit_growth(&times, &values, growth_rate()).unwrap_or(f64::NAN))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bessel_functions_and_rate() {
        assert!((bessel(0, 1.0) - 1.266_065_877_752_008).abs() < 1e-14);
        assert!((bessel(1, 1.0) - 0.565_159_103_992_485).abs() < 1e-14);
        // Rayleigh's largest rate, 0.3433 √(γ/ρR³), lies near kR = 0.697.
        assert!((growth_rate() / (TENSION / RADIUS.powi(3)).sqrt() - 0.3433).abs() < 1e-4);
    }
}
