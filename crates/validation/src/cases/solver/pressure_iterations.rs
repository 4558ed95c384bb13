//! Iterations of the pressure solve with free solids.

use crate::cases::rigid::floating::Tank;
use crate::cases::rigid::momentum_with_solid::plate_and_drop;
use crate::measure::{at_most, bar, checks_or_failure};
use crate::{Case, Check, Mode};
use meniscus_sim::{Compiled, Simulation, StepError};

/// The case.
pub const CASE: Case = Case {
    name: "iterations",
    title: "Iterations of the pressure solve with free solids",
    theory: "Multigrid-preconditioned conjugate gradients to a relative residual of 1e-6 with a free solid 0.1 to 100 times as \
        dense as the liquid: half a disc or ball on a plate (momentum-with-solid) and a body half under water in a pool \
        (floating). The most iterations of any solve of 20 steps, the first of which starts from a pressure of zero. 16 cells per radius, in 3D 8. \
        Quick: 2D, 8.",
    quick: true,
    run: |mode| checks_or_failure(NAME, run(mode)),
};

const NAME: &str = "iterations";
const STEPS: u64 = 20;
/// Densities of the solid over the liquid's.
const DENSITIES: [f64; 4] = [0.1, 1.0, 10.0, 100.0];

fn run(mode: Mode) -> Result<Vec<Check>, StepError> {
    if mode == Mode::Quick {
        return checks::<2>(8);
    }
    let mut all = checks::<2>(16)?;
    all.extend(checks::<3>(8)?);
    Ok(all)
}

fn checks<const D: usize>(cells: usize) -> Result<Vec<Check>, StepError>
where
    Simulation<D>: Compiled<D>,
{
    let mut all = Vec::new();
    for density in DENSITIES {
        let plate = plate_and_drop::<D>(cells, density);
        let pool =
            Tank { bond: 1.0, angle: 90.0, density, cells, width: 4.0, center: 0.0 }.start::<D>(&|_| 0.0);
        for (what, sim) in [("drop on a plate", plate), ("body in a pool", pool)] {
            let text = format!("iterations of a solve, {what}, {D}D, D = {density}, {cells} cells/R");
            all.push(at_most(NAME, text, max_iterations(sim, STEPS)?, bar(20.0)));
        }
    }
    Ok(all)
}

/// Most iterations of a solve in a number of steps.
pub(super) fn max_iterations<const D: usize>(mut sim: Simulation<D>, steps: u64) -> Result<f64, StepError> {
    let mut most = 0;
    while sim.state.step < steps {
        let solves = sim.step(f64::INFINITY, &mut |_| ())?.solves.pressure;
        most = solves.iter().map(|s| s.iterations).fold(most, usize::max);
    }
    Ok(most as f64)
}
