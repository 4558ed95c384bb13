//! Drops on slopes without hysteresis and friction, which slide freely.

use super::sessile::sessile_model;
use crate::measure::{bars, checks_or_failure};
use crate::setup::{at_rest, run_to, wetted};
use crate::{Case, Check, Mode};
use meniscus_numerics::Vector;
use meniscus_numerics::grid::Grid;
use meniscus_numerics::shape::Shape;
use meniscus_sim::{Model, StepError};

/// The case.
pub const CASE: Case = Case {
    name: "sliding",
    title: "Drops slide on every slope that does not hold their lines",
    theory: "2D: half a disc (radius 1, γ = ρ = 1, ν = 0.5, g = 1.25) on a frictionless slope that it meets at \
        the same angle everywhere. Its lines pull it nowhere along the slope, so that it slides as if it fell: \
        ½ g sin α t² (book/theory/contact-line.md). Its way along the slope over that, after 12 capillary \
        times or 2.5 radii: what cells or a wrong pull of the lines hold it with shows most on the flattest. \
        16 cells per radius; quick: 8, two slopes.",
    quick: true,
    run: |mode| checks_or_failure(NAME, run(mode)),
};

const NAME: &str = "sliding";
const GRAVITY: f64 = 1.25;

fn run(mode: Mode) -> Result<Vec<Check>, StepError> {
    let (cells, tilts, angles): (_, &[f64], &[f64]) = match mode {
        Mode::Quick => (8, &[1.0, 20.0], &[60.0]),
        Mode::Full => (16, &[0.5, 2.0, 10.0, 30.0, 60.0], &[60.0, 90.0, 120.0]),
    };
    let mut checks = Vec::new();
    for &angle in angles {
        for &tilt in tilts {
            let text = format!("way over ½ g sin α t², α = {tilt}°, θ = {angle}°, {cells} cells/R");
            checks.push(Check::relative(
                NAME,
                text,
                sliding_ratio(cells, tilt, angle)?,
                1.0,
                bars(0.05, 0.01),
            ));
        }
    }
    Ok(checks)
}

/// The drop's displacement along the slope over that of free fall.
fn sliding_ratio(cells: usize, tilt: f64, angle: f64) -> Result<f64, StepError> {
    let dx = 1.0 / cells as f64;
    let (s, c) = tilt.to_radians().sin_cos();
    let (along, normal) = (Vector::<2>::new(c, -s), Vector::<2>::new(s, c));
    // Half the displacement to either side of the middle, with room for the spreading and the wall's slope.
    let size = Vector::<2>::new(4.2 + 2.5 * c, 2.6 + 4.2 * s);
    let grid = Grid::<2>::new([0, 1].map(|a| (size[a] * cells as f64).ceil() as usize), dx);
    let middle = Vector::<2>::new(0.5 * size[0], 0.45 * size[1] - 0.75 * c + 0.27 * dx);
    let wall = wetted(Shape::HalfSpace { point: middle, normal }, angle);
    let pull = GRAVITY * s;
    let time = 12f64.min((2.0 * 2.5 / pull).sqrt());
    let way = 0.5 * pull * time * time;
    let start = |x: &Vector<2>| (x - (middle - along * (0.5 * way))).norm() - 1.0;
    let gravity = Vector::<2>::new(0.0, -GRAVITY);
    let mut sim = at_rest(Model { gravity, ..sessile_model(grid, wall) }, &start);
    let before = sim.diagnostics().centroid;
    run_to(&mut sim, time, |_, _| ())?;
    Ok((sim.diagnostics().centroid - before).dot(&along) / way)
}
