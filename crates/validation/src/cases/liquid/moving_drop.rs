//! A moving drop: Galilean invariance.

use crate::measure::{at_most, bars, checks_or_failure, volume_and_centroid};
use crate::setup::{RADIUS, TENSION, grid_offset, model, roundness, run_to, with_bodies};
use crate::{Case, Check, Mode};
use meniscus_numerics::Vector;
use meniscus_numerics::grid::Grid;
use meniscus_numerics::shape::Shape;
use meniscus_sim::{Compiled, Simulation, StepError, Wall};

/// The case.
pub const CASE: Case = Case {
    name: "moving-drop",
    title: "Flying drop",
    theory: "A round drop (R = 0.5, γ = 100, ρ = 1, ν = 0, speed 10 along the first axis and 1 along the others) flies \
        12 radii, three lengths of a box of 4 R. In its own frame it is at rest: it stays round, keeps volume and \
        Laplace's pressure, and moves uniformly (Popinet, J. Comput. Phys. 228, 2009: codes show motion of 1e-3 U \
        and more). Full: 2D with 16 cells per radius, 3D with 10; quick: 2D with 8, bar of the shape 3 %, \
        without the inner motion.",
    quick: true,
    run: |mode| checks_or_failure("moving-drop", run(mode)),
};

/// Distance of flight, in radii.
const FLIGHT_RADII: f64 = 12.0;
/// Speed along the first axis.
const SPEED: f64 = 10.0;

fn run(mode: Mode) -> Result<Vec<Check>, StepError> {
    if mode == Mode::Quick {
        // Internal motion is checked on the full grids only.
        let mut checks = fly::<2>(8, 0.03)?;
        checks.retain(|c| !c.quantity.contains("max|u|"));
        return Ok(checks);
    }
    let mut checks = fly::<2>(16, 0.01)?;
    checks.extend(fly::<3>(10, 0.02)?);
    Ok(checks)
}

fn fly<const D: usize>(cells: usize, round: f64) -> Result<Vec<Check>, StepError>
where
    Simulation<D>: Compiled<D>,
{
    let dx = RADIUS / cells as f64;
    let wide = (4.4 * cells as f64) as usize;
    let long = ((FLIGHT_RADII + 3.4) * cells as f64) as usize;
    let grid = Grid::<D>::new(std::array::from_fn(|a| if a == 0 { long } else { wide }), dx);
    let mut model = model(grid, [[Wall::Open; 2]; D]);
    model.numerics.tolerance = 1e-8;
    let center = Vector::from_element(1.6 * RADIUS) + grid_offset::<D>(dx);
    let velocity = Vector::from_fn(|a, _| if a == 0 { SPEED } else { SPEED / 10.0 });
    let shape = Shape::Ball { center, radius: RADIUS };
    let mut sim = with_bodies(model, &[(shape, velocity)]);
    let (mut deviation, mut volume, mut centroid_deviation, mut pressure): (f64, f64, f64, f64) =
        (0.0, 0.0, 0.0, 0.0);
    let measured = |sim: &Simulation<D>| volume_and_centroid(&sim.model, &sim.state.phi);
    let first = measured(&sim);
    let laplace = TENSION * (D as f64 - 1.0) / RADIUS;
    run_to(&mut sim, FLIGHT_RADII * RADIUS / SPEED, |sim, report| {
        if let Some(shape) = roundness(sim, 2) {
            deviation = deviation.max((shape.deviation + shape.amplitude.abs()) / RADIUS);
        }
        let (_, place) = measured(sim);
        let path = first.1 + velocity * sim.state.time;
        centroid_deviation = centroid_deviation.max((place - path).norm() / dx);
        volume = volume.max(report.diagnostics.volume_error.abs());
        let cell = place.map(|x| (x / dx) as usize);
        let cell = grid.lattice().index(std::array::from_fn(|a| cell[a]));
        pressure = sim.state.pressure(sim.model.density, cell);
    })?;
    let what = |text: &str| format!("{text}, {D}D, {cells} cells/R");
    let case = "moving-drop";
    let inner = (sim.diagnostics().max_speed - SPEED).abs() / (TENSION / (2.0 * RADIUS)).sqrt();
    Ok(vec![
        at_most(case, what("largest deviation from round / R"), deviation, bars(round, 0.003)),
        at_most(case, what("volume error"), volume, bars(1e-4, 1e-8)),
        at_most(case, what("centre of mass off its straight path / Δ"), centroid_deviation, bars(0.1, 0.01)),
        at_most(case, what("(max|u| − U) / √(γ/ρD) at the end"), inner, bars(0.01, 0.001)),
        Check::relative(case, what("Laplace pressure at the end"), pressure, laplace, bars(0.03, 0.005)),
    ])
}
