//! The contact line as it is tracked: against exact caps, and against the line that moves the liquid.

#![allow(clippy::expect_used)]

use meniscus_numerics::Vector;
use meniscus_numerics::grid::Grid;
use meniscus_numerics::shape::Shape;
use meniscus_sim::{
    Compiled, ContactLine, Kinematics, LineTracker, LiquidRegion, Model, Numerics, RigidKinematics,
    Simulation, Solid, SolidKind, Wall,
};
use std::f64::consts::TAU;

fn up<const D: usize>() -> Vector<D> {
    Vector::from_fn(|a, _| if a + 1 == D { 1.0 } else { 0.0 })
}

/// A ball of liquid (radius 1, centre given) on a solid, `cells` per radius.
fn drop_on<const D: usize>(cells: usize, center: Vector<D>, shape: Shape<D>, angle: f64) -> Simulation<D>
where
    Simulation<D>: Compiled<D>,
{
    let dx = 1.0 / cells as f64;
    let mut solid = Solid::new(shape, SolidKind::Fixed, 1.0);
    solid.young_cosine = angle.to_radians().cos();
    let model = Model {
        grid: Grid::new([3 * cells; D], dx),
        walls: [[Wall::Slip; 2]; D],
        density: 1.0,
        kinematic_viscosity: 0.5,
        surface_tension: 1.0,
        gravity: Vector::zeros(),
        solids: vec![solid],
        numerics: Numerics::default(),
    };
    let distance = |x: &Vector<D>| (x - center).norm() - 1.0;
    Simulation::new(model, &[LiquidRegion { signed_distance: &distance, velocity: Vector::zeros() }])
}

fn find<const D: usize>(simulation: &Simulation<D>) -> ContactLine<D> {
    LineTracker::new(&simulation.model, &[simulation.model.grid.dx / 1.5]).extract(simulation)
}

/// Largest errors on an exact cap on a plane (tilted in 2D): angle, degrees; place of the line, cells; length over that of
/// the circle less one; and how far the lattice's line is from it, cells.
fn cap_errors<const D: usize>(cells: usize, angle: f64, offset: f64) -> [f64; 4]
where
    Simulation<D>: Compiled<D>,
{
    let dx = 1.0 / cells as f64;
    let tilt = if D == 2 { 0.2 } else { 0.0 };
    let normal = (up::<D>() + Vector::from_fn(|a, _| if a == 0 { tilt } else { 0.0 })).normalize();
    let height = 1.0 + offset * dx;
    let point = Vector::from_fn(|a, _| if a + 1 == D { height } else { 1.5 + 0.13 * dx });
    let center = point - normal * angle.to_radians().cos();
    let simulation = drop_on(cells, center, Shape::HalfSpace { point, normal }, angle);
    let line = find(&simulation);
    let base = angle.to_radians().sin();
    let off = |x: &Vector<D>| ((x - point).norm() - base).abs() / dx;
    let place = line.points.iter().map(|p| off(&p.at)).fold(0.0, f64::max);
    let wrong = line.points.iter().map(|p| (p.angle_degrees - angle).abs()).fold(0.0, f64::max);
    let length = line.length().map_or(0.0, |l| l / (TAU * base) - 1.0);
    assert_eq!(line.points.len() * usize::from(D == 2), if D == 2 { 2 } else { 0 });
    [wrong, place, length, line.line_distance_cells.expect("a line")]
}

fn caps<const D: usize>(cells: usize, bars: [f64; 4])
where
    Simulation<D>: Compiled<D>,
{
    for angle in [20.0, 30.0, 60.0, 90.0, 120.0, 150.0, 160.0] {
        let all: Vec<[f64; 4]> = [0.0, 0.2, 0.5, 0.8].map(|o| cap_errors::<D>(cells, angle, o)).to_vec();
        let worst: [f64; 4] = std::array::from_fn(|k| all.iter().fold(0.0f64, |m, e| m.max(e[k].abs())));
        println!(
            "{D}D, {cells} cells, {angle}°: angle {:.3}°, place {:.4}, length {:.5}, apart {:.3}",
            worst[0], worst[1], worst[2], worst[3]
        );
        if (30.0..=150.0).contains(&angle) {
            (0..4).for_each(|k| assert!(worst[k] < bars[k], "{D}D, {angle}: {worst:?}"));
        }
    }
}

/// Errors of the angle and of the distance along the surface on an exact cap on a ball that has turned since the start.
fn on_a_ball<const D: usize>(cells: usize, angle: f64)
where
    Simulation<D>: Compiled<D>,
{
    let (dx, radius) = (1.0 / cells as f64, 0.8);
    let center = Vector::from_fn(|a, _| if a + 1 == D { 0.9 } else { 1.5 + 0.13 * dx });
    let gap = (1.0 + radius * radius - 2.0 * radius * angle.to_radians().cos()).sqrt();
    let mut simulation = drop_on(cells, center + up::<D>() * gap, Shape::Ball { center, radius }, angle);
    let (s, c) = 0.7f64.sin_cos();
    if let Kinematics::Rigid(RigidKinematics { rotation: turned, .. }) =
        &mut simulation.state.solids[0].kinematics
    {
        (turned[(0, 0)], turned[(0, D - 1)], turned[(D - 1, 0)], turned[(D - 1, D - 1)]) = (c, -s, s, c);
    }
    let tracker = LineTracker::new(&simulation.model, &[dx / 1.5]);
    let line = tracker.extract(&simulation);
    let wrong = line.points.iter().map(|p| (p.angle_degrees - angle).abs()).fold(0.0, f64::max);
    // Colatitude of the line on the solid.
    let cosine = (gap * gap + radius * radius - 1.0) / (2.0 * gap * radius);
    let exact =
        |x: &Vector<D>| radius * (((x - center)[D - 1] / radius).clamp(-1.0, 1.0).acos() - cosine.acos());
    let surface = tracker.surface(simulation.solids(), 0);
    let vertices = surface.positions.iter().zip(&line.phi_c[0]);
    let errors: Vec<f64> = vertices
        .filter(|(x, _)| exact(x).abs() < 4.5 * dx)
        .map(|(x, found)| (found - exact(x)).abs() / dx)
        .collect();
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    let far = line.line_distance_cells.expect("a line");
    println!("{D}D ball, {cells} cells, {angle}°: angle {wrong:.3}°, φ_c {mean:.4}, apart {far:.3}");
    assert!(wrong < 0.3 && mean < 0.05 && far < 0.3);
    assert!(line.phi_c[0].iter().all(|d| d.abs() <= 5.0 * dx));
}

#[test]
fn an_exact_cap_on_a_turned_ball() {
    for angle in [40.0, 90.0, 130.0] {
        on_a_ball::<2>(12, angle);
        on_a_ball::<3>(12, angle);
    }
}

#[test]
fn a_line_that_is_carried_along_has_the_speed_of_the_liquid() {
    let point = Vector::<2>::new(1.5, 1.02);
    let simulation = drop_on(12, point, Shape::HalfSpace { point, normal: up() }, 90.0);
    let Simulation { model, mut state, .. } = simulation;
    state.velocity.axes[0].iter_mut().for_each(|u| *u = 0.3);
    let line = find(&Simulation::resume(model, state));
    let speeds: Vec<f64> = line.points.iter().map(|p| p.speed * (p.at[0] - 1.5).signum()).collect();
    assert!(speeds.iter().all(|v| (v - 0.3).abs() < 1e-6), "{speeds:?}");
    // 90 degrees: the surface pulls straight up.
    assert!(line.points.iter().all(|p| (p.force - up()).norm() < 1e-3));
    assert_eq!(line.length(), None);
}

#[test]
fn an_exact_cap_is_measured_wherever_the_lattice_is() {
    caps::<2>(8, [0.1, 0.1, 1.0, 0.1]);
    caps::<2>(16, [0.01, 0.05, 1.0, 0.05]);
    caps::<3>(12, [0.01, 0.1, 0.01, 0.15]);
}

/// A drop on a plane or a ball, viscous enough to be at rest in the end.
fn rests<const D: usize>(cells: usize, angle: f64, curved: bool)
where
    Simulation<D>: Compiled<D>,
{
    let dx = 1.0 / cells as f64;
    let point = Vector::from_fn(|a, _| if a + 1 == D { 1.0 + 0.3 * dx } else { 1.5 + 0.13 * dx });
    let shape = match curved {
        true => Shape::Ball { center: point - up::<D>() * 0.9, radius: 0.9 },
        false => Shape::HalfSpace { point, normal: up() },
    };
    let mut simulation = drop_on(cells, point, shape, angle);
    simulation.model.kinematic_viscosity = 1.5;
    let tracker = LineTracker::new(&simulation.model, &[dx / 1.5]);
    let mut apart = 0.0f64;
    while simulation.state.time < 12.0 {
        simulation.step(12.0 - simulation.state.time, &mut |_| ()).expect("a step");
        if simulation.state.step % 5 == 0 {
            apart = apart.max(tracker.extract(&simulation).line_distance_cells.expect("a line"));
        }
    }
    let line = tracker.extract(&simulation);
    let (mean, spread) = line.angle_statistics(Some(0)).expect("an angle");
    let fastest = line.points.iter().map(|p| p.speed.abs()).fold(0.0, f64::max);
    let pull: Vector<D> = line.points.iter().map(|p| p.force * p.length).sum();
    println!(
        "{D}D, {angle}°, curved {curved}: {mean:.2}° ± {spread:.2}, apart {apart:.3} (at the end {:.3}), speed {fastest:.4}, pull {:.4} for {:.4}",
        line.line_distance_cells.expect("a line"),
        pull[D - 1],
        simulation.state.solids[0].contact_line_force[D - 1]
    );
    assert!(apart < 1.0 && (mean - angle).abs() < 2.0);
}

#[test]
fn a_line_that_is_switched_off_pulls_at_nothing() {
    let point = Vector::<2>::new(1.5, 1.03);
    let mut simulation = drop_on(10, point, Shape::HalfSpace { point, normal: up() }, 90.0);
    let pull = |simulation: &mut Simulation<2>| {
        simulation.step(0.01, &mut |_| ()).expect("a step");
        simulation.state.solids[0].contact_line_force.norm()
    };
    // Two points of a line at 90 degrees pull with 2 γ.
    assert!((pull(&mut simulation) - 2.0).abs() < 0.1);
    simulation.model.numerics.contact_line = false;
    assert_eq!(pull(&mut simulation), 0.0);
}

#[test]
fn the_line_of_a_drop_is_where_the_energy_has_it() {
    for angle in [60.0, 120.0] {
        rests::<2>(10, angle, false);
        rests::<2>(16, angle, true);
    }
    rests::<3>(8, 60.0, false);
    rests::<3>(8, 90.0, true);
}
