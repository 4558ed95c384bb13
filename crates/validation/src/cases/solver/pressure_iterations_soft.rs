//! Iterations of the pressure solve with deformable sheets.

use super::pressure_iterations::max_iterations;
use crate::measure::{at_most, bars, checks_or_failure};
use crate::setup::{across_and_up, at_rest, block, grid_offset, unit_model, up};
use crate::soft::SoftMaterial;
use crate::{Case, Check, Mode};
use meniscus_numerics::Vector;
use meniscus_numerics::grid::Grid;
use meniscus_sim::{Compiled, Model, Numerics, Simulation, StepError, Wall};

/// The case.
pub const CASE: Case = Case {
    name: "iterations-soft",
    title: "Iterations of the pressure solve with soft sheets",
    theory: "A free sheet 2.67 cells thick in the middle of a pool (side 3, depth 1.5, sheet 1.5 wide, g = 1), \
        heavy or light, soft or stiff: r = ρΔ/ρ_s t of 1 to 100 with the thickness t, bending stiffness times \
        h²/ρ_s tΔ⁴ of 1 to 10⁶. Multigrid-preconditioned conjugate gradients to a relative residual of 1e-6: \
        the most iterations of any solve of 8 steps of h = 0.005, the first of which starts from a pressure of \
        zero. 3D, 16 cells a unit; quick: 2D, 12.",
    quick: true,
    run: |mode| checks_or_failure(NAME, run(mode)),
};

const NAME: &str = "iterations-soft";
const STEPS: u64 = 8;
/// Length of a step.
const STEP: f64 = 0.005;
/// Thickness of the sheet, in cells.
const THICKNESS: f64 = 8.0 / 3.0;
const POISSON: f64 = 0.3;

fn run(mode: Mode) -> Result<Vec<Check>, StepError> {
    if mode == Mode::Quick {
        return checks::<2>(12, &[(10.0, 100.0), (100.0, 1.0)]);
    }
    let all: Vec<(f64, f64)> =
        [1.0, 10.0, 100.0].iter().flat_map(|r| [1.0, 100.0, 1e6].map(|k| (*r, k))).collect();
    checks::<3>(16, &all)
}

fn checks<const D: usize>(cells: usize, settings: &[(f64, f64)]) -> Result<Vec<Check>, StepError>
where
    Simulation<D>: Compiled<D>,
{
    let check = |(light, bending): &(f64, f64)| {
        let most = max_iterations(start::<D>(cells, *light, *bending)?, STEPS)?;
        let text = format!("iterations of a solve, r = {light}, k_b = {bending}, {D}D, {cells} cells a unit");
        Ok(at_most(NAME, text, most, bars(60.0, 30.0)))
    };
    settings.iter().map(check).collect()
}

/// The sheet in its pool; `light` is r, `bending` the dimensionless stiffness.
fn start<const D: usize>(cells: usize, light: f64, bending: f64) -> Result<Simulation<D>, StepError>
where
    Simulation<D>: Compiled<D>,
{
    let dx = 1.0 / cells as f64;
    let thickness = THICKNESS * dx;
    let density = dx / (light * thickness);
    let young =
        bending * density * dx.powi(4) * 12.0 * (1.0 - POISSON * POISSON) / (STEP * thickness).powi(2);
    let room = across_and_up::<D>(3.0, 2.0);
    let center = across_and_up(1.5, 0.9) + grid_offset(dx);
    let half_size = across_and_up(0.75, 0.5 * thickness);
    let shape = block(center, half_size);
    let material = SoftMaterial { young, poisson: POISSON, density, damping: 0.0 };
    let sheet = material.solid(shape, dx / 1.5, |_| false)?;
    let model = Model {
        surface_tension: 0.0,
        gravity: up(-1.0),
        solids: vec![sheet],
        numerics: Numerics { max_step: STEP, ..Numerics::default() },
        ..unit_model(
            Grid::<D>::new(std::array::from_fn(|a| (room[a] * cells as f64) as usize), dx),
            [[Wall::Slip; 2]; D],
        )
    };
    let liquid = |x: &Vector<D>| x[D - 1] - 1.5;
    Ok(at_rest(model, &liquid))
}
