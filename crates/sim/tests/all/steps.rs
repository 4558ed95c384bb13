//! Steps that are undone, resumed or shortened.

#![allow(clippy::expect_used)]

use meniscus_numerics::Vector;
use meniscus_numerics::grid::Grid;
use meniscus_numerics::shape::Shape;
use meniscus_sim::{LiquidRegion, Model, Numerics, Scheme, Simulation, Solid, SolidKind, Wall};

/// A liquid of density and tension 1 without viscosity and gravity, between closed sides.
fn model(cells: usize, dx: f64, solids: Vec<Solid<2>>) -> Model<2> {
    Model {
        grid: Grid::new([cells; 2], dx),
        walls: [[Wall::Slip; 2]; 2],
        density: 1.0,
        kinematic_viscosity: 0.0,
        surface_tension: 1.0,
        gravity: Vector::zeros(),
        solids,
        numerics: Numerics::default(),
    }
}

fn pool(model: Model<2>, height: f64) -> Simulation<2> {
    let distance = |x: &Vector<2>| x[1] - height;
    Simulation::new(model, &[LiquidRegion { signed_distance: &distance, velocity: Vector::zeros() }])
}

/// A constant step that fails is halved, and contacts are then looked ahead for the halved length.
#[test]
fn a_constant_step_stays_within_the_look_ahead() {
    let mut model = model(16, 1.0, Vec::new());
    model.numerics.fixed_step = Some(0.1);
    let mut simulation = pool(model, 8.3);
    let mut length = || simulation.step(f64::INFINITY, &mut |_| {}).expect("a step").dt;
    assert_eq!(length(), 0.1);
    (simulation.state.last_dt, simulation.state.collision_free_dt) = (0.05, 0.0625);
    assert_eq!(simulation.step(f64::INFINITY, &mut |_| {}).expect("a step").dt, 0.0625);
}

/// A drop that falls on a ball, fixed or free, with the scheme of the paper.
fn drop_on_ball(kind: SolidKind<2>) -> Simulation<2> {
    let shape = Shape::Ball { center: Vector::from([0.49, 0.3]), radius: 0.15 };
    let mut ball = Solid::new(shape, kind, 1.5);
    ball.young_cosine = -0.3;
    let mut model = model(24, 1.0 / 24.0, vec![ball]);
    (model.numerics.scheme, model.kinematic_viscosity) = (Scheme::Paper, 0.02);
    model.gravity = Vector::from([0.0, -1.0]);
    let drop = |x: &Vector<2>| (x - Vector::from([0.5, 0.57])).norm() - 0.18;
    let region = LiquidRegion { signed_distance: &drop, velocity: Vector::from([0.0, -0.5]) };
    Simulation::new(model, &[region])
}

#[test]
fn the_scheme_of_the_paper_resumes_with_the_same_bits_and_undoes_a_step() {
    let steps = |simulation: &mut Simulation<2>| {
        for _ in 0..10 {
            let report = simulation.step(0.1, &mut |_| {}).expect("a step");
            // Explicit surface tension and viscosity bound the step.
            let viscous = simulation.model.grid.dx.powi(2) / (4.0 * simulation.model.kinematic_viscosity);
            assert!(report.dt <= simulation.model.capillary_dt_limit().min(viscous));
            assert_eq!(report.repairs.redone, 0);
        }
    };
    for kind in [SolidKind::Fixed, SolidKind::Rigid] {
        let mut whole = drop_on_ball(kind);
        let start = whole.diagnostics();
        steps(&mut whole);
        let mut resumed = Simulation::resume(whole.model.clone(), whole.state.clone());
        assert!(resumed.state == whole.state);
        resumed.step_and_undo(0.1).expect("a step");
        assert!(resumed.state == whole.state);
        steps(&mut whole);
        steps(&mut resumed);
        assert!(resumed.state == whole.state);
        let end = whole.diagnostics();
        assert!((end.target_volume / start.target_volume - 1.0).abs() < 1e-12);
        assert!(end.volume_error.abs() < 0.01 && end.max_speed < 3.0);
        let pressed = whole.state.pressure_impulse.data.iter().any(|p| *p > 0.0);
        assert!(pressed && whole.state.velocity_lead == 0.0 && whole.state.step == 20);
    }
}

/// Gravity that is set before the first step is that of the model, bit for bit: everything that depends on it follows, such as the weight in
/// the energy of the surface beside solids.
#[test]
fn gravity_that_is_set_acts_as_that_of_the_model() {
    let gravity = Vector::from([0.4, -2.0]);
    let start = |gravity: Vector<2>| {
        let floor = Shape::HalfSpace { point: Vector::from([0.0, 0.211]), normal: Vector::from([0.0, 1.0]) };
        let mut model = model(24, 1.0 / 24.0, vec![Solid::new(floor, SolidKind::Fixed, 1.0)]);
        model.gravity = gravity;
        let drop = |x: &Vector<2>| (x - Vector::from([0.5, 0.3])).norm() - 0.2;
        Simulation::new(model, &[LiquidRegion { signed_distance: &drop, velocity: Vector::zeros() }])
    };
    let (mut of_model, mut set) = (start(gravity), start(Vector::zeros()));
    set.set_gravity(gravity);
    for _ in 0..5 {
        for simulation in [&mut of_model, &mut set] {
            simulation.step(0.1, &mut |_| {}).expect("a step");
        }
    }
    assert!(of_model.state == set.state);
}
