//! Contact-line friction: spreading of a drop limited by friction alone.

use super::sessile::{cap_radius, fit_cap, sessile_model};
use crate::measure::{at_most, bars, bisect, checks_or_failure};
use crate::setup::{across_and_up, at_rest, block, in_flight, run_to, wetted};
use crate::{Case, Check, Mode};
use meniscus_numerics::Vector;
use meniscus_numerics::grid::Grid;
use meniscus_numerics::shape::Shape;
use meniscus_sim::{Compiled, Model, Simulation, Solid, SolidKind, StepError};
use std::f64::consts::PI;

/// The case.
pub const CASE: Case = Case {
    name: "line-friction",
    title: "Drops held back by the friction of their contact line",
    theory: "Half a disc (radius 1, γ = ρ = 1, ν = 0.02, no gravity, 16 cells per radius) at 90 degrees spreads to Young's \
        60 on a wall 0.3 cells off the grid's faces, with the friction ζ = 3 √(ργR) of its contact lines. That is so slow, \
        and the liquid so thin, that the drop stays a segment of a circle, of half-width a and angle θ, and the molecular-kinetic law (Blake and \
        Haynes 1969, linear) ζ da/dt = γ (cos θ_Y − cos θ(a)) tells all; integrated by Runge–Kutta. The angle is that of \
        the circle through the surface more than 1.5 cells above the wall. And the momentum of such a drop and a free \
        plate under it, together, over γ L t, with L the drop's radius. Quick: the momentum \
        in 2D alone.",
    quick: true,
    run: |mode| checks_or_failure(NAME, run(mode)),
};

const NAME: &str = "line-friction";
const TIMES: [f64; 4] = [2.0, 4.0, 6.0, 8.0];
/// Viscosity of the liquid, √(γR/ρ).
const VISCOSITY: f64 = 0.02;
/// Friction coefficient over √(ργR).
const FRICTION: f64 = 3.0;
const YOUNG: f64 = 60.0;

fn run(mode: Mode) -> Result<Vec<Check>, StepError> {
    let mut checks = spreading(16)?;
    checks.push(momentum::<2>(48, 60)?);
    if mode == Mode::Full {
        checks.push(momentum::<3>(28, 20)?);
    }
    Ok(checks)
}

fn spreading(cells: usize) -> Result<Vec<Check>, StepError> {
    let dx = 1.0 / cells as f64;
    let grid = Grid::<2>::new([4 * cells, 2 * cells], dx);
    let point = Vector::<2>::new(2.0, (0.5 * cells as f64).floor() * dx + 0.3 * dx);
    let normal = Vector::<2>::new(0.0, 1.0);
    let mut wall = wetted(Shape::HalfSpace { point, normal }, YOUNG);
    wall.line_friction = FRICTION;
    let start = |x: &Vector<2>| (x - point).norm() - 1.0;
    let model = Model { kinematic_viscosity: VISCOSITY, ..sessile_model(grid, wall) };
    let mut sim = at_rest(model, &start);
    let mut checks = Vec::new();
    for time in TIMES {
        run_to(&mut sim, time, |_, _| ())?;
        let cap = fit_cap(&sim, |x| x[1] - point[1] > 1.5 * dx);
        let found = cap.angle_on_plane(&point, &normal);
        let what = format!("angle at t = {time}, {cells} cells/R");
        checks.push(Check::absolute(NAME, what, found, angle_at(time), bars(1.5, 0.7)).in_unit("deg"));
    }
    Ok(checks)
}

/// The angle (degrees) by the friction law.
fn angle_at(time: f64) -> f64 {
    const STEPS: usize = 1000;
    let h = time / STEPS as f64;
    let slope = |width: f64| (YOUNG.to_radians().cos() - angle_of(width).cos()) / FRICTION;
    let mut width = 1.0;
    for _ in 0..STEPS {
        let k1 = slope(width);
        let k2 = slope(width + 0.5 * h * k1);
        let k3 = slope(width + 0.5 * h * k2);
        let k4 = slope(width + h * k3);
        width += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    }
    angle_of(width).to_degrees()
}

/// The angle (rad) of a circular segment with the drop's area and a width of `2 width`.
fn angle_of(width: f64) -> f64 {
    let [low, high] = bisect([0.01, PI - 0.01], 60, |angle| cap_radius::<2>(angle) * angle.sin() > width);
    0.5 * (low + high)
}

/// The total momentum gained by a free plate and a moving drop beside its middle.
fn momentum<const D: usize>(cells: usize, steps: usize) -> Result<Check, StepError>
where
    Simulation<D>: Compiled<D>,
{
    const RADIUS: f64 = 0.16;
    let mut center = Vector::repeat(0.51);
    center[D - 1] = 0.4;
    let half_size = across_and_up(0.34, 0.06);
    let shape = block(center, half_size);
    let mut plate = Solid::new(shape, SolidKind::Rigid, 1.25);
    plate.young_cosine = 0.5;
    plate.line_friction = FRICTION * RADIUS.sqrt();
    let mut model = sessile_model(Grid::<D>::new([cells; D], 1.0 / cells as f64), plate);
    model.numerics.tolerance = 1e-10;
    let middle = center + across_and_up(0.08, 0.06);
    let above = |x: &Vector<D>| ((x - middle).norm() - RADIUS).max(center[D - 1] - x[D - 1]);
    let mut sim = in_flight(model, &above, Vector::from_fn(|a, _| 0.3 - 0.2 * a as f64));
    let sum = |sim: &Simulation<D>| {
        sim.diagnostics().momentum + sim.state.solids[0].velocity() * sim.model.solids[0].mass_properties.mass
    };
    let start = sum(&sim);
    for _ in 0..steps {
        sim.step(f64::INFINITY, &mut |_| ())?;
    }
    let gained = (sum(&sim) - start).norm() / (RADIUS.powi(D as i32 - 1) * sim.state.time);
    Ok(at_most(NAME, format!("momentum of drop and free plate, {D}D"), gained, bars(1e-6, 1e-10)))
}
