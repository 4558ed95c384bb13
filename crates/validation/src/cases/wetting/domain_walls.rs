//! Wetting at closed sides of the domain.

use super::meniscus::surface_height;
use super::sessile::{fit_cap, rms_and_mean_speed};
use crate::measure::{at_most, bars, checks_or_failure, line_tracker, surface_points};
use crate::setup::{at_rest, run_to, unit_model};
use crate::{Case, Check, Mode};
use meniscus_numerics::Vector;
use meniscus_numerics::grid::Grid;
use meniscus_sim::{Compiled, Model, Simulation, StepError, Wall};
use std::f64::consts::SQRT_2;

/// A tank, and drops in corners.
pub const CASE: Case = Case {
    name: NAME,
    title: "Sides of the domain that wet: a tank, and drops in its corners",
    theory: "A tank 14 capillary lengths lc wide (ρ = g = γ = 1, ν = 1, 8 cells per lc) is filled level. At its sides the contact \
        line rises √(2 (1 − sin θ)) lc over the level in the middle, or sinks. A drop in a corner of two sides (2D, 12 \
        cells a radius of the ball it starts as; ν = 0.3, no gravity) or three (3D, 10 cells) ends as part of a disc or ball: its \
        mean curvature is the same everywhere, and it meets every side at θ. Quick: a tank of 6 cells per lc, 60 degrees.",
    quick: true,
    run: |mode| checks_or_failure(NAME, run(mode)),
};

const NAME: &str = "walls";
/// Half-width of the tank, lc; the level in the middle is undisturbed to e⁻⁷.
const HALF_WIDTH: f64 = 7.0;
const TIME: f64 = 25.0;

fn run(mode: Mode) -> Result<Vec<Check>, StepError> {
    if mode == Mode::Quick {
        return tank(60.0, 6);
    }
    let mut checks = Vec::new();
    for angle in [30.0, 45.0, 60.0, 120.0, 135.0, 150.0] {
        checks.extend(tank(angle, 8)?);
    }
    for angle in [60.0, 75.0, 120.0] {
        checks.extend(corner::<2>(angle, 12)?);
    }
    for angle in [75.0, 105.0] {
        checks.extend(corner::<3>(angle, 10)?);
    }
    Ok(checks)
}

/// A box with closed sides and liquid (ρ = γ = 1) at a contact angle (degrees).
fn walled<const D: usize>(grid: Grid<D>, angle: f64) -> Model<D> {
    let model = Model { kinematic_viscosity: 1.0, ..unit_model(grid, [[Wall::Slip; 2]; D]) };
    model.with_wetting_walls(angle.to_radians().cos(), 0.0, None)
}

/// Rise of a bath at the sides.
fn tank(angle: f64, cells: usize) -> Result<Vec<Check>, StepError> {
    let dx = 1.0 / cells as f64;
    let mut model = walled(Grid::<2>::new([(2.0 * HALF_WIDTH) as usize * cells, 5 * cells], dx), angle);
    model.gravity[1] = -1.0;
    let distance = |x: &Vector<2>| x[1] - 2.43;
    let mut sim = at_rest(model, &distance);
    run_to(&mut sim, TIME, |_, _| ())?;
    let line = line_tracker(&sim).extract(&sim);
    let risen = match line.points[..] {
        [left, right] => {
            0.5 * (left.at[1] + right.at[1]) - surface_height(&sim, sim.model.grid.domain_upper() * 0.5)
        }
        _ => f64::NAN,
    };
    let should = (SQRT_2 * (1.0 - angle.to_radians().sin()).sqrt()).copysign(90.0 - angle);
    let what = |text: &str| format!("{text}, tank, θ = {angle}°");
    Ok(vec![
        Check::relative(NAME, what("height"), risen, should, bars(0.02, 0.01)).in_unit("lc"),
        at_most(NAME, what("u_rms / √(g lc)"), rms_and_mean_speed(&sim).0, bars(1e-2, 1e-3)),
    ])
}

/// The shape of a drop in the corner of one side per axis.
fn corner<const D: usize>(angle: f64, cells: usize) -> Result<Vec<Check>, StepError>
where
    Simulation<D>: Compiled<D>,
{
    let (dx, wide) = (1.0 / cells as f64, if D == 2 { 3 * cells } else { 2 * cells });
    let mut model = walled(Grid::<D>::new([wide; D], dx), angle);
    model.kinematic_viscosity = 0.3;
    let middle = Vector::from_fn(|a, _| [0.31, 0.17, 0.05][a]);
    let distance = |x: &Vector<D>| (x - middle).norm() - 1.0;
    let mut sim = at_rest(model, &distance);
    run_to(&mut sim, TIME, |_, _| ())?;
    let away = |x: &Vector<D>| x.min() > 1.5 * dx;
    let ball = fit_cap(&sim, away);
    let along = |a: usize| Vector::from_fn(|b, _| if a == b { 1.0 } else { 0.0 });
    let angles = (0..D).map(|a| ball.angle_on_plane(&Vector::zeros(), &along(a)));
    let found =
        angles.fold(angle, |worst, x| if (x - angle).abs() > (worst - angle).abs() { x } else { worst });
    let points = surface_points(&sim.model, &sim.state.phi);
    let off =
        points.iter().filter(|p| away(&p.at)).map(|p| ((p.at - ball.center).norm() - ball.radius).abs());
    let off = off.fold(0.0, f64::max) / ball.radius;
    let what = |text: &str| format!("{text}, {D}D corner, θ = {angle}°");
    Ok(vec![
        Check::absolute(NAME, what("angle, the worst of the sides"), found, angle, bars(2.0, 1.0))
            .in_unit("deg"),
        at_most(NAME, what("distance from a ball / its radius"), off, bars(1e-2, 5e-3)),
        at_most(NAME, what("u_rms √(ρ R / γ)"), rms_and_mean_speed(&sim).0, bars(1e-2, 1e-3)),
    ])
}
