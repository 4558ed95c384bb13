//! What a free surface must do where the lattice sees it worst.

#![allow(clippy::expect_used)]

use meniscus_numerics::Vector;
use meniscus_numerics::grid::Grid;
use meniscus_sim::{Compiled, LiquidRegion, Model, Numerics, Simulation, StepError, Wall};

fn model<const D: usize>(cells: usize) -> Model<D> {
    Model {
        grid: Grid::new([cells; D], 1.0 / cells as f64),
        walls: [[Wall::Slip; 2]; D],
        density: 1.0,
        kinematic_viscosity: 0.0,
        surface_tension: 0.001,
        gravity: Vector::zeros(),
        solids: Vec::new(),
        numerics: Numerics::default(),
    }
}

/// Two drops of radius 0.15 that fly at each other at ±1 along x, their surfaces 0.1 apart, met half-way at `x`: the
/// time when they are one.
fn meeting_time<const D: usize>(x: f64) -> f64
where
    Simulation<D>: Compiled<D>,
{
    let ball = |center: f64| {
        move |at: &Vector<D>| {
            let mut arm = at - Vector::repeat(0.5);
            arm[0] = at[0] - center;
            arm.norm() - 0.15
        }
    };
    let (left, right) = (ball(x - 0.2), ball(x + 0.2));
    let speed = |u: f64| Vector::from_fn(|a, _| if a == 0 { u } else { 0.0 });
    let bodies = [
        LiquidRegion { signed_distance: &left, velocity: speed(1.0) },
        LiquidRegion { signed_distance: &right, velocity: speed(-1.0) },
    ];
    let mut simulation = Simulation::new(model::<D>(40), &bodies);
    while simulation.state.components.len() > 1 && simulation.state.time < 0.2 {
        simulation.step(0.004, &mut |_| ()).expect("a step");
    }
    simulation.state.time
}

#[test]
fn drops_meet_in_time_wherever_the_lattice_is() {
    // They touch after 0.05. A gap under a cell, 0.0125 before, may close at once; a step of 0.004 later it must have.
    for shift in [0.0, 0.25, 0.5, 0.75] {
        for time in [meeting_time::<2>(0.5 + shift / 40.0), meeting_time::<3>(0.5 + shift / 40.0)] {
            assert!((0.033..0.0545).contains(&time), "shift {shift}: {time}");
        }
    }
}

#[test]
fn a_liquid_that_runs_away_is_an_error() {
    let ball = |at: &Vector<2>| (at - Vector::repeat(0.5)).norm() - 0.15;
    let bodies = [LiquidRegion { signed_distance: &ball, velocity: Vector::from([1e6, 0.0]) }];
    let mut simulation = Simulation::new(model::<2>(40), &bodies);
    let error = simulation.step(1.0, &mut |_| ()).expect_err("too fast");
    assert!(matches!(error, StepError::TooShort { .. }), "{error}");
    assert_eq!(simulation.state.step, 0);
}

#[test]
fn a_falling_drop_is_where_galilei_says() {
    // Leapfrog. Without the half step that its velocity is ahead the drop would be g t dt / 2 = 0.003 off; with forces that
    // act for the step's own length when the steps become shorter, as here, 0.0007.
    let ball = |at: &Vector<2>| (at - Vector::from([0.5, 0.75])).norm() - 0.15;
    let bodies = [LiquidRegion { signed_distance: &ball, velocity: Vector::zeros() }];
    let mut model = model::<2>(40);
    model.gravity[1] = -2.0;
    let mut simulation = Simulation::new(model, &bodies);
    for _ in 0..60 {
        simulation.step(0.01, &mut |_| ()).expect("a step");
    }
    let time = simulation.state.time;
    let [x, y]: [f64; 2] = simulation.state.components[0].centroid.into();
    assert!((y - (0.75 - time * time)).abs() < 1e-4 && (x - 0.5).abs() < 1e-6, "at {x}, {y} after {time}");
}

/// Drops of less than a cell that graze each other: their common angular momentum, kept in the faces of what became of them,
/// flung it apart at up to twenty times their speed (21, 4.8 and 4.6 in the first three). Without it none of these reaches 1.5.
#[test]
fn small_drops_that_graze_do_not_whirl() {
    for (radius, offset) in [(0.6, 1.2), (0.8, 0.9), (0.8, 1.2), (0.8, 1.6)] {
        let ball = |way: f64| {
            let center = Vector::from([0.5 + 0.1 * way, 0.5 + 0.5 * way * offset / 24.0, 0.52]);
            move |at: &Vector<3>| (at - center).norm() - radius / 24.0
        };
        let (left, right) = (ball(-1.0), ball(1.0));
        let speed = |u: f64| Vector::from([u, 0.0, 0.0]);
        let bodies = [
            LiquidRegion { signed_distance: &left, velocity: speed(1.0) },
            LiquidRegion { signed_distance: &right, velocity: speed(-1.0) },
        ];
        let mut simulation = Simulation::new(model::<3>(24), &bodies);
        while simulation.state.time < 0.3 {
            let report = simulation.step(0.3 - simulation.state.time, &mut |_| ()).expect("a step");
            assert!(
                report.diagnostics.max_speed < 2.0,
                "{radius}, {offset}: {}",
                report.diagnostics.max_speed
            );
        }
    }
}

/// A ball of four cells in radius whose centre is `shift` cells from where the lattice is symmetric: its kinetic energy over that of
/// its volume at 1 m/s.
fn energy_in_flight<const D: usize>(shift: f64) -> f64
where
    Simulation<D>: Compiled<D>,
{
    let center = Vector::<D>::repeat(0.5 + shift / 40.0);
    let ball = |x: &Vector<D>| (x - center).norm() - 0.1;
    let velocity = Vector::from_fn(|a, _| if a == 0 { 1.0 } else { 0.0 });
    let ledger =
        Simulation::new(model::<D>(40), &[LiquidRegion { signed_distance: &ball, velocity }]).diagnostics();
    ledger.kinetic_energy / (0.5 * ledger.volume)
}

#[test]
fn the_kinetic_energy_is_that_of_the_volume_wherever_the_lattice_is() {
    // The faces' own masses differ from the volume by per cents at this size.
    for shift in [0.0, 0.2, 0.4] {
        for energy in [energy_in_flight::<2>(shift), energy_in_flight::<3>(shift)] {
            assert!((energy - 1.0).abs() < 1e-12, "shift {shift}: {energy}");
        }
    }
}

#[test]
fn liquid_leaves_through_an_open_side_to_the_last_drop() {
    let open = Model { walls: [[Wall::Slip, Wall::Open]; 2], ..model::<2>(40) }.with_open_sides();
    let ball = |x: &Vector<2>| (x - Vector::from([0.8, 0.5])).norm() - 0.15;
    let bodies = [LiquidRegion { signed_distance: &ball, velocity: Vector::from([1.0, 0.0]) }];
    let mut simulation = Simulation::new(open, &bodies);
    let start = simulation.diagnostics().volume;
    while simulation.state.time < 0.5 {
        simulation.step(0.5 - simulation.state.time, &mut |_| ()).expect("a step");
    }
    assert_eq!(simulation.state.components.len(), 0);
    let (left, lost) = (simulation.state.outflow_volume, simulation.state.lost_volume);
    assert!((left / start - 1.0).abs() < 1e-9 && lost == 0.0, "{left} and {lost} of {start}");
}
