//! Momentum of an isolated system.

use crate::measure::{at_most, bar, bars, checks_or_failure, volume_and_centroid};
use crate::setup::{RADIUS, TENSION, grid_offset, model, run_to, with_bodies};
use crate::{Case, Check, Mode};
use meniscus_numerics::Vector;
use meniscus_numerics::grid::Grid;
use meniscus_numerics::shape::Shape;
use meniscus_sim::{Compiled, Diagnostics, Repairs, Simulation, StepError, Wall};
use std::f64::consts::{PI, TAU};

/// The case.
pub const CASE: Case = Case {
    name: "momentum",
    title: "Momentum of an isolated system",
    theory: "Two drops that collide off-centre and a spinning, oscillating drop in free space. Nothing acts from \
        outside: the linear and the angular momentum stay as they are (relative to γLt and γL²t, L = R; in 2D per \
        metre of depth, γt and γLt). So they do because what the discretisation loses is given back \
        in every step: the sum of that is measured before. The centre of mass moves uniformly; it is found from φ alone, apart from the \
        books, by points in every cell. Full: 12 cells per radius; quick: 8, 2D.",
    quick: true,
    run: |mode| checks_or_failure("momentum", run(mode)),
};

/// Angular velocity of the rotating drop.
const ANGULAR_VELOCITY: f64 = 5.0;
/// Bounds of the restored momenta: the sum of all steps over the effect of a force γL during the whole run.
const MAX_MOMENTUM_RESTORED: f64 = 1.0;
const MAX_ANGULAR_MOMENTUM_RESTORED: f64 = 1.0;
/// Relative amplitude of the mode.
const AMPLITUDE: f64 = 0.1;

fn run(mode: Mode) -> Result<Vec<Check>, StepError> {
    if mode == Mode::Quick {
        return isolated::<2>(8);
    }
    let mut checks = isolated::<2>(12)?;
    checks.extend(isolated::<3>(12)?);
    Ok(checks)
}

fn isolated<const D: usize>(cells: usize) -> Result<Vec<Check>, StepError>
where
    Simulation<D>: Compiled<D>,
{
    let (mut sim, time) = start::<D>(cells);
    let dx = sim.model.grid.dx;
    let before = sim.diagnostics();
    let mass = sim.model.density * before.target_volume;
    let center = |sim: &Simulation<D>| volume_and_centroid(&sim.model, &sim.state.phi).1;
    let first = center(&sim);
    let (mut linear, mut angular, mut centroid_deviation): (f64, f64, f64) = (0.0, 0.0, 0.0);
    let mut repairs = Repairs::default();
    let unit = TENSION * RADIUS.powi(D as i32 - 2) * time;
    run_to(&mut sim, time, |sim, report| {
        repairs.add(&report.repairs);
        let (p, l) = momentum_change(&before, &report.diagnostics);
        (linear, angular) = (linear.max(p / unit), angular.max(l / (unit * RADIUS)));
        let expected = first + before.momentum * (sim.state.time / mass);
        centroid_deviation = centroid_deviation.max((center(sim) - expected).norm() / dx);
    })?;
    let components = sim.state.components.len() as f64;
    let what = |text: &str| format!("{text}, {D}D");
    let case = "momentum";
    Ok(vec![
        at_most(case, what("drift of momentum / γLt"), linear, bars(1e-8, 1e-12)),
        at_most(case, what("drift of angular momentum / γL²t"), angular, bars(1e-8, 1e-12)),
        at_most(
            case,
            what("momentum restored / γLt"),
            repairs.momentum_restored / unit,
            bars(MAX_MOMENTUM_RESTORED, 1e-4),
        ),
        at_most(
            case,
            what("angular momentum restored / γL²t"),
            repairs.spin_restored / (unit * RADIUS),
            bars(MAX_ANGULAR_MOMENTUM_RESTORED, 1e-4),
        ),
        at_most(case, what("centre of mass off its straight path / Δ"), centroid_deviation, bars(0.1, 0.01)),
        Check::absolute(case, what("drops at the end (merged)"), components, 2.0, bar(0.0)),
    ])
}

/// Largest change of momentum and of angular momentum so far.
fn momentum_change<const D: usize>(before: &Diagnostics<D>, now: &Diagnostics<D>) -> (f64, f64) {
    let linear = (now.momentum - before.momentum).norm();
    let turn = |i: usize| (now.angular_momentum[i] - before.angular_momentum[i]).powi(2);
    (linear, (0..3).map(turn).sum::<f64>().sqrt())
}

/// The three drops, and the duration of the run.
fn start<const D: usize>(cells: usize) -> (Simulation<D>, f64)
where
    Simulation<D>: Compiled<D>,
{
    let dx = RADIUS / cells as f64;
    let size = [8.5, 9.5, 4.5];
    let count = std::array::from_fn(|a| (size[a] * cells as f64) as usize);
    let mut model = model(Grid::<D>::new(count, dx), [[Wall::Open; 2]; D]);
    model.numerics.tolerance = 1e-8;
    let place = |x: f64, y: f64| grid_offset::<D>(dx) + Vector::from_fn(|a, _| [x, y, 2.25][a] * RADIUS);
    let flow = |x: f64, y: f64| Vector::from_fn(|a, _| [x, y, 0.5][a]);
    let ball = |center: Vector<D>| Shape::Ball { center, radius: RADIUS };
    let top = place(4.2, 7.0);
    let spinning = Shape::PerturbedBall { center: top, radius: RADIUS, mode: 2, amplitude: AMPLITUDE };
    let bodies = [
        (ball(place(2.6, 2.2)), flow(6.0, 0.3)),
        (ball(place(5.4, 3.1)), flow(-5.0, 0.0)),
        (spinning, flow(0.7, -0.4)),
    ];
    let mut sim = with_bodies(model, &bodies);
    add_rotation(&mut sim, &top);
    let Simulation { model, state, .. } = sim;
    (Simulation::resume(model, state), 0.15)
}

/// Adds a rotation about the last axis to the drop around `center`, in the velocity and in its component's momenta.
fn add_rotation<const D: usize>(sim: &mut Simulation<D>, center: &Vector<D>) {
    let grid = sim.model.grid;
    for a in 0..2 {
        let faces = grid.face_lattice(a);
        for (i, u) in sim.state.velocity.axes[a].iter_mut().enumerate() {
            let d = grid.face_center(a, faces.coordinates(i)) - center;
            if d.norm() < RADIUS * (1.0 + AMPLITUDE) + grid.dx {
                *u += if a == 0 { -ANGULAR_VELOCITY * d[1] } else { ANGULAR_VELOCITY * d[0] };
            }
        }
    }
    let radius = |t: f64| {
        let direction = Vector::<D>::from_fn(|a, _| {
            if a == 0 {
                t.cos()
            } else if a == D - 1 {
                t.sin()
            } else {
                0.0
            }
        });
        RADIUS * (1.0 + AMPLITUDE * crate::measure::mode_shape(2, &direction))
    };
    let steps = 1000;
    let inertia: f64 = (0..steps)
        .map(|i| (f64::from(i) + 0.5) / f64::from(steps))
        .map(|s| match D {
            2 => TAU * radius(TAU * s).powi(4) / 4.0,
            // t is the angle from the equator.
            _ => PI * TAU * radius(PI * (s - 0.5)).powi(5) / 5.0 * (PI * (s - 0.5)).cos().powi(3),
        })
        .sum::<f64>()
        / f64::from(steps);
    for drop in &mut sim.state.components {
        if (drop.centroid - center).norm() < 0.5 * RADIUS {
            drop.angular_momentum_per_density[2] += ANGULAR_VELOCITY * inertia;
        }
    }
    sim.state.kinetic_energy += 0.5 * sim.model.density * ANGULAR_VELOCITY * ANGULAR_VELOCITY * inertia;
}
