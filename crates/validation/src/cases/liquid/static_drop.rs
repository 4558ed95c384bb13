//! A drop at rest: Laplace pressure and parasitic currents.

use crate::measure::{at_most, bars, checks_or_failure};
use crate::setup::{DropRun, RADIUS, TENSION, run_drop};
use crate::{Case, Check, Mode};
use meniscus_sim::StepError;
use meniscus_sim::{Compiled, Simulation};

const THEORY: &str = "A round drop (R = 0.5, γ = 100, ρ = 1, Laplace number γρD/μ² = 12000, off the grid's points) \
    stays at rest under Laplace's pressure γ/R (2D) or 2γ/R (3D). Curvature noise that the pressure cannot balance \
    drives currents, measured as max|u|√(ρD/γ); they must decay (Popinet, J. Comput. Phys. 228, 2009). Full: 16 \
    cells per radius for 40 (2D) or 4 (3D) times √(ρD³/γ); quick: 8 cells per radius for 5, where curvature \
    errors are four times as large and the bars 2 % and 1e-2.";

/// In 2D.
pub const CASE_2D: Case = Case {
    name: "static-2d",
    title: "Drop at rest, 2D",
    theory: THEORY,
    quick: true,
    run: |mode| checks_or_failure("static-2d", run::<2>("static-2d", mode)),
};

/// In 3D.
pub const CASE_3D: Case = Case {
    name: "static-3d",
    title: "Drop at rest, 3D",
    theory: THEORY,
    quick: true,
    run: |mode| checks_or_failure("static-3d", run::<3>("static-3d", mode)),
};

fn run<const D: usize>(name: &str, mode: Mode) -> Result<Vec<Check>, StepError>
where
    Simulation<D>: Compiled<D>,
{
    let quick = mode == Mode::Quick;
    let (cells, times) = if quick { (8, 5.0) } else { (16, if D == 2 { 40.0 } else { 4.0 }) };
    let diameter = 2.0 * RADIUS;
    let capillary = (diameter.powi(3) / TENSION).sqrt();
    let drop = DropRun {
        cells,
        mode: 2,
        amplitude: 0.0,
        viscosity: (TENSION * diameter / 12000.0).sqrt(),
        step: 5.0,
        time: times * capillary,
    };
    let history = run_drop::<D>(&drop)?;
    let last = |values: &[f64]| values.last().copied().unwrap_or(f64::NAN);
    let unit = (diameter / TENSION).sqrt();
    let end = last(&history.speeds) * unit;
    let peak = history.speeds.iter().copied().fold(0.0, f64::max) * unit;
    let laplace = TENSION * (D as f64 - 1.0) / RADIUS;
    let [of_pressure, of_speed] =
        if quick { [bars(0.02, 0.005), bars(1e-2, 1e-3)] } else { [bars(0.005, 0.001), bars(3e-3, 1e-5)] };
    Ok(vec![
        Check::relative(name, "Laplace pressure", last(&history.pressures), laplace, of_pressure),
        at_most(name, "max|u| √(ρD/γ) at the end", end, of_speed),
        at_most(name, "max|u| at the end over its peak", end / peak.max(1e-300), bars(1.0, 0.1)),
        at_most(name, "deviation from round / R", last(&history.deviations), bars(0.01, 0.001)),
    ])
}
