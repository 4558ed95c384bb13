//! Menisci at wetting and non-wetting walls: plates, gaps and tubes.

use super::sessile::{rms_and_mean_speed, sessile_model};
use crate::cases::rigid::floating::level_by_pressure;
use crate::measure::{at_most, bars, bisect, checks_or_failure, line_tracker};
use crate::setup::{at_rest, block, run_to, wetted};
use crate::{Case, Check, Mode};
use meniscus_numerics::Vector;
use meniscus_numerics::grid::{Grid, Sampler};
use meniscus_numerics::shape::Shape;
use meniscus_sim::{Compiled, Model, Simulation, StepError};
use std::f64::consts::{PI, SQRT_2};

/// Plates and gaps in 2D.
pub const CASE_2D: Case = Case {
    name: "meniscus-2d",
    title: "Menisci at plates and between them, 2D",
    theory: "A bath (ρ = g = γ = 1, so the capillary length lc is 1; ν = 1, 8 cells per lc, 12.5 for gaps) \
        that starts level. At an upright wall the contact line rises √(2 (1 − sin θ)) lc, or sinks, 8 lc from \
        the tank's end, where the level is measured. A plate 1 lc thick that reaches 2 lc below the level is \
        borne by its buoyancy up to the level less γ cos θ for each side (Wilhelmy). Between plates a distance \
        of 2a apart, dipping into a bath, the liquid stands, at the middle, as high as the Young–Laplace \
        equation says. Quick: 60 degrees, wall and plate.",
    quick: false,
    run: |mode| checks_or_failure(PLANE_NAME, plane(mode)),
};

/// Tubes in 3D.
pub const TUBE: Case = Case {
    name: "tube",
    title: "A tube in a bath, 3D",
    theory: "A round tube of radius a = lc/2 dips one lc into a bath (ρ = g = γ = 1; ν = 0.2, and friction of \
        the contact line, 0.3, so that the column neither swings nor creeps). A quarter of it, beside two \
        planes of symmetry, 8 cells per radius. The height of the meniscus in the middle over the level at \
        which the pressure at the bath's bottom would vanish is that of the axisymmetric Young–Laplace \
        equation (Jurin), as its mean from 25 to 30 √(lc/g): the pressure that \
        gives the level varies, by the row of the standard deviation. Quick: 60 degrees, 6 cells.",
    quick: false,
    run: |mode| checks_or_failure(TUBE_NAME, tubes(mode)),
};

const TUBE_NAME: &str = "tube";
/// Angle (degrees), and height in the middle of a tube of radius lc/2 over lc.
const TUBES: [(f64, f64); 3] = [(30.0, 3.33983), (60.0, 1.93611), (120.0, -1.93611)];
const PLANE_NAME: &str = "meniscus-2d";
const ANGLES: [f64; 4] = [30.0, 60.0, 120.0, 150.0];
/// Half the gap over lc, angle (degrees), height in the middle over lc.
const GAPS: [(f64, f64, f64); 4] =
    [(0.5, 30.0, 1.65156), (0.5, 60.0, 0.95797), (1.0, 30.0, 0.72221), (1.0, 60.0, 0.42316)];
/// Distance from a plate to the tank's end, lc.
const PLATE_TO_END_DISTANCE: f64 = 8.0;
const TIME: f64 = 25.0;
/// End of the time over which the height in a tube is averaged, in [`TIME`]: 25 times the time (0.2) after which its variations are independent.
const TUBE_MEAN_END: f64 = 1.2;

fn plane(mode: Mode) -> Result<Vec<Check>, StepError> {
    let mut checks = Vec::new();
    let angles = if mode == Mode::Quick { &ANGLES[1..2] } else { &ANGLES[..] };
    for &angle in angles {
        checks.extend(wall(angle)?);
    }
    for &angle in angles {
        checks.extend(plate(angle)?);
    }
    for &(half, angle, should) in GAPS.iter().filter(|_| mode == Mode::Full) {
        checks.extend(gap(half, angle, should)?);
    }
    Ok(checks)
}

/// A tank with a solid that the liquid meets at a contact angle (degrees).
fn tank<const D: usize>(grid: Grid<D>, shape: Shape<D>, angle: f64) -> Model<D> {
    let solid = wetted(shape, angle);
    let mut model = sessile_model(grid, solid);
    model.kinematic_viscosity = 1.0;
    model.gravity[D - 1] = -1.0;
    model
}

/// The tank filled to a level.
fn bath<const D: usize>(model: Model<D>, level: f64) -> Simulation<D>
where
    Simulation<D>: Compiled<D>,
{
    let distance = |x: &Vector<D>| x[D - 1] - level;
    at_rest(model, &distance)
}

/// Height of the surface above or below a point.
pub(crate) fn surface_height<const D: usize>(sim: &Simulation<D>, x: Vector<D>) -> f64 {
    let grid = &sim.model.grid;
    let sampler = Sampler::cells(grid, &sim.state.phi.data, sim.model.scalar_boundary());
    let at = |height: f64| {
        let mut x = x;
        x[D - 1] = height;
        sampler.cubic(&x)
    };
    let mut high = grid.domain_upper()[D - 1];
    let mut low = high - grid.dx;
    while low > 0.0 && at(low) >= 0.0 {
        (low, high) = (low - grid.dx, low);
    }
    let [low, high] = bisect([low, high], 50, |height| at(height) < 0.0);
    0.5 * (low + high)
}

/// Checks the residual motion of the bath.
fn check_at_rest<const D: usize>(case: &str, what: &str, sim: &Simulation<D>) -> Check {
    at_most(case, format!("u_rms / √(g lc), {what}"), rms_and_mean_speed(sim).0, bars(1e-2, 1e-3))
}

/// Case 6a: an upright wall.
fn wall(angle: f64) -> Result<Vec<Check>, StepError> {
    let dx = 0.125;
    let x = 4.3 * dx;
    let grid = Grid::<2>::new([((x + PLATE_TO_END_DISTANCE) / dx).ceil() as usize, 38], dx);
    let shape = Shape::HalfSpace { point: Vector::<2>::new(x, 0.0), normal: Vector::<2>::new(1.0, 0.0) };
    let mut sim = bath(tank(grid, shape, angle), 2.43);
    run_to(&mut sim, TIME, |_, _| ())?;
    let line = line_tracker(&sim).extract(&sim);
    let risen = match line.points[..] {
        [point] => point.at[1] - surface_height(&sim, grid.domain_upper()),
        _ => f64::NAN,
    };
    let sine = angle.to_radians().sin();
    let should = (SQRT_2 * (1.0 - sine).sqrt()).copysign(90.0 - angle);
    let what = format!("wall, θ = {angle}°");
    Ok(vec![
        Check::relative(PLANE_NAME, format!("height, {what}"), risen, should, bars(0.02, 0.01)).in_unit("lc"),
        check_at_rest(PLANE_NAME, &what, &sim),
    ])
}

/// Case 6b: a plate in the middle of a tank.
fn plate(angle: f64) -> Result<Vec<Check>, StepError> {
    const THICK: f64 = 1.0;
    let dx = 0.125;
    let grid = Grid::<2>::new([((2.0 * PLATE_TO_END_DISTANCE + THICK) / dx) as usize + 1, 46], dx);
    let (bottom, top) = (1.5 + 0.3 * dx, 10.0);
    let shape = block(
        Vector::<2>::new(0.5 * grid.domain_upper()[0] + 0.17 * dx, 0.5 * (bottom + top)),
        Vector::<2>::new(0.5 * THICK, 0.5 * (top - bottom)),
    );
    let mut sim = bath(tank(grid, shape, angle), bottom + 2.0);
    run_to(&mut sim, TIME, |_, _| ())?;
    let (start, mut force, mut side) = (sim.state.time, 0.0, 0.0);
    run_to(&mut sim, 1.1 * TIME, |sim, report| {
        let now = &sim.state.solids[0];
        force += (now.pressure_force + now.contact_line_force)[1] * report.dt;
        side += now.contact_line_force[1] * report.dt;
    })?;
    let time = sim.state.time - start;
    let deep =
        0.5 * (surface_height(&sim, grid.domain_upper()) + surface_height(&sim, Vector::zeros())) - bottom;
    let pull = 0.5 * (THICK * deep - force / time);
    let should = angle.to_radians().cos();
    let what = format!("plate, θ = {angle}°");
    let name = |text: &str| format!("{text}, {what}");
    let line = -0.5 * side / time;
    Ok(vec![
        Check::relative(PLANE_NAME, name("force less buoyancy"), pull, should, bars(0.02, 0.01)).in_unit("γ"),
        Check::relative(PLANE_NAME, name("pull of the contact line"), line, should, bars(0.02, 0.01))
            .in_unit("γ"),
        check_at_rest(PLANE_NAME, &what, &sim),
    ])
}

/// Case 6c: half a gap beside a plane of symmetry, its plate, and the bath beyond it.
fn gap(half: f64, angle: f64, should: f64) -> Result<Vec<Check>, StepError> {
    let (dx, thick) = (0.08, 1.0);
    let grid = Grid::<2>::new([((half + thick + PLATE_TO_END_DISTANCE) / dx).ceil() as usize, 66], dx);
    let (bottom, top) = (1.2 + 0.3 * dx, 10.0);
    let shape = block(
        Vector::<2>::new(half + 0.5 * thick, 0.5 * (bottom + top)),
        Vector::<2>::new(0.5 * thick, 0.5 * (top - bottom)),
    );
    let mut sim = bath(tank(grid, shape, angle), 2.73);
    run_to(&mut sim, 1.5 * TIME, |_, _| ())?;
    let risen = surface_height(&sim, Vector::zeros()) - surface_height(&sim, grid.domain_upper());
    let what = format!("gap, a = {half} lc, θ = {angle}°");
    Ok(vec![
        Check::relative(PLANE_NAME, format!("height, {what}"), risen, should, bars(0.02, 0.01)).in_unit("lc"),
        check_at_rest(PLANE_NAME, &what, &sim),
    ])
}

fn tubes(mode: Mode) -> Result<Vec<Check>, StepError> {
    let (cells, rows) = if mode == Mode::Quick { (6, &TUBES[1..2]) } else { (8, &TUBES[..]) };
    let checks: Vec<_> =
        rows.iter().map(|(angle, should)| tube(*angle, *should, cells)).collect::<Result<_, _>>()?;
    Ok(checks.into_iter().flatten().collect())
}

/// Case 6d: a quarter of a tube whose axis is the vertical edge of the domain.
fn tube(angle: f64, should: f64, cells: usize) -> Result<Vec<Check>, StepError> {
    let (radius, thick, side) = (0.5, 0.25, 1.5);
    let dx = radius / cells as f64;
    let round = |x: f64| (x / dx).ceil() as usize;
    // Depth and height of the tube below and above the level, with a margin of lc.
    let (below, above) = (1.0 + f64::max(-should, 0.0), 1.0 + f64::max(should, 0.0));
    let bottom = 0.6 + 0.3 * dx;
    let start = bottom + below;
    let grid = Grid::<3>::new([round(side), round(side), round(start + above)], dx);
    let axis = Vector::<3>::new(0.0, 0.0, 1.0);
    let long = |radius: f64| Shape::Cylinder {
        center: axis * (bottom + 5.0 * above),
        axis,
        radius,
        height: 10.0 * above,
    };
    let hole = Shape::Cylinder { center: axis * bottom, axis, radius, height: 40.0 * above };
    let shape = Shape::Difference { of: Box::new(long(radius + thick)), minus: Box::new(hole) };
    // The volume that the lines lift comes from the bath, so the initial level is higher.
    let lines = angle.to_radians().cos() * 0.5 * PI * (2.0 * radius + thick);
    let taken = lines / (side * side - 0.25 * PI * thick * (2.0 * radius + thick));
    // With ν = 1 the flow into the tube alone would delay the column by 60 √(lc/g).
    let mut model = tank(grid, shape, angle);
    model.kinematic_viscosity = 0.2;
    model.solids[0].line_friction = 0.3;
    let mut sim = bath(model, start + taken);
    run_to(&mut sim, TIME, |_, _| ())?;
    let (start, mut sum, mut squares) = (sim.state.time, 0.0, 0.0);
    run_to(&mut sim, TUBE_MEAN_END * TIME, |sim, report| {
        let risen = surface_height(sim, Vector::zeros()) - level_by_pressure(sim);
        sum += risen * report.dt;
        squares += risen * risen * report.dt;
    })?;
    let [risen, square] = [sum, squares].map(|sum| sum / (sim.state.time - start));
    let noise = (square - risen * risen).max(0.0).sqrt() / should.abs();
    let what = format!("tube, a = {radius} lc, θ = {angle}°, {cells} cells/a");
    // The bar of the variation is half that of the mean.
    Ok(vec![
        Check::relative(TUBE_NAME, format!("height, {what}"), risen, should, bars(0.04, 0.01)).in_unit("lc"),
        at_most(
            TUBE_NAME,
            format!("standard deviation of the height over it, {what}"),
            noise,
            bars(0.02, 0.005),
        ),
        check_at_rest(TUBE_NAME, &what, &sim),
    ])
}
