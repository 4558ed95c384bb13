//! The energy law of falling deformable solids without liquid.

use crate::measure::{at_most, bar, checks_or_failure};
use crate::setup::run_to;
use crate::soft::SoftMaterial;
use crate::solids_only::{
    ContactMonitor, GRAVITY, cube_to_ball, gravity, mapped, point_at, quadratic_cube_mesh,
    simulation_without_liquid, soft,
};
use crate::{Case, Check, Mode};
use meniscus_numerics::Vector;
use meniscus_numerics::grid::Grid;
use meniscus_sim::StepError;
use meniscus_sim::{Compiled, Simulation};

/// The case.
pub const CASE: Case = Case {
    name: "soft-energy",
    title: "A soft solid that falls on the floor wins no energy in any step",
    theory: "No liquid, no damping, ν = 0.3, density 2, g = 10, cells of 1/24, 0.5 s. A ball of radius 0.15 and a block of side 0.24 turned by \
        20 degrees fall by 0.3 on the floor of a box (E = 400, 1e4, 1e6). Nothing does work: kinetic, elastic, barrier's and potential \
        energy together, at the time of the velocities, never rise; over the energy of the fall. With the longest steps \
        that are allowed (0.7 cells), and with such of 5e-4. Quick: 2D, the ball.",
    quick: false,
    run: |mode| checks_or_failure(NAME, run(mode)),
};

const NAME: &str = "soft-energy";
const DX: f64 = 1.0 / 24.0;
const FALL_HEIGHT: f64 = 0.3;

fn run(mode: Mode) -> Result<Vec<Check>, StepError> {
    let mut checks = Vec::new();
    for step in [1.0, 5e-4] {
        for young in [400.0, 1e4, 1e6] {
            checks.extend(check_fall::<2>(8, young, 0.0, step)?);
            if mode == Mode::Full {
                checks.extend(check_fall::<2>(8, young, 20.0, step)?);
            }
        }
    }
    if mode == Mode::Full {
        for young in [400.0, 1e6] {
            checks.extend(check_fall::<3>(4, young, 0.0, 1.0)?);
        }
    }
    Ok(checks)
}

/// A ball, or a block rotated by an angle, degrees.
fn check_fall<const D: usize>(n: usize, young: f64, turned: f64, step: f64) -> Result<Vec<Check>, StepError>
where
    Simulation<D>: Compiled<D>,
{
    let material = SoftMaterial { young, poisson: 0.3, density: 2.0, damping: 0.0 };
    let half = 0.12;
    let (s, c) = turned.to_radians().sin_cos();
    let low = if turned == 0.0 { 0.15 } else { half * (s + c) };
    let center = point_at::<D>(0.5, low + FALL_HEIGHT);
    let place = |x: &Vector<D>| {
        if turned == 0.0 {
            return center + cube_to_ball(x) * low;
        }
        let mut y = x * half;
        (y[0], y[D - 1]) = (half * (c * x[0] - s * x[D - 1]), half * (s * x[0] + c * x[D - 1]));
        center + y
    };
    let solid = soft(mapped(quadratic_cube_mesh([n; D]), place), material, 0.3, Vec::new())?;
    let scale = solid.mass_properties.mass * GRAVITY * FALL_HEIGHT;
    let mut simulation = simulation_without_liquid(Grid::new([24; D], DX), vec![solid], gravity(), step);
    let mut watch = ContactMonitor::new(&simulation.model, scale);
    run_to(&mut simulation, 0.5, |s, report| watch.observe(s, &report.diagnostics, true))?;
    let law = watch.law();
    let steps = if step < 1.0 { "short" } else { "long" };
    let shape = if turned == 0.0 { "ball" } else { "block" };
    let what = |text: &str| format!("{text}, {shape}, E = {young}, {steps} steps, {D}D");
    Ok(vec![
        watch.check_rise(NAME, what("largest rise in a step")),
        at_most(
            NAME,
            what("share of the steps that rise"),
            law.rises as f64 / law.steps.max(1) as f64,
            bar(0.0),
        ),
        watch.check_gap(NAME, what("narrowest gap / cell"), DX, 1e-2),
    ])
}
