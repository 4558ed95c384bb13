//! A drop at rest on a deformable plate that its weight bends, with contact-line friction.

use crate::measure::{bars, checks_or_failure, line_tracker};
use crate::setup::{StepBounds, at_rest, block, run_to, unit_model};
use crate::soft::SoftMaterial;
use crate::{Case, Check, Mode};
use meniscus_numerics::Vector;
use meniscus_numerics::grid::Grid;
use meniscus_sim::{Model, Simulation, StepError, Wall};

/// The case.
pub const CASE: Case = Case {
    name: "soft-sag",
    title: "A drop rests on a soft plate that sags, at Young's angle with steps of any length",
    theory: "2D twin of `fig22-plate-90`, SI: a drop (radius 5 mm, γ = 0.1, ν = 5·10⁻⁵, friction of the line 0.3 Pa s) on a plate \
        2.67 cells thick and 33.3 mm long (B = 5·10⁻⁵ N m, density 2500), clamped at both ends, that sags by several cells \
        under both: mean angle from 0.5 to 0.6 s with steps of 2 and 5 times the explicit capillary limit; the line feels the \
        plate's speed, which is nothing, not what a part of the forces would make it (2.6° too little with steps of 5). Quick: 5.",
    quick: true,
    run: |mode| checks_or_failure(NAME, run(mode)),
};

const NAME: &str = "soft-sag";
/// Cell size of the paper, m.
const DX: f64 = 0.52e-3;
const LENGTH: f64 = 64.0 * DX;
/// Four layers of elements of Δ/1.5.
const THICKNESS: f64 = 4.0 / 1.5 * DX;
const RADIUS: f64 = 5e-3;
const POISSON: f64 = 0.3;

fn run(mode: Mode) -> Result<Vec<Check>, StepError> {
    let steps: &[f64] = if mode == Mode::Quick { &[5.0] } else { &[2.0, 5.0] };
    steps.iter().map(|step| check(*step)).collect()
}

fn check(step: f64) -> Result<Check, StepError> {
    let angle = angle(StepBounds { capillary_step: step, ..StepBounds::default() })?;
    let text = format!("angle with steps of {step} times the explicit limit");
    Ok(Check::absolute(NAME, text, angle, 90.0, bars(1.5, 0.75)).in_unit("°"))
}

/// Mean contact angle at rest, degrees.
pub(crate) fn angle(bounds: StepBounds) -> Result<f64, StepError> {
    let mut sim = start(bounds)?;
    let tracker = line_tracker(&sim);
    run_to(&mut sim, 0.5, |_, _| ())?;
    let (mut sum, mut count) = (0.0, 0.0);
    run_to(&mut sim, 0.6, |sim, _| {
        sum += tracker.extract(sim).angle_statistics(None).map_or(f64::NAN, |a| a.0);
        count += 1.0;
    })?;
    Ok(sum / count)
}

fn start(bounds: StepBounds) -> Result<Simulation<2>, StepError> {
    let grid = Grid::<2>::new([96, 64], DX);
    let center = Vector::<2>::new(48.0 * DX, 21.0 * DX);
    let half = Vector::<2>::new(0.5 * LENGTH, 0.5 * THICKNESS);
    let shape = block(center, half);
    let clamped = half[0] - 1.3 * DX;
    let young = 5e-5 * 12.0 * (1.0 - POISSON * POISSON) / THICKNESS.powi(3);
    let material = SoftMaterial { young, poisson: POISSON, density: 2500.0, damping: 0.2 };
    let held = |x: &Vector<2>| (x[0] - center[0]).abs() > clamped;
    let mut solid = material.solid(shape, DX / 1.5, held)?;
    solid.line_friction = 0.3;
    let model = Model {
        density: 1000.0,
        kinematic_viscosity: 5e-5,
        surface_tension: 0.1,
        gravity: Vector::<2>::new(0.0, -9.81),
        solids: vec![solid],
        numerics: bounds.into(),
        ..unit_model(grid, [[Wall::Slip; 2]; 2])
    };
    let middle = center + Vector::<2>::new(0.0, half[1] + RADIUS);
    let drop = |x: &Vector<2>| (x - middle).norm() - RADIUS;
    Ok(at_rest(model, &drop))
}
