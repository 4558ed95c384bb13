//! Momentum of drops and of the free plate that they wet.

use crate::measure::{at_most, bars, checks_or_failure, volume_and_centroid_outside};
use crate::setup::{across_and_up, grid_offset, run_to, started, unit_model};
use crate::{Case, Check, Mode};
use meniscus_numerics::grid::Grid;
use meniscus_numerics::shape::Shape;
use meniscus_numerics::{Matrix, Vector, rotation_planes};
use meniscus_sim::{Compiled, LiquidRegion, Model, Simulation, Solid, SolidKind, StepError, Wall};

/// The case.
pub const CASE: Case = Case {
    name: "momentum-with-solid",
    title: "Momentum of drops and a free plate",
    theory: "Half a disc or ball (R = γ = ρ = 1, ν = 0.1, no gravity) on a free plate (5.2 R wide, 0.5 R thick, tilted, 1.25 \
        times as dense) spreads or contracts, pulls the plate, and turns it where it sits off its middle. Nothing acts \
        from outside: linear and angular momentum together stay zero (relative to γLt and γL²t, L = R; in 2D per metre of \
        depth), and so does the way of the common centre of mass, found from φ alone. Time 6 √(ρR³/γ). Full: 16 cells per \
        radius, one drop, one on each side, one whose line has friction (0.3 √(ργR)); 3D with 8. Quick: 8.",
    quick: true,
    run: |mode| checks_or_failure(NAME, run(mode)),
};

const NAME: &str = "momentum-with-solid";
const TIME: f64 = 6.0;
/// Half the plate's width and thickness.
const HALF_WIDTH: f64 = 2.6;
const HALF_THICKNESS: f64 = 0.25;
/// Density of the plate over the liquid's.
const DENSITY: f64 = 1.25;

/// A plate and its drops.
struct Pair {
    text: &'static str,
    angle: f64,
    /// Positions along the plate of the drops on its upper and on its lower side.
    drops: [&'static [f64]; 2],
    friction: f64,
}

const fn pair(text: &'static str, angle: f64, drops: [&'static [f64]; 2]) -> Pair {
    Pair { text, angle, drops, friction: 0.0 }
}

const CENTRED: [&[f64]; 2] = [&[0.0], &[]];
const OFF_CENTRE: [&[f64]; 2] = [&[0.7], &[]];
const PAIRS: [Pair; 7] = [
    pair("off-centre", 60.0, OFF_CENTRE),
    pair("off-centre", 120.0, OFF_CENTRE),
    pair("centred", 60.0, CENTRED),
    pair("centred", 120.0, CENTRED),
    pair("one on each side", 60.0, [&[-0.9], &[0.6]]),
    pair("two on one side", 120.0, [&[-1.3, 1.2], &[]]),
    Pair { text: "off-centre, friction", angle: 60.0, drops: OFF_CENTRE, friction: 0.3 },
];

fn run(mode: Mode) -> Result<Vec<Check>, StepError> {
    let mut checks = Vec::new();
    if mode == Mode::Quick {
        for pair in &PAIRS[..2] {
            checks.extend(isolated::<2>(pair, 8)?);
        }
        return Ok(checks);
    }
    for pair in &PAIRS {
        checks.extend(isolated::<2>(pair, 16)?);
    }
    checks.extend(isolated::<3>(&PAIRS[0], 8)?);
    Ok(checks)
}

fn isolated<const D: usize>(pair: &Pair, cells: usize) -> Result<Vec<Check>, StepError>
where
    Simulation<D>: Compiled<D>,
{
    let mut sim = start::<D>(pair, cells);
    let dx = sim.model.grid.dx;
    let first = center_of_mass(&sim);
    let (mut linear, mut angular, mut centroid_deviation): (f64, f64, f64) = (0.0, 0.0, 0.0);
    run_to(&mut sim, TIME, |sim, _| {
        let (p, l) = momentum(sim);
        (linear, angular) = (linear.max(p / TIME), angular.max(l / TIME));
        centroid_deviation = centroid_deviation.max((center_of_mass(sim) - first).norm() / dx);
    })?;
    let what = |text: &str| format!("{text}, {D}D, {}, θ = {}°, {cells} cells/R", pair.text, pair.angle);
    Ok(vec![
        at_most(NAME, what("momentum / γLt"), linear, bars(1e-6, 1e-12)),
        at_most(NAME, what("angular momentum / γL²t"), angular, bars(1e-4, 1e-12)),
        at_most(NAME, what("way of the centre of mass / Δ"), centroid_deviation, bars(0.1, 0.01)),
    ])
}

/// A drop beside the middle of a plate that is `density` times as dense.
pub(crate) fn plate_and_drop<const D: usize>(cells: usize, density: f64) -> Simulation<D>
where
    Simulation<D>: Compiled<D>,
{
    let mut sim = start(&PAIRS[0], cells);
    let body = &mut sim.model.solids[0].mass_properties;
    body.mass *= density / DENSITY;
    body.inertia *= density / DENSITY;
    sim
}

fn start<const D: usize>(pair: &Pair, cells: usize) -> Simulation<D>
where
    Simulation<D>: Compiled<D>,
{
    let dx = 1.0 / cells as f64;
    let size = |a: usize| if a + 1 == D { 6.6 } else { 7.0 };
    let grid = Grid::<D>::new(std::array::from_fn(|a| (size(a) * cells as f64) as usize), dx);
    let (s, c) = 0.2f64.sin_cos();
    // The plate's own axes: the first and the last lie in the plane of tilt.
    let mut rotation = Matrix::<D>::identity();
    (rotation[(0, 0)], rotation[(D - 1, D - 1)]) = (c, c);
    (rotation[(0, D - 1)], rotation[(D - 1, 0)]) = (-s, s);
    let center = grid.domain_upper() * 0.5 + grid_offset(dx);
    let half_size = across_and_up(HALF_WIDTH, HALF_THICKNESS);
    let shape = Shape::Box { center, half_size, rotation };
    let mut plate = Solid::new(shape, SolidKind::Rigid, DENSITY);
    plate.young_cosine = pair.angle.to_radians().cos();
    plate.line_friction = pair.friction;
    let model =
        Model { kinematic_viscosity: 0.1, solids: vec![plate], ..unit_model(grid, [[Wall::Open; 2]; D]) };
    let sides = [1.0, -1.0].into_iter().zip(pair.drops);
    let places: Vec<(f64, f64)> = sides.flat_map(|(side, at)| at.iter().map(move |x| (side, *x))).collect();
    let distances: Vec<_> = places
        .into_iter()
        .map(|(side, at)| {
            move |x: &Vector<D>| {
                let mut own = rotation.tr_mul(&(x - center));
                own[0] -= at;
                let above = side * own[D - 1];
                own[D - 1] = above - HALF_THICKNESS;
                (own.norm() - 1.0).max(-above)
            }
        })
        .collect();
    let bodies: Vec<LiquidRegion<'_, D>> = distances
        .iter()
        .map(|signed_distance| LiquidRegion { signed_distance, velocity: Vector::zeros() })
        .collect();
    started(model, &bodies)
}

/// Centre of mass of liquid and plate.
fn center_of_mass<const D: usize>(sim: &Simulation<D>) -> Vector<D> {
    let (volume, center) = volume_and_centroid_outside(sim);
    let (liquid, plate) = (sim.model.density * volume, sim.model.solids[0].mass_properties.mass);
    (center * liquid + sim.state.solids[0].center_of_mass() * plate) / (liquid + plate)
}

/// Magnitudes of the linear and angular momentum of liquid and plate.
fn momentum<const D: usize>(sim: &Simulation<D>) -> (f64, f64) {
    let (books, plate, now) = (sim.diagnostics(), &sim.model.solids[0], sim.state.solids[0].as_rigid());
    let own = now.velocity * plate.mass_properties.mass;
    let mut turning = Vector::<3>::from(books.angular_momentum) + plate.angular_momentum(&now);
    rotation_planes::<D>()
        .iter()
        .for_each(|&(a, b, place)| turning[place] += now.center[a] * own[b] - now.center[b] * own[a]);
    ((books.momentum + own).norm(), turning.norm())
}
