//! Deformable blocks on slopes, with friction.

use crate::measure::{at_most, bars, checks_or_failure};
use crate::setup::{run_to, up};
use crate::soft::SoftMaterial;
use crate::solids_only::{
    ContactMonitor, GRAVITY, box_mesh, gravity, mapped, point_at, quadratic_cube_mesh,
    simulation_without_liquid, soft,
};
use crate::{Case, Check, Mode};
use meniscus_elastic::Anchor;
use meniscus_numerics::Vector;
use meniscus_numerics::grid::Grid;
use meniscus_numerics::shape::Shape;
use meniscus_sim::{Compiled, Simulation, Solid, SolidKind, StepError};

/// The case.
pub const CASE: Case = Case {
    name: "soft-slope",
    title: "Soft blocks slide on slopes, or stay, as Coulomb's friction says",
    theory: "No liquid. A soft block (E = 1e4, density 2, side 0.16, damped, g = 10) is put on a slope of 0.4 rad, 0.2 cells of \
        1/24 away, about as far as it comes to rest. Coulomb: it slides with g (sin α − μ cos α) if μ < tan α = 0.4228, and stays \
        if not. The acceleration of the parabola that fits its way best between 0.1 and 0.35 s, over g sin α; what stays does so \
        within 1e-3 of its side in a second, from 0.4 s on. Slopes: a rigid half-space; a soft slab that is held below \
        (E = 1e4), where gravity is turned. Steps of 1e-3; quick: 2D, three coefficients.",
    quick: true,
    run: |mode| checks_or_failure(NAME, run(mode)),
};

const NAME: &str = "soft-slope";
const SLOPE_ANGLE: f64 = 0.4;
const HALF_SIZE: f64 = 0.08;
const CELLS: usize = 24;
const DX: f64 = 1.0 / CELLS as f64;
const STEP: f64 = 1e-3;
/// Time window for sliding blocks: after the landing and before the lower end of the slope.
const SLIDING_WINDOW: [f64; 2] = [0.1, 0.35];
/// Time window for resting blocks, which slide until they lie on the slope; near the critical slope they stop late.
const RESTING_WINDOW: [f64; 2] = [0.4, 0.6];

fn run(mode: Mode) -> Result<Vec<Check>, StepError> {
    let mut checks = Vec::new();
    let rigid: &[f64] =
        if mode == Mode::Quick { &[0.0, 0.2, 0.6] } else { &[0.0, 0.1, 0.2, 0.3, 0.4, 0.44, 0.6] };
    for &friction in rigid {
        checks.extend(check_slope("rigid", on_rigid::<2>(friction)?, friction)?);
    }
    let some: &[f64] = if mode == Mode::Quick { &[0.2] } else { &[0.0, 0.2, 0.4, 0.44, 0.6] };
    for &friction in some {
        checks.extend(check_slope("soft", on_soft::<2>(friction)?, friction)?);
    }
    if mode == Mode::Full {
        for friction in [0.2, 0.6] {
            checks.extend(check_slope("rigid", on_rigid::<3>(friction)?, friction)?);
            checks.extend(check_slope("soft", on_soft::<3>(friction)?, friction)?);
        }
    }
    Ok(checks)
}

/// A slope as the first solid, and a block on it as the second.
struct Slope<const D: usize> {
    simulation: Simulation<D>,
    /// The direction down the slope.
    along: Vector<D>,
}

/// The solids' material.
const MATERIAL: SoftMaterial = SoftMaterial { young: 1e4, poisson: 0.3, density: 2.0, damping: 0.5 };

fn on_rigid<const D: usize>(friction: f64) -> Result<Slope<D>, StepError>
where
    Simulation<D>: Compiled<D>,
{
    let turned = |x: f64, y: f64| {
        let mut v = Vector::<D>::zeros();
        (v[0], v[D - 1]) =
            (SLOPE_ANGLE.cos() * x + SLOPE_ANGLE.sin() * y, SLOPE_ANGLE.cos() * y - SLOPE_ANGLE.sin() * x);
        v
    };
    let (normal, along) = (turned(0.0, 1.0), turned(1.0, 0.0));
    let point = Vector::repeat(0.4);
    let mut floor = Solid::new(Shape::HalfSpace { point, normal }, SolidKind::Fixed, 1.0);
    floor.friction = friction;
    let middle = point_at::<D>(0.2, 0.0);
    let middle = middle + normal * (HALF_SIZE + 0.2 * DX + (point - middle).dot(&normal));
    let place = |x: &Vector<D>| {
        let mut y = turned(x[0] * HALF_SIZE, x[D - 1] * HALF_SIZE);
        if D == 3 {
            y[1] = x[1] * HALF_SIZE;
        }
        middle + y
    };
    let block = soft(mapped(quadratic_cube_mesh([4; D]), place), MATERIAL, friction, Vec::new())?;
    let simulation =
        simulation_without_liquid(Grid::new([CELLS; D], DX), vec![floor, block], gravity(), STEP);
    Ok(Slope { simulation, along })
}

fn on_soft<const D: usize>(friction: f64) -> Result<Slope<D>, StepError>
where
    Simulation<D>: Compiled<D>,
{
    let high = 0.1;
    let half = Vector::<D>::from_fn(|a, _| [0.49, 0.2, 0.2][if a + 1 == D { 2 } else { a }]);
    let half = half.map(|h| h.min(0.49)) - up(0.2 - 0.5 * high);
    let cells: [usize; D] = std::array::from_fn(|a| [24, 10, 4][if a + 1 == D { 2 } else { a }]);
    let mesh = box_mesh(cells, point_at::<D>(0.5, 0.1 + 0.5 * high), half);
    let held = Anchor::within(&mesh, |x: &Vector<D>| x[D - 1] < 0.1 + 1e-9);
    let slab = soft(mesh, MATERIAL, friction, vec![held])?;
    let center = point_at::<D>(0.2, 0.1 + high + HALF_SIZE + 0.2 * DX);
    let body = soft(box_mesh([4; D], center, Vector::repeat(HALF_SIZE)), MATERIAL, friction, Vec::new())?;
    let mut gravity = Vector::<D>::zeros();
    (gravity[0], gravity[D - 1]) = (GRAVITY * SLOPE_ANGLE.sin(), -GRAVITY * SLOPE_ANGLE.cos());
    let along = Vector::from_fn(|a, _| if a == 0 { 1.0 } else { 0.0 });
    let simulation = simulation_without_liquid(Grid::new([CELLS; D], DX), vec![slab, body], gravity, STEP);
    Ok(Slope { simulation, along })
}

fn check_slope<const D: usize>(kind: &str, slope: Slope<D>, friction: f64) -> Result<Vec<Check>, StepError> {
    let Slope { mut simulation, along } = slope;
    let place = |s: &Simulation<D>| s.state.solids[1].center_of_mass().dot(&along);
    let scale = simulation.model.solids[1].mass_properties.mass * GRAVITY * 2.0 * HALF_SIZE;
    let free = GRAVITY * SLOPE_ANGLE.sin();
    let acceleration_expected = free - friction * GRAVITY * SLOPE_ANGLE.cos();
    let [from, to] = if acceleration_expected > 0.0 { SLIDING_WINDOW } else { RESTING_WINDOW };
    let mut watch = ContactMonitor::new(&simulation.model, scale);
    let mut samples: Vec<(f64, f64)> = Vec::new();
    run_to(&mut simulation, to, |s, report| {
        watch.observe(s, &report.diagnostics, true);
        if s.state.time >= from {
            samples.push((s.state.time, place(s)));
        }
    })?;
    let what = |text: &str| format!("{text}, {kind} slope, μ = {friction}, {D}D");
    let mut checks = Vec::new();
    if acceleration_expected > 0.0 {
        let found = acceleration(&samples) / free;
        let text = what("acceleration / g sin α");
        checks.push(Check::absolute(NAME, text, found, acceleration_expected / free, bars(0.01, 2e-3)));
    } else {
        let displacement =
            samples.last().zip(samples.first()).map_or(f64::NAN, |(end, start)| end.1 - start.1);
        let creep = displacement / (to - from) / (2.0 * HALF_SIZE);
        checks.push(at_most(NAME, what("it stays: creep in a second / side"), creep, bars(1e-3, 1e-5)));
    }
    checks.push(watch.check_gap(NAME, what("narrowest gap / cell"), DX, 0.02));
    checks.push(watch.check_rise(NAME, what("largest rise of the energy in a step / m g side")));
    Ok(checks)
}

/// Acceleration of the least-squares parabola through positions at times.
fn acceleration(seen: &[(f64, f64)]) -> f64 {
    let count = seen.len() as f64;
    let middle = seen.iter().map(|s| s.0).sum::<f64>() / count;
    // Normal equations of 1, t and t² about the mean time.
    let rows = seen.iter().map(|(t, x)| (Vector::<3>::new(1.0, t - middle, (t - middle).powi(2)), *x));
    let (mut matrix, mut right) = (meniscus_numerics::Matrix::<3>::zeros(), Vector::<3>::zeros());
    for (row, x) in rows {
        matrix += row * row.transpose();
        right += row * x;
    }
    matrix.try_inverse().map_or(f64::NAN, |inverse| 2.0 * (inverse * right)[2])
}
