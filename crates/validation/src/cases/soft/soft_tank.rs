//! An elastic plate as the bottom of a tank.

use crate::measure::{at_most, bars, checks_or_failure};
use crate::setup::{at_rest, block, run_to, unit_model};
use crate::soft::SoftMaterial;
use crate::{Case, Check, Mode};
use meniscus_numerics::Vector;
use meniscus_numerics::grid::Grid;
use meniscus_sim::{Model, StepError, Wall};

/// The case.
pub const CASE: Case = Case {
    name: "soft-tank",
    title: "A plate bears the water over it",
    theory: "2D, g and cm: a plate 10 long and 0.4 thick (E = 2·10⁹, ν = 0.3, density 1.2), clamped at both \
        ends, with 5 of water over it and air below. Its middle sinks by q L⁴/384 B = 0.0119435 (small \
        deflection: a plate ten times softer sinks by 0.3 of its thickness, and its ends, which cannot come \
        nearer, hold it up by 4 % more than that says), and the water comes to rest: largest speed over √(g \
        H). 15 cells a unit; quick: 10.",
    quick: true,
    run: |mode| checks_or_failure(NAME, run(mode)),
};

const NAME: &str = "soft-tank";
const LENGTH: f64 = 10.0;
const THICKNESS: f64 = 0.4;
/// Height of the plate's middle over the floor.
const PLATE_HEIGHT: f64 = 2.03;
const DEPTH: f64 = 5.0;
const GRAVITY: f64 = 980.0;

fn run(mode: Mode) -> Result<Vec<Check>, StepError> {
    let cells = if mode == Mode::Quick { 10.0 } else { 15.0 };
    let dx = 1.0 / cells;
    let grid = Grid::<2>::new([(LENGTH * cells) as usize, (8.8 * cells) as usize], dx);
    // The plate extends into the walls, where it is anchored.
    let (center, half) =
        (Vector::<2>::new(0.5 * LENGTH, PLATE_HEIGHT), Vector::<2>::new(0.5 * LENGTH + 0.4, 0.5 * THICKNESS));
    let shape = block(center, half);
    let material = SoftMaterial { young: 2e9, poisson: 0.3, density: 1.2, damping: 1.0 };
    let plate = material.solid(shape, 0.1f64.min(dx), |x| x[0] < 1e-9 || x[0] > LENGTH - 1e-9)?;
    let rest = plate.elastic().map_or(&[][..], |elastic| &elastic.rest_mesh().positions);
    let middle: Vec<usize> = (0..rest.len()).filter(|k| (rest[*k] - center).norm() < 0.06).collect();
    let model = Model {
        kinematic_viscosity: 5.0,
        surface_tension: 72.0,
        gravity: Vector::<2>::new(0.0, -GRAVITY),
        solids: vec![plate],
        ..unit_model(grid, [[Wall::Slip; 2]; 2])
    };
    let top = PLATE_HEIGHT + 0.5 * THICKNESS + DEPTH;
    let water = |x: &Vector<2>| (x[1] - top).max(PLATE_HEIGHT - x[1]);
    let mut sim = at_rest(model, &water);
    run_to(&mut sim, 1.0, |_, _| ())?;
    let speed = sim.diagnostics().max_speed / (GRAVITY * DEPTH).sqrt();
    let sunk = |k: &usize| {
        sim.state.solids[0].as_deformable().map_or(0.0, |b| PLATE_HEIGHT - b.vertices.positions[*k][1])
    };
    let sunk = middle.iter().map(sunk).sum::<f64>() / middle.len() as f64;
    let text = |what: &str| format!("{what}, {cells} cells a unit");
    Ok(vec![
        Check::relative(NAME, text("deflection of the middle"), sunk, 0.0119435, bars(0.04, 0.01))
            .in_unit("cm"),
        at_most(NAME, text("largest speed / √(gH)"), speed, bars(1e-4, 1e-6)),
    ])
}
