//! Collisions and resting contacts of rigid solids without liquid.

use crate::measure::{at_most, bar, bars, checks_or_failure};
use crate::setup::{across_and_up, run_to};
use crate::solids_only::{GRAVITY, gravity, point_at, rigid_box, simulation_without_liquid};
use crate::{Case, Check, Mode};
use meniscus_numerics::Vector;
use meniscus_numerics::grid::Grid;
use meniscus_numerics::shape::Shape;
use meniscus_sim::{Compiled, Simulation, Solid, SolidKind, StepError, overlaps};

/// The case.
pub const CASE: Case = Case {
    name: "rigid-contact",
    title: "Rigid solids bounce, hand blows on and stand in towers",
    theory: "No liquid, g = 10, cells of 1/24. A ball that falls on the floor comes back to e² of its height (restitution e of 0.3, 0.5, \
        0.8, 1), and touches the floor for no time: for less than one way of half a cell at the speed of the hit. Newton's \
        cradle: of five equal balls that touch, one (two) of speed 1 hits the others; as many leave on the other side with it, and the \
        rest stays (e = 1): momentum and energy allow no other of all those that hand on whole blows. A tower of ten \
        blocks of 0.4 x 0.08 stays where it is for two seconds: its drift over a block's height, and the speed left. Quick: 2D.",
    quick: false,
    run: |mode| checks_or_failure(NAME, run(mode)),
};

const NAME: &str = "rigid-contact";
const DX: f64 = 1.0 / 24.0;
const STEP: f64 = 2e-3;

fn run(mode: Mode) -> Result<Vec<Check>, StepError> {
    let mut checks = checks_in::<2>()?;
    if mode == Mode::Full {
        checks.extend(checks_in::<3>()?);
    }
    Ok(checks)
}

fn checks_in<const D: usize>() -> Result<Vec<Check>, StepError>
where
    Simulation<D>: Compiled<D>,
{
    let mut checks = Vec::new();
    for restitution in [0.3, 0.5, 0.8, 1.0] {
        checks.extend(bounce::<D>(restitution)?);
    }
    for moving in [1, 2] {
        checks.push(cradle::<D>(moving)?);
    }
    checks.extend(tower::<D>(10)?);
    Ok(checks)
}

fn ball<const D: usize>(center: Vector<D>, radius: f64, restitution: f64) -> Solid<D> {
    let mut ball = Solid::new(Shape::Ball { center, radius }, SolidKind::Rigid, 2.0);
    ball.restitution = restitution;
    ball
}

fn bounce<const D: usize>(restitution: f64) -> Result<Vec<Check>, StepError>
where
    Simulation<D>: Compiled<D>,
{
    let (radius, height) = (0.1, 0.5);
    let solid = ball::<D>(point_at(0.5, radius + height), radius, restitution);
    let mut simulation = simulation_without_liquid(Grid::new([24; D], DX), vec![solid], gravity(), STEP);
    let speed = (2.0 * GRAVITY * height).sqrt();
    let fall = speed / GRAVITY;
    let (mut low, mut high, mut touched) = (f64::INFINITY, 0f64, 0.0);
    let (mut lowest_at, mut before) = (0.0, None);
    // Contact with the floor starts at the activation distance, not at the lowest sampled position.
    let floor = 0.25 * DX;
    run_to(&mut simulation, fall * (1.0 + 2.0 * restitution), |s, report| {
        let now = s.state.solids[0].as_rigid();
        let (place, falls) = (now.center[D - 1] - radius, now.velocity[D - 1]);
        if place < low {
            (low, lowest_at) = (place, s.state.time);
        }
        if s.state.time > lowest_at {
            high = high.max(place);
        }
        // The change of velocity in a step beyond that of gravity.
        let change = before.map_or(0.0, |before: f64| falls - before);
        touched += if change > 0.01 * speed && s.state.time < 1.2 * fall { report.dt } else { 0.0 };
        before = Some(falls);
    })?;
    let what = |text: &str| format!("{text}, e = {restitution}, {D}D");
    let told = restitution * restitution;
    let max_contact_time = 0.5 * DX / speed;
    let back = (high - floor) / (height - floor);
    Ok(vec![
        Check::relative(NAME, what("height of the rebound"), back, told, bars(0.01, 1e-3)),
        at_most(NAME, what("time of contact / (half a cell / speed)"), touched / max_contact_time, bar(1.0)),
    ])
}

/// Largest difference of the speeds from those of the cradle.
fn cradle<const D: usize>(moving: usize) -> Result<Check, StepError>
where
    Simulation<D>: Compiled<D>,
{
    let radius = 0.05;
    let mut balls: Vec<Solid<D>> = (0..5)
        .map(|k| {
            let away = if k < moving { 0.15 } else { 0.0 };
            ball(point_at(0.3 + 2.0 * radius * k as f64 - away, 0.5), radius, 1.0)
        })
        .collect();
    balls[..moving].iter_mut().for_each(|b| b.initial_velocity[0] = 1.0);
    let mut simulation = simulation_without_liquid(Grid::new([24; D], DX), balls, Vector::zeros(), STEP);
    run_to(&mut simulation, 0.3, |_, _| ())?;
    let speed_errors = simulation.state.solids.iter().enumerate().map(|(k, now)| {
        let told = if k >= 5 - moving { 1.0 } else { 0.0 };
        (now.velocity()[0] - told).abs()
    });
    let text = format!("cradle, {moving} of 5 balls, {D}D: error of the speeds");
    Ok(at_most(NAME, text, speed_errors.fold(0.0, f64::max), bars(0.02, 1e-3)))
}

fn tower<const D: usize>(count: usize) -> Result<Vec<Check>, StepError>
where
    Simulation<D>: Compiled<D>,
{
    let half = across_and_up::<D>(0.2, 0.04);
    let gap = 0.05 * DX;
    let place = |k: usize| point_at::<D>(0.5, gap + half[D - 1] + k as f64 * (2.0 * half[D - 1] + gap));
    let solids = (0..count).map(|k| rigid_box(place(k), half, SolidKind::Rigid)).collect();
    let mut simulation = simulation_without_liquid::<D>(Grid::new([24; D], DX), solids, gravity(), STEP);
    let middle = |s: &Simulation<D>| s.state.solids.iter().map(|s| s.center_of_mass()).collect::<Vec<_>>();
    run_to(&mut simulation, 1.0, |_, _| ())?;
    let start = middle(&simulation);
    let (mut drift, mut fastest, mut deepest) = (0f64, 0f64, 0f64);
    run_to(&mut simulation, 3.0, |s, _| {
        for (now, then) in s.state.solids.iter().zip(&start) {
            drift = drift.max((now.center_of_mass() - then).norm());
            fastest = fastest.max(now.velocity().norm());
        }
        let depth = overlaps(s.solids()).iter().map(|o| o.2).fold(0.0, f64::max);
        deepest = deepest.max(depth);
    })?;
    let what = |text: &str| format!("{text}, {D}D");
    Ok(vec![
        at_most(
            NAME,
            what("tower of ten: drift in 2 s / height"),
            drift / (2.0 * half[D - 1]),
            bars(1e-3, 1e-6),
        ),
        at_most(NAME, what("tower of ten: speed / g h"), fastest / (GRAVITY * STEP), bars(0.05, 1e-6)),
        at_most(NAME, what("tower of ten: deepest overlap / cell"), deepest / DX, bar(0.0)),
    ])
}
