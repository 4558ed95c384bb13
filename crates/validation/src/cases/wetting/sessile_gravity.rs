//! Sessile drops under gravity, and their force on the solid.

use super::sessile::{fit_cap, rms_and_mean_speed, sessile_model};
use crate::measure::{at_most, bars, checks_or_failure, line_tracker, surface_points};
use crate::setup::{across_and_up, at_rest, run_to, up, wetted};
use crate::{Case, Check, Mode};
use meniscus_numerics::fit::least_squares;
use meniscus_numerics::grid::Grid;
use meniscus_numerics::shape::Shape;
use meniscus_numerics::{Matrix, Vector};
use meniscus_sim::{Compiled, Simulation, StepError};
use std::f64::consts::PI;

/// Drops under gravity in 2D.
pub const CASE_2D: Case = Case {
    name: "sessile-gravity-2d",
    title: "Drops on a wall under gravity, 2D",
    theory: "A drop as large as a disc of radius R0 = 1 (γ = ρ = 1, ν = 1, Bo = ρgR0²/γ of 1 and 5) on a wall \
        without friction 0.3 cells off the grid's faces, 16 cells per R0; it starts as half an ellipse with 85 \
        % of the base that it should have and is left alone for 30 √(ρR0³/γ), at 30 degrees 60. Base radius \
        (from the contact line's points) and height (a parabola through the surface around the top) from the \
        Young–Laplace equation, and Young's angle along the line. The force on the wall is the drop's weight, \
        the mean over the last tenth of the run; without gravity the contact line pulls with 2γ sin θ what the \
        pressure of the drop pushes. Quick: θ = 60 degrees at Bo = 1, half as long.",
    quick: true,
    run: |mode| checks_or_failure("sessile-gravity-2d", plane(mode)),
};

/// Drops under gravity in 3D.
pub const CASE_3D: Case = Case {
    name: "sessile-gravity-3d",
    title: "Drops on a wall under gravity, 3D",
    theory: "As in 2D, R0 being the radius of a ball as large as the drop; a quarter of the drop, beside two planes of \
        symmetry, 16 cells per R0, left alone for 20 √(ρR0³/γ). Quick: θ = 60 degrees at Bo = 1, 8 cells per R0.",
    quick: false,
    run: |mode| checks_or_failure("sessile-gravity-3d", space(mode)),
};

/// A drop of the table: angle (degrees), Bond number, height and base radius over R0.
#[derive(Clone, Copy)]
struct Row {
    angle: f64,
    bond: f64,
    height: f64,
    base: f64,
}

const fn row(angle: f64, bond: f64, height: f64, base: f64) -> Row {
    Row { angle, bond, height, base }
}

const ROWS: [Row; 12] = [
    row(30.0, 1.0, 0.49989, 3.99804),
    row(30.0, 5.0, 0.23149, 7.21743),
    row(45.0, 1.0, 0.69775, 2.96354),
    row(45.0, 5.0, 0.34227, 5.00235),
    row(60.0, 1.0, 0.86168, 2.41006),
    row(60.0, 5.0, 0.44709, 3.89971),
    row(90.0, 1.0, 1.12208, 1.77022),
    row(90.0, 5.0, 0.63088, 2.79987),
    row(120.0, 1.0, 1.31705, 1.35572),
    row(120.0, 5.0, 0.76966, 2.25145),
    row(135.0, 1.0, 1.39105, 1.18472),
    row(135.0, 5.0, 0.81961, 2.07197),
];
const ROWS_3D: [Row; 6] = [
    row(60.0, 1.0, 0.77621, 1.71595),
    row(60.0, 5.0, 0.47835, 2.01063),
    row(90.0, 1.0, 1.04291, 1.38849),
    row(90.0, 5.0, 0.66469, 1.66933),
    row(120.0, 1.0, 1.25865, 1.12230),
    row(120.0, 5.0, 0.80148, 1.44373),
];
/// Duration of the runs, √(ρR0³/γ); thin drops are slower.
const TIME_2D: f64 = 30.0;
const SLOW_ANGLE_AND_TIME: (f64, f64) = (30.0, 60.0);
const TIME_3D: f64 = 20.0;

fn plane(mode: Mode) -> Result<Vec<Check>, StepError> {
    let case = "sessile-gravity-2d";
    if mode == Mode::Quick {
        return drop::<2>(case, 16, ROWS[4], 15.0);
    }
    let mut checks = Vec::new();
    for row in ROWS {
        let time = if row.angle <= SLOW_ANGLE_AND_TIME.0 { SLOW_ANGLE_AND_TIME.1 } else { TIME_2D };
        checks.extend(drop::<2>(case, 16, row, time)?);
    }
    for angle in [60.0, 90.0, 120.0] {
        checks.extend(weightless(case, 16, angle)?);
    }
    Ok(checks)
}

fn space(mode: Mode) -> Result<Vec<Check>, StepError> {
    let case = "sessile-gravity-3d";
    if mode == Mode::Quick {
        return drop::<3>(case, 8, ROWS_3D[0], TIME_3D);
    }
    let mut checks = Vec::new();
    for row in ROWS_3D {
        checks.extend(drop::<3>(case, 16, row, TIME_3D)?);
    }
    Ok(checks)
}

/// A drop on a wall, and the point of the wall under its middle.
struct WallDrop<const D: usize> {
    sim: Simulation<D>,
    point: Vector<D>,
}

/// Share of a drop in the domain: in 3D a quarter, beside two planes of symmetry.
const fn share<const D: usize>() -> f64 {
    if D == 3 { 0.25 } else { 1.0 }
}

/// Half an ellipse on a wall, with the given volume and base, and room for a drop of half-width `widest`. In 3D a quarter of half an
/// ellipsoid around the vertical edge of the domain.
fn start_drop<const D: usize>(
    cells: usize,
    angle: f64,
    gravity: f64,
    volume: f64,
    base: f64,
    widest: f64,
) -> WallDrop<D>
where
    Simulation<D>: Compiled<D>,
{
    let dx = 1.0 / cells as f64;
    let round = |x: f64| (x * cells as f64).ceil() as usize;
    let mut height = if D == 2 { 2.0 * volume / (PI * base) } else { 1.5 * volume / (PI * base * base) };
    let size: [usize; D] = std::array::from_fn(|a| {
        if a + 1 == D { round(1.0 + 1.2 * height) } else { (4 - D) * round(1.15 * widest + 0.4) }
    });
    let grid = Grid::<D>::new(size, dx);
    let mut point = if D == 3 { Vector::zeros() } else { grid.domain_upper() * 0.5 };
    point[D - 1] = (0.4 * cells as f64).floor() * dx + 0.3 * dx;
    let normal = up(1.0);
    let wall = wetted(Shape::HalfSpace { point, normal }, angle);
    let mut model = sessile_model(grid, wall);
    model.kinematic_viscosity = 1.0;
    model.gravity[D - 1] = -gravity;
    let start = |height: f64| {
        let radii = across_and_up(base, height);
        let ellipsoid = Shape::Ellipsoid { center: point, radii, rotation: Matrix::identity() };
        let distance = |x: &Vector<D>| ellipsoid.signed_distance(x);
        at_rest(model.clone(), &distance)
    };
    // Corrects the volume, which is sampled on the lattice.
    for _ in 0..4 {
        height *= share::<D>() * volume / start(height).diagnostics().volume;
    }
    WallDrop { sim: start(height), point }
}

fn drop<const D: usize>(case: &str, cells: usize, row: Row, time: f64) -> Result<Vec<Check>, StepError>
where
    Simulation<D>: Compiled<D>,
{
    let Row { angle, bond, height, base } = row;
    let volume = if D == 2 { PI } else { 4.0 / 3.0 * PI };
    let WallDrop { mut sim, point } = start_drop::<D>(cells, angle, bond, volume, 0.85 * base, base);
    run_to(&mut sim, 0.9 * time, |_, _| ())?;
    let (_, force) = mean_forces(&mut sim, time)?;
    let (found_height, found_base, found_angle) = drop_dimensions(&sim, &point);
    let of_angle = if angle < 45.0 { bars(3.0, 1.5) } else { bars(1.5, 0.5) };
    let what = |text: &str| format!("{text}, θ = {angle}°, Bo = {bond}, {cells} cells/R0");
    let weight = share::<D>() * volume * bond;
    Ok(vec![
        Check::relative(case, what("height"), found_height, height, bars(0.02, 0.007)).in_unit("R0"),
        Check::relative(case, what("base radius"), found_base, base, bars(0.02, 0.007)).in_unit("R0"),
        Check::relative(case, what("force on the wall"), -force, weight, bars(0.02, 0.005)),
        Check::absolute(case, what("angle along the line"), found_angle, angle, of_angle).in_unit("deg"),
        at_most(case, what("u_rms √(ρR0/γ)"), rms_and_mean_speed(&sim).0, bars(1e-2, 1e-3)),
    ])
}

/// A drop without gravity: contact-line force against pressure force.
fn weightless(case: &str, cells: usize, angle: f64) -> Result<Vec<Check>, StepError> {
    let WallDrop { mut sim, point } = start_drop::<2>(cells, angle, 0.0, 0.5 * PI, 1.0, 1.4);
    run_to(&mut sim, 12.0, |_, _| ())?;
    let (pull, sum) = mean_forces(&mut sim, 15.0)?;
    let above = |x: &Vector<2>| x[1] - point[1] > 1.5 / cells as f64;
    let cap = fit_cap(&sim, above);
    let laplace = 2.0 * drop_dimensions(&sim, &point).1 / cap.radius;
    let what = |text: &str| format!("{text}, θ = {angle}°, no gravity");
    let should = 2.0 * angle.to_radians().sin();
    Ok(vec![
        Check::relative(case, what("pull of the contact line"), pull, should, bars(0.02, 0.005)),
        Check::relative(case, what("push of the pressure"), pull - sum, should, bars(0.02, 0.005)),
        Check::relative(case, what("2 a γ/R of the drop's shape"), laplace, should, bars(0.02, 0.005)),
        at_most(case, what("force on the wall over γ"), sum, bars(0.02, 0.005)),
    ])
}

/// Means until `end` of the upward contact-line force on the wall, and of the total force of the liquid.
fn mean_forces<const D: usize>(sim: &mut Simulation<D>, end: f64) -> Result<(f64, f64), StepError> {
    let start = sim.state.time;
    let (mut pull, mut all) = (0.0, 0.0);
    run_to(sim, end, |sim, report| {
        let wall = &sim.state.solids[0];
        pull += wall.contact_line_force[D - 1] * report.dt;
        all += (wall.contact_line_force + wall.pressure_force)[D - 1] * report.dt;
    })?;
    let time = sim.state.time - start;
    Ok((pull / time, all / time))
}

/// Height over a horizontal wall through a point, base radius, and mean angle along the line, degrees.
fn drop_dimensions<const D: usize>(sim: &Simulation<D>, point: &Vector<D>) -> (f64, f64, f64) {
    let dx = sim.model.grid.dx;
    let line = line_tracker(sim).extract(sim);
    let length: f64 = line.points.iter().map(|p| p.length).sum();
    let middle = line.points.iter().map(|p| p.at * p.length).sum::<Vector<D>>() / length;
    // A quarter of a drop has its middle at the edge of the domain.
    let quarter = D == 3;
    let middle = if quarter { up(middle[D - 1]) } else { middle };
    let base = line.points.iter().map(|p| (p.at - middle).norm() * p.length).sum::<f64>() / length;
    let points = surface_points(&sim.model, &sim.state.phi);
    let top = points.iter().filter_map(|p| {
        let mut arm = p.at - middle;
        let up = arm[D - 1];
        arm[D - 1] = 0.0;
        let (near, bend) = (arm.norm() < 4.0 * dx && p.normal[D - 1] > 0.5, arm.norm_squared());
        let tilt = if quarter { 0.0 } else { arm[0] };
        near.then_some((p.area, [1.0, tilt, bend], up))
    });
    let pin = (1e-12, [0.0, 1.0, 0.0], 0.0);
    let apex = least_squares(top.chain([pin])).map_or(f64::NAN, |c| c[0]);
    (apex + middle[D - 1] - point[D - 1], base, line.angle_statistics(None).map_or(f64::NAN, |a| a.0))
}
