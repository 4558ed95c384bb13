//! Drops that bounce off a non-wetting wall.

use crate::cases::wetting::sessile::sessile_model;
use crate::measure::{bars, checks_or_failure, surface_points};
use crate::setup::{StepBounds, in_flight, run_to};
use crate::{Case, Check};
use meniscus_numerics::Vector;
use meniscus_numerics::grid::Grid;
use meniscus_numerics::shape::Shape;
use meniscus_sim::{Solid, SolidKind, StepError};

/// Bouncing water drops.
pub const CASE: Case = Case {
    name: "bounce",
    title: "Drops that bounce off a wall, 3D",
    theory: "A drop (radius 1, γ = ρ = 1, viscosity of a drop of water of 1 mm, no gravity, 16 cells per \
        radius) hits a wall that it does not wet (180 degrees). It touches the wall for 2.6 √(ρR³/γ), however \
        fast it is (D. Richard, C. Clanet, D. Quéré, 'Contact time of a bouncing drop', 2002), and spreads to \
        D/D0 = We^¼, We = ρU²D0/γ (C. Clanet et al., 'Maximal deformation of an impacting drop', 2004); We of \
        water of 1 mm at 20, 50 and 100 cm/s.",
    quick: false,
    run: |_| checks_or_failure("bounce", bounces()),
};

/// Contact time of a drop with the wall, √(ρR³/γ).
const CONTACT_TIME: f64 = 2.6;

fn bounces() -> Result<Vec<Check>, StepError> {
    let mut checks = Vec::new();
    for (weber, spreads) in [(1.099, false), (6.868, true), (27.47, true)] {
        let bounce = bounce(16, weber, StepBounds::default())?;
        let what = |text: &str| format!("{text}, We = {weber}");
        let touched = bounce.contact_time;
        checks.push(Check::relative("bounce", what("contact time"), touched, CONTACT_TIME, bars(0.15, 0.08)));
        if spreads {
            let width = weber.sqrt().sqrt();
            checks.push(Check::relative("bounce", what("D/D0"), bounce.max_spread, width, bars(0.15, 0.08)));
        }
    }
    Ok(checks)
}

/// Result of a bounce.
pub(crate) struct Bounce {
    /// Contact time with the wall, √(ρR³/γ).
    pub(crate) contact_time: f64,
    /// Largest diameter, over the drop's.
    pub(crate) max_spread: f64,
}

pub(crate) fn bounce(cells: usize, weber: f64, bounds: StepBounds) -> Result<Bounce, StepError> {
    let dx = 1.0 / cells as f64;
    let half = (1.3 * weber.sqrt().sqrt()).max(1.7);
    let size = |length: f64| (length * cells as f64).ceil() as usize;
    let grid = Grid::<3>::new([size(2.0 * half), size(2.0 * half), size(4.5)], dx);
    let mut point = grid.domain_upper() * 0.5 + Vector::<3>::new(0.141 * dx, 0.273 * dx, 0.0);
    point[2] = 0.3 + 0.3 * dx;
    let mut wall = Solid::new(Shape::HalfSpace { point, normal: Vector::<3>::z() }, SolidKind::Fixed, 1.0);
    wall.young_cosine = -1.0;
    let mut model = sessile_model(grid, wall);
    model.kinematic_viscosity = 0.0037;
    model.numerics = bounds.into();
    let center = point + Vector::<3>::z() * 1.2;
    let ball = |x: &Vector<3>| (x - center).norm() - 1.0;
    let velocity = Vector::<3>::z() * -(0.5 * weber).sqrt();
    let mut sim = in_flight(model, &ball, velocity);
    let mut span = None;
    let mut max_spread = 0.0f64;
    let end = 0.2 / velocity.norm() + 1.6 * CONTACT_TIME;
    run_to(&mut sim, end, |sim, _| {
        if sim.wetted_fraction(0) > 0.0 {
            let (first, _) = span.unwrap_or((sim.state.time, 0.0));
            span = Some((first, sim.state.time));
        }
        let reach = |p: &Vector<3>| (p - center).xy().norm();
        let points = surface_points(&sim.model, &sim.state.phi);
        max_spread = points.iter().map(|p| reach(&p.at)).fold(max_spread, f64::max);
    })?;
    Ok(Bounce { contact_time: span.map_or(0.0, |(first, last)| last - first), max_spread })
}
