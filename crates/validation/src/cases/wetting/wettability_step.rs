//! A drop on a slope, pinned with its front at a step of the wettability.

use super::sessile::sessile_model;
use crate::measure::{bars, checks_or_failure};
use crate::setup::{at_rest, run_to, wetted};
use crate::{Case, Check, Mode};
use meniscus_numerics::Vector;
use meniscus_numerics::grid::Grid;
use meniscus_numerics::shape::Shape;
use meniscus_sim::{Model, Simulation, StepError, WettabilityLayer};
use std::f64::consts::PI;

/// The case.
pub const CASE: Case = Case {
    name: "wettability-step",
    title: "A drop held on a slope by a step of the wettability",
    theory: "2D: half a disc (radius 1, γ = ρ = 1, ν = 0.5, contact-line friction 1, ρ g A = 1.962 γ) on a \
        slope that it meets at 60° above a step and at 120° below, its front on the step (γ = 100 dyn/cm, A = \
        0.2 cm²). It is held as long as ρ g A sin α is less than γ (cos 60° − cos 120°): up to 30.643°. The \
        angle at which it lets go within 60 capillary times, by bisection to 0.3°; it has let go when its \
        middle is half a radius below the step. A slope across the grid under gravity along it, and a wall \
        along the grid 0.3 cells off its faces under gravity that is tilted. 16 cells per radius; quick: 8, \
        the slope alone, to 1.2°.",
    quick: true,
    run: |mode| checks_or_failure(NAME, run(mode)),
};

const NAME: &str = "wettability-step";
/// `ρ g A / γ`: γ = 100 dyn/cm, A = 0.2 cm².
const WEIGHT_RATIO: f64 = 1.962;
/// Duration of the runs, in which the drop may depin.
const TIME: f64 = 60.0;
/// Angles, degrees, between which the critical one is sought.
const ANGLE_RANGE: [f64; 2] = [21.0, 40.0];

fn run(mode: Mode) -> Result<Vec<Check>, StepError> {
    let exact = (1.0 / WEIGHT_RATIO).asin().to_degrees();
    let (cells, halvings) = if mode == Mode::Quick { (8, 3) } else { (16, 5) };
    let walls: &[(&str, bool)] = &[("slope", true), ("wall along the grid", false)];
    let mut checks = Vec::new();
    for (what, slanting) in &walls[..if mode == Mode::Quick { 1 } else { 2 }] {
        let mut range = ANGLE_RANGE;
        for _ in 0..halvings {
            let middle = 0.5 * (range[0] + range[1]);
            range[usize::from(depins(cells, middle, *slanting)?)] = middle;
        }
        let text = format!("critical angle, {what}, {cells} cells/R");
        let found = 0.5 * (range[0] + range[1]);
        checks.push(Check::absolute(NAME, text, found, exact, bars(3.0, 1.5)).in_unit("deg"));
    }
    Ok(checks)
}

/// Whether the drop depins at an angle (degrees), on a wall oblique to the grid or along it.
fn depins(cells: usize, angle: f64, slanting: bool) -> Result<bool, StepError> {
    let dx = 1.0 / cells as f64;
    let (s, c) = angle.to_radians().sin_cos();
    let (down, gravity) = (WEIGHT_RATIO / (0.5 * PI), Vector::<2>::new(s, -c));
    let [along, normal] =
        if slanting { [[c, -s], [s, c]] } else { [[1.0, 0.0], [0.0, 1.0]] }.map(Vector::<2>::from);
    let gravity = (if slanting { Vector::<2>::new(0.0, -1.0) } else { gravity }) * down;
    // Room for the drop and for the displacement that indicates depinning.
    let size = if slanting { Vector::<2>::new(5.5, 4.5) } else { Vector::<2>::new(5.5, 2.5) };
    let step = if slanting { Vector::<2>::new(3.2, 1.8) } else { Vector::<2>::new(3.2, 0.5 + 0.3 * dx) };
    let grid = Grid::<2>::new([0, 1].map(|a| (size[a] * cells as f64) as usize), dx);
    let mut wall = wetted(Shape::HalfSpace { point: step, normal }, 60.0);
    let below = Shape::HalfSpace { point: step, normal: -along };
    wall.pattern = vec![WettabilityLayer::Patch { shape: below, cosine: 120f64.to_radians().cos() }];
    wall.line_friction = 1.0;
    let start = |x: &Vector<2>| (x - (step - along)).norm() - 1.0;
    let mut sim = at_rest(Model { gravity, ..sessile_model(grid, wall) }, &start);
    let below = |sim: &Simulation<2>| (sim.diagnostics().centroid - step).dot(&along) > 0.5;
    for k in 1..=60 {
        run_to(&mut sim, TIME * f64::from(k) / 60.0, |_, _| ())?;
        if below(&sim) {
            return Ok(true);
        }
    }
    Ok(false)
}
