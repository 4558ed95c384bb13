//! Newton iterations of steps in which a deformable solid rotates far.

use crate::measure::{at_most, bars, checks_or_failure, soft_motion};
use crate::setup::{block, unit_model};
use crate::soft::{SoftMaterial, not_made};
use crate::{Case, Check, Mode};
use meniscus_elastic::ElementOrder;
use meniscus_numerics::grid::Grid;
use meniscus_numerics::mesh::VolumeMesh;
use meniscus_numerics::{Matrix, Vector};
use meniscus_sim::{Compiled, Kinematics, Model, Numerics, Simulation, Solid, SolidKind, StepError, Wall};
use std::sync::Arc;

/// The case.
pub const CASE: Case = Case {
    name: "newton",
    title: "A spinning soft block keeps its angular momentum in long steps, with iterations",
    theory: "Without liquid and gravity: a block of 1 x 0.5 (3D: x 0.5), density 1, E = 10³, ν = 0.3, no damping, set spinning with \
        10 rad/s, in 20 steps of 0.01, in each of which it turns by a tenth: largest change of its angular momentum, which is \
        constant. Steps that end where nothing moves any more lose some of it, with `newton_iterations = 8` it must stay. \
        2D and 3D; quick: 2D.",
    quick: true,
    run: |mode| checks_or_failure(NAME, run(mode)),
};

const NAME: &str = "newton";
const STEP: f64 = 0.01;
const ANGULAR_VELOCITY: f64 = 10.0;
const STEPS: usize = 20;

fn run(mode: Mode) -> Result<Vec<Check>, StepError> {
    let mut checks = spinning::<2>()?;
    if mode == Mode::Full {
        checks.extend(spinning::<3>()?);
    }
    Ok(checks)
}

fn spinning<const D: usize>() -> Result<Vec<Check>, StepError>
where
    Simulation<D>: Compiled<D>,
{
    let (few, more) = (angular_momentum_drift::<D>(0)?, angular_momentum_drift::<D>(8)?);
    let what = |text: &str| format!("change of the angular momentum, {text}, {D}D");
    Ok(vec![
        at_most(NAME, what("as it comes"), few, bars(1e-6, 1e-9)),
        at_most(NAME, what("8 iterations"), more, bars(1e-9, 1e-9)),
    ])
}

/// Largest relative change of the angular momentum.
fn angular_momentum_drift<const D: usize>(iterations: u32) -> Result<f64, StepError>
where
    Simulation<D>: Compiled<D>,
{
    let mut sim = start::<D>(iterations)?;
    let turning = |sim: &Simulation<D>| soft_motion(sim, 0).angular_momentum;
    let before = turning(&sim);
    let mut most = 0f64;
    for _ in 0..STEPS {
        sim.step(f64::INFINITY, &mut |_| ())?;
        most = most.max((turning(&sim) - before).norm() / before.norm());
    }
    Ok(most)
}

/// The block, rotating about the last axis (2D: about its centre).
fn start<const D: usize>(iterations: u32) -> Result<Simulation<D>, StepError>
where
    Simulation<D>: Compiled<D>,
{
    let (center, half) = (Vector::repeat(1.0), Vector::from_fn(|a, _| if a == 0 { 0.5 } else { 0.25 }));
    let mesh = VolumeMesh::of_box(&center, &half, &Matrix::identity(), 0.125, ElementOrder::Quadratic)
        .unwrap_or_default();
    let material = SoftMaterial { young: 1e3, poisson: 0.3, density: 1.0, damping: 0.0 };
    let elastic = Arc::new(material.elastic(mesh, Vec::new()).map_err(not_made)?);
    let shape = block(center, half);
    let model = Model {
        surface_tension: 0.0,
        solids: vec![Solid::new(shape, SolidKind::Deformable(elastic), 1.0)],
        numerics: Numerics { max_step: STEP, newton_iterations: iterations, ..Numerics::default() },
        ..unit_model(Grid::<D>::new([20; D], 0.1), [[Wall::Open; 2]; D])
    };
    let mut sim = Simulation::new(model, &[]);
    if let Kinematics::Deformable(body) = &mut sim.state.solids[0].kinematics {
        for (v, x) in body.vertices.velocities.iter_mut().zip(&body.vertices.positions) {
            let from = x - center;
            *v = Vector::from_fn(|a, _| ANGULAR_VELOCITY * [-from[1], from[0], 0.0][a]);
        }
    }
    Ok(sim)
}
