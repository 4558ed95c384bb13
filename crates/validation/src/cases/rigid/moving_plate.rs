//! Drops on plates that move through the grid.

use crate::cases::wetting::sessile::{cap_radius, fit_cap, sessile_model};
use crate::measure::{at_most, bars, checks_or_failure};
use crate::setup::{in_flight, run_to};
use crate::{Case, Check, Mode};
use meniscus_numerics::Vector;
use meniscus_numerics::grid::Grid;
use meniscus_numerics::shape::Shape;
use meniscus_sim::{PrescribedMotion, Solid, SolidKind, StepError};

/// The case.
pub const CASE: Case = Case {
    name: "moving-plate",
    title: "Drops on a plate that moves along and across itself",
    theory: "2D: half a disc (radius 1, γ = ρ = 1, ν = 0.5, no gravity) on a plate that goes with the drop \
        through the grid at 0.376 √(γ/ρR), along itself and across: in the plate's frame nothing differs from \
        a plate at rest. By how much the angle of the circle through the surface more than 1.5 cells above the \
        plate differs from that on the plate at rest, after 12 capillary times, and the largest such \
        difference over the last third. 16 cells per radius; quick: 8, across alone.",
    quick: true,
    run: |mode| checks_or_failure(NAME, run(mode)),
};

const NAME: &str = "moving-plate";
const SPEED: f64 = 0.376;
const TIME: f64 = 12.0;

fn run(mode: Mode) -> Result<Vec<Check>, StepError> {
    let (cells, angles): (_, &[f64]) =
        if mode == Mode::Quick { (8, &[60.0]) } else { (16, &[30.0, 60.0, 90.0, 120.0, 150.0]) };
    let directions = [("upwards", [0.0, 1.0]), ("downwards", [0.0, -1.0]), ("along itself", [1.0, 0.0])];
    let mut checks = Vec::new();
    for &angle in angles {
        let rest = angles_on(cells, angle, Vector::zeros())?;
        for (what, way) in &directions[..if mode == Mode::Quick { 1 } else { 3 }] {
            let moving = angles_on(cells, angle, Vector::<2>::from(*way) * SPEED)?;
            let change = moving.iter().zip(&rest).map(|(m, r)| m - r);
            let worst = change.fold(0.0f64, |w, c| if c.abs() > w.abs() { c } else { w });
            let text = format!("change of the angle, {what}, θ = {angle}°, {cells} cells/R");
            checks.push(at_most(NAME, text, worst, bars(2.0, 1.0)).in_unit("deg"));
        }
    }
    Ok(checks)
}

/// The contact angle of the drop, degrees, at nine times in the last third of the run.
fn angles_on(cells: usize, angle: f64, velocity: Vector<2>) -> Result<Vec<f64>, StepError> {
    let dx = 1.0 / cells as f64;
    let young = angle.to_radians();
    let radius = cap_radius::<2>(young);
    let base = radius * young.sin();
    // Room for the overshooting drop and for the motion.
    let displacement = velocity * TIME;
    let half = 1.3 * base.max(1.0) + 0.3;
    let height = 1.3 * (radius * (1.0 - young.cos())).max(1.0) + 0.3;
    let size = Vector::<2>::new(2.0 * half, height + 0.5) + displacement.abs();
    let grid = Grid::<2>::new([0, 1].map(|a| (size[a] * cells as f64).ceil() as usize), dx);
    let low = |a: usize| (-displacement[a]).max(0.0);
    let point = Vector::<2>::new(half + low(0) + 0.14 * dx, 0.5 + low(1) + 0.3 * dx);
    let normal = Vector::<2>::new(0.0, 1.0);
    let path = PrescribedMotion { velocity, angular_velocity: [0.0; 3], keyframes: Vec::new() };
    let kind = if velocity == Vector::<2>::zeros() { SolidKind::Fixed } else { SolidKind::Prescribed(path) };
    let mut plate = Solid::new(Shape::HalfSpace { point, normal }, kind, 1.0);
    plate.young_cosine = young.cos();
    let start = |x: &Vector<2>| (x - point).norm() - 1.0;
    let mut sim = in_flight(sessile_model(grid, plate), &start, velocity);
    let mut angles = Vec::new();
    for k in 0..=8 {
        run_to(&mut sim, TIME * (2.0 + f64::from(k) / 8.0) / 3.0, |_, _| ())?;
        let point = point + velocity * sim.state.time;
        let cap = fit_cap(&sim, |x| (x - point).dot(&normal) > 1.5 * dx);
        angles.push(cap.angle_on_plane(&point, &normal));
    }
    Ok(angles)
}
