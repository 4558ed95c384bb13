//! An elastic solid that is stretched and released in liquid.

use crate::measure::{at_least, at_most, bars, checks_or_failure, soft_motion};
use crate::setup::{at_rest, grid_offset, run_to, unit_model};
use crate::soft::SoftMaterial;
use crate::{Case, Check, Mode};
use meniscus_numerics::Vector;
use meniscus_numerics::grid::Grid;
use meniscus_numerics::shape::Shape;
use meniscus_sim::{Compiled, Kinematics, Model, Numerics, Simulation, StepError, Wall};

/// The case.
pub const CASE: Case = Case {
    name: "soft-release",
    title: "An elastic body let go in liquid keeps momentum and wins no energy",
    theory: "No gravity, no surface tension: a ball (radius 0.45, density 1.3, E = 10, ν = 0.4, no damping) in \
        a ball of liquid (radius 1, ρ = 1, ν = 0.003), off its middle, stretched by a quarter along an axis \
        and let go. Momentum over √(2 E0 m) of both together, angular momentum over that times the radius, and \
        the largest rise of the energy over that at the start, E0, when all of it is elastic. Motion at a \
        step's start: the mean of those half a step before and after. 16 cells a unit, in 3D 8; quick: 12, 2D \
        only.",
    quick: true,
    run: |mode| checks_or_failure(NAME, run(mode)),
};

const NAME: &str = "soft-release";
const RADIUS: f64 = 0.45;
const DENSITY: f64 = 1.3;
/// Stretch along the first axis; the others shrink, so that the volume is conserved.
const STRETCH: f64 = 1.25;
const STEP: f64 = 0.01;

fn run(mode: Mode) -> Result<Vec<Check>, StepError> {
    let cells = if mode == Mode::Quick { 12 } else { 16 };
    let mut checks = release::<2>(cells, 4.0)?;
    if mode == Mode::Full {
        checks.extend(release::<3>(8, 2.0)?);
    }
    Ok(checks)
}

/// The stretched solid in its liquid.
fn start<const D: usize>(cells: usize) -> Result<Simulation<D>, StepError>
where
    Simulation<D>: Compiled<D>,
{
    let dx = 1.0 / cells as f64;
    let middle = Vector::repeat(1.6) + grid_offset(dx);
    let shape = Shape::Ball { center: middle + Vector::from_fn(|a, _| [0.2, 0.1, -0.1][a]), radius: RADIUS };
    let material = SoftMaterial { young: 10.0, poisson: 0.4, density: DENSITY, damping: 0.0 };
    let solid = material.solid(shape, dx / 1.5, |_| false)?;
    let model = Model {
        kinematic_viscosity: 0.003,
        surface_tension: 0.0,
        solids: vec![solid],
        numerics: Numerics { max_step: STEP, tolerance: 1e-8, ..Numerics::default() },
        ..unit_model(Grid::<D>::new([(3.2 * cells as f64) as usize; D], dx), [[Wall::Open; 2]; D])
    };
    let liquid = move |x: &Vector<D>| (x - middle).norm() - 1.0;
    let still = at_rest(model, &liquid);
    let Simulation { model, mut state, .. } = still;
    let elastic = model.solids[0].elastic();
    if let (Some(elastic), Kinematics::Deformable(body)) = (elastic, &mut state.solids[0].kinematics) {
        let narrow = STRETCH.powf(-1.0 / (D as f64 - 1.0));
        let center = body.center;
        let stretched = |x: &Vector<D>| {
            center + Vector::from_fn(|a, _| (x - center)[a] * if a == 0 { STRETCH } else { narrow })
        };
        body.vertices.positions.iter_mut().for_each(|x| *x = stretched(x));
        body.update_center_of_mass(elastic);
    }
    Ok(Simulation::resume(model, state))
}

fn release<const D: usize>(cells: usize, time: f64) -> Result<Vec<Check>, StepError>
where
    Simulation<D>: Compiled<D>,
{
    let mut sim = start::<D>(cells)?;
    let books = sim.diagnostics();
    let start = books.elastic_energy;
    let scale = (2.0 * start * (books.target_volume + soft_motion(&sim, 0).mass)).sqrt();
    let (mut linear, mut turning, mut rise, mut moving) = (0f64, 0f64, 0f64, 0f64);
    run_to(&mut sim, time, |sim, report| {
        let own = soft_motion(sim, 0);
        let books = &report.diagnostics;
        linear = linear.max((books.momentum + own.momentum).norm() / scale);
        turning =
            turning.max((Vector::<3>::from(books.angular_momentum) + own.angular_momentum).norm() / scale);
        let (moves, stretches) = (books.kinetic_energy, books.elastic_energy);
        rise = rise.max((moves + stretches) / start - 1.0);
        moving = moving.max(moves / start);
    })?;
    let what = |text: &str| format!("{text}, {D}D, {cells} cells a unit");
    Ok(vec![
        at_most(NAME, what("momentum / √(2 E0 m)"), linear, bars(1e-8, 1e-12)),
        at_most(NAME, what("angular momentum / R √(2 E0 m)"), turning, bars(1e-3, 1e-8)),
        at_most(NAME, what("rise of the energy / E0"), rise, bars(1e-3, 1e-4)),
        at_least(NAME, what("largest kinetic energy / E0: it swings"), moving, 0.3, 0.5),
    ])
}
