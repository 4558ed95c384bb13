//! Drops on slopes, pinned by their contact lines.

use crate::measure::{at_least, at_most, bars, checks_or_failure};
use crate::setup::{across_and_up, at_rest, run_to, unit_model, up};
use crate::{Case, Check, Mode};
use meniscus_numerics::Vector;
use meniscus_numerics::grid::Grid;
use meniscus_numerics::shape::Shape;
use meniscus_sim::{Compiled, Hysteresis, Model, Simulation, Solid, SolidKind, StepError, Wall};
use std::f64::consts::PI;

/// A drop on a slope.
pub const CASE: Case = Case {
    name: "hysteresis",
    title: "Drops on slopes that hold their lines",
    theory: "Half a disc (radius 1, γ = ρ = 1, ν = 0.3, contact-line friction 0.3) on a wall with the advancing angle 110° \
        and the receding one 70°, pulled along it. In 2D it rests, whatever its shape, as long as ρ g A sin α is less than \
        γ (cos 70° − cos 110°) (C. G. L. Furmidge, J. Colloid Sci. 17 (1962) 309). Pulled with 0.9 of that its middle must \
        have come to rest after six capillary times, with 1.1 of it the drop must go on. In 3D (half a ball, 8 cells) a round \
        base a wide in radius holds ρ g V sin α = k γ 2a (cos 70° − cos 110°) with k = 24/π³ where its angle varies smoothly \
        around (A. I. ElSherbini, A. M. Jacobi, J. Colloid Interface Sci. 299 (2006) 841), and none holds more than k = 1: \
        0.7 of the first (load comes at once: it swings beyond) must leave it at rest, 1.1 of the second must not.",
    quick: true,
    run: |mode| checks_or_failure("hysteresis", slopes(if mode == Mode::Quick { 8 } else { 16 })),
};

/// Largest retention force of a round drop over γ times its width times the difference of the cosines.
const ROUND_DROP_FACTOR: f64 = 24.0 / (PI * PI * PI);

fn slopes(cells: usize) -> Result<Vec<Check>, StepError> {
    let (area, volume) = (0.5 * PI, 2.0 / 3.0 * PI);
    let plane = |share: f64| Pull { share, force: share / area };
    let mut checks = check_pulls::<2>(cells, plane(0.9), plane(1.1))?;
    let rest = Pull { share: 0.7, force: 0.7 * ROUND_DROP_FACTOR * 2.0 / volume };
    checks.extend(check_pulls::<3>(8, rest, Pull { share: 1.1, force: 1.1 * 2.0 / volume })?);
    Ok(checks)
}

/// A pull along the wall.
struct Pull {
    /// Its share of the critical one.
    share: f64,
    /// The force over γ (cos θ_r − cos θ_a).
    force: f64,
}

/// Checks a drop that must rest and one that must slide.
fn check_pulls<const D: usize>(cells: usize, rest: Pull, slide: Pull) -> Result<Vec<Check>, StepError>
where
    Simulation<D>: Compiled<D>,
{
    let what = |share: f64| format!("way / R at {share} of the critical pull, {D}D, {cells} cells/R");
    let stays = sliding_distance::<D>(cells, rest.force)?.abs();
    let goes = sliding_distance::<D>(cells, slide.force)?;
    Ok(vec![
        at_most("hysteresis", what(rest.share), stays, bars(0.02, 0.005)),
        at_least("hysteresis", what(slide.share), goes, 0.1, 0.2),
    ])
}

/// Displacement of the drop's centre from the sixth to the twelfth capillary time; `pull` is the force over γ (cos θ_r − cos θ_a).
fn sliding_distance<const D: usize>(cells: usize, pull: f64) -> Result<f64, StepError>
where
    Simulation<D>: Compiled<D>,
{
    let dx = 1.0 / cells as f64;
    let point = across_and_up::<D>(2.0, 6.3 * dx);
    let normal = up(1.0);
    let shape = Shape::HalfSpace { point, normal };
    let mut wall = Solid::new(shape, SolidKind::Fixed, 1.0);
    let [advancing, receding] = [110.0f64, 70.0].map(|angle| angle.to_radians().cos());
    (wall.hysteresis, wall.line_friction) = (Some(Hysteresis::Between([advancing, receding])), 0.3);
    let wide = [7, if D == 2 { 3 } else { 4 }, 3];
    let model = Model {
        kinematic_viscosity: 0.3,
        gravity: Vector::from_fn(|a, _| if a == 0 { pull * (receding - advancing) } else { 0.0 }),
        solids: vec![wall],
        ..unit_model(Grid::new(std::array::from_fn(|a| wide[a] * cells), dx), [[Wall::Slip; 2]; D])
    };
    let half = |x: &Vector<D>| (x - point).norm() - 1.0;
    let mut sim = at_rest(model, &half);
    run_to(&mut sim, 6.0, |_, _| ())?;
    let before = sim.diagnostics().centroid[0];
    run_to(&mut sim, 12.0, |_, _| ())?;
    Ok(sim.diagnostics().centroid[0] - before)
}
