//! What rigid solids do to each other and to the sides of the domain, without liquid and in it.

#![allow(clippy::expect_used)]

use meniscus_numerics::grid::Grid;
use meniscus_numerics::shape::Shape;
use meniscus_numerics::{Matrix, Vector};
use meniscus_sim::{
    Compiled, LiquidRegion, Model, Numerics, PrescribedMotion, Simulation, Solid, SolidKind, SolidState, Wall,
};

const GRAVITY: f64 = 10.0;
const CELLS: usize = 24;
pub const DX: f64 = 1.0 / CELLS as f64;
/// The barrier's reach: impacts happen there, and what rests is nearer.
const REACH: f64 = 0.25 * DX;
/// A step longer than any that is taken.
pub const LONG: f64 = 0.5;

pub fn dry<const D: usize>(solids: Vec<Solid<D>>, gravity: Vector<D>, max_step: f64) -> Simulation<D>
where
    Simulation<D>: Compiled<D>,
{
    let mut model = model([CELLS; D], solids, gravity);
    model.numerics.max_step = max_step;
    Simulation::new(model, &[])
}

/// A box with a side of 1 m along the first axis, and a liquid without viscosity and tension.
fn model<const D: usize>(cells: [usize; D], solids: Vec<Solid<D>>, gravity: Vector<D>) -> Model<D> {
    Model {
        grid: Grid::new(cells, 1.0 / cells[0] as f64),
        walls: [[Wall::Slip; 2]; D],
        density: 1.0,
        kinematic_viscosity: 0.0,
        surface_tension: 0.0,
        gravity,
        solids,
        numerics: Numerics::default(),
    }
}

fn down<const D: usize>() -> Vector<D> {
    Vector::from_fn(|a, _| if a + 1 == D { -GRAVITY } else { 0.0 })
}

fn run<const D: usize>(simulation: &mut Simulation<D>, time: f64, mut each: impl FnMut(&Simulation<D>)) {
    while simulation.state.time < time * (1.0 - 1e-12) {
        simulation.step(time - simulation.state.time, &mut |_| ()).expect("a step");
        each(simulation);
    }
}

fn ball<const D: usize>(center: Vector<D>, radius: f64, velocity: Vector<D>) -> Solid<D> {
    let mut ball = Solid::new(Shape::Ball { center, radius }, SolidKind::Rigid, 2.0);
    ball.initial_velocity = velocity;
    ball
}

pub fn block<const D: usize>(center: Vector<D>, half_size: Vector<D>, kind: SolidKind<D>) -> Solid<D> {
    Solid::new(Shape::Box { center, half_size, rotation: Matrix::identity() }, kind, 2.0)
}

fn last<const D: usize>(x: &Vector<D>) -> f64 {
    x[D - 1]
}

/// Momentum, and angular momentum about the origin, of all free solids.
fn books<const D: usize>(s: &Simulation<D>) -> (Vector<D>, Vector<3>, f64) {
    let mut sum = (Vector::zeros(), Vector::zeros(), 0.0);
    let three = |v: &Vector<D>| Vector::<3>::from_fn(|a, _| if a < D { v[a] } else { 0.0 });
    for (solid, now) in s.model.solids.iter().zip(&s.state.solids) {
        if solid.kind.is_free_rigid() {
            let rigid = now.as_rigid();
            sum.0 += rigid.velocity * solid.mass_properties.mass;
            sum.1 += solid.angular_momentum(&rigid)
                + three(&rigid.center).cross(&three(&rigid.velocity)) * solid.mass_properties.mass;
            sum.2 += solid.kinetic_energy(now);
        }
    }
    sum
}

fn bounces<const D: usize>(step: f64)
where
    Simulation<D>: Compiled<D>,
{
    let mut center = Vector::repeat(0.5);
    center[D - 1] = 0.85;
    for restitution in [0.3, 0.5, 0.8, 1.0] {
        let mut ball = ball(center, 0.1, Vector::zeros());
        ball.restitution = restitution;
        let mut simulation = dry::<D>(vec![ball], down(), step);
        let (mut lowest, mut highest, mut hit) = (1.0f64, 0.0f64, false);
        run(&mut simulation, 0.85, |s| {
            let now = &s.state.solids[0];
            lowest = lowest.min(last(&now.center_of_mass()));
            hit |= now.velocity()[D - 1] > -1e-3 && s.state.time > 0.1;
            if hit {
                highest = highest.max(last(&now.center_of_mass()));
            }
        });
        let ratio = (highest - 0.1 - REACH) / (0.75 - REACH);
        let expected = restitution * restitution;
        assert!((ratio - expected).abs() <= 0.01 * expected, "{D}D e = {restitution}: {ratio}");
        assert!(lowest - 0.1 > 0.0, "{D}D: {lowest}");
    }
}

#[test]
fn a_ball_bounces_as_its_restitution_says() {
    bounces::<2>(1e-3);
    bounces::<2>(LONG);
    bounces::<3>(LONG);
}

fn incline<const D: usize>(friction: f64, expected: impl Fn(f64) -> f64)
where
    Simulation<D>: Compiled<D>,
{
    let alpha = 0.4f64;
    let mut normal = Vector::zeros();
    (normal[0], normal[D - 1]) = (alpha.sin(), alpha.cos());
    let point = Vector::repeat(0.3);
    let mut floor = Solid::new(Shape::HalfSpace { point, normal }, SolidKind::Fixed, 1.0);
    let center = Vector::<D>::from_fn(|a, _| if a == 0 { 0.2 } else { 0.3 });
    let center = center + normal * (0.1 + 0.05 * DX + (point - center).dot(&normal));
    let mut ball = ball(center, 0.1, Vector::zeros());
    (floor.friction, ball.friction, ball.restitution) = (friction, friction, 0.0);
    let inertia = if D == 2 { 0.5 } else { 0.4 };
    let mut simulation = dry::<D>(vec![floor, ball], down(), 1e-3);
    run(&mut simulation, 0.3, |_| ());
    let along = Vector::<D>::from_fn(|a, _| {
        if a == 0 {
            alpha.cos()
        } else if a + 1 == D {
            -alpha.sin()
        } else {
            0.0
        }
    });
    let way = (simulation.state.solids[1].center_of_mass() - center).dot(&along);
    let expected = 0.5 * GRAVITY * expected(inertia) * 0.09;
    assert!((way / expected - 1.0).abs() < 0.01, "{D}D friction {friction}: {way} for {expected}");
}

#[test]
fn a_ball_rolls_or_slides_down_an_incline() {
    let (s, c) = 0.4f64.sin_cos();
    incline::<2>(0.5, |inertia| s / (1.0 + inertia));
    incline::<3>(0.5, |inertia| s / (1.0 + inertia));
    // Too little friction to roll: μ < tan α / (1 + m r²/I).
    incline::<2>(0.05, |_| s - 0.05 * c);
    incline::<3>(0.0, |_| s);
}

fn central<const D: usize>()
where
    Simulation<D>: Compiled<D>,
{
    let at = |x: f64| Vector::<D>::from_fn(|a, _| if a == 0 { x } else { 0.5 });
    let fast = Vector::from_fn(|a, _| if a == 0 { 1.0 } else { 0.0 });
    for restitution in [1.0, 0.5] {
        let mut balls: Vec<_> =
            [(0.2, 0.08), (0.45, 0.1), (0.65, 0.1)].map(|(x, r)| ball(at(x), r, Vector::zeros())).into();
        balls[0].initial_velocity = fast;
        balls.iter_mut().for_each(|b| b.restitution = restitution);
        if restitution < 1.0 {
            balls.pop();
        }
        let mut simulation = dry::<D>(balls, Vector::zeros(), LONG);
        let start = books(&simulation);
        run(&mut simulation, 0.12, |_| ());
        let (m, n) = (
            simulation.model.solids[0].mass_properties.mass,
            simulation.model.solids[1].mass_properties.mass,
        );
        let speeds: Vec<f64> = simulation.state.solids.iter().map(|s| s.velocity()[0]).collect();
        let first = (m - restitution * n) / (m + n);
        let second = (1.0 + restitution) * m / (m + n);
        // The middle one of three hands all on.
        let expected = if restitution < 1.0 { vec![first, second] } else { vec![first, 0.0, second] };
        let wrong = speeds.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let end = books(&simulation);
        assert!(wrong < 1e-9, "{D}D: {speeds:?} for {expected:?}");
        assert!((end.0 - start.0).norm() < 1e-15);
    }
}

#[test]
fn balls_in_a_row_hand_the_blow_on() {
    central::<2>();
    central::<3>();
}

fn off_centre<const D: usize>()
where
    Simulation<D>: Compiled<D>,
{
    let mut first =
        block::<D>(Vector::repeat(0.3), Vector::from_fn(|a, _| 0.12 - 0.03 * a as f64), SolidKind::Rigid);
    first.initial_velocity = Vector::from_fn(|a, _| 1.0 - 0.1 * a as f64);
    let mut center = Vector::repeat(0.55);
    center[0] = 0.6;
    let axis = Vector::from_fn(|a, _| 0.4 + a as f64);
    let second =
        Solid::new(Shape::Cylinder { center, axis, radius: 0.07, height: 0.3 }, SolidKind::Rigid, 1.0);
    let Simulation { mut model, .. } = dry::<D>(vec![first, second], Vector::zeros(), LONG);
    model.walls = [[Wall::Open; 2]; D];
    let mut simulation = Simulation::new(model, &[]);
    let start = books(&simulation);
    let mut deepest = 0.0f64;
    run(&mut simulation, 0.5, |s| {
        let energy = books(s).2;
        assert!(energy <= start.2 * (1.0 + 1e-12), "{D}D: energy {energy} of {}", start.2);
        let depth = meniscus_sim::overlaps(s.solids()).into_iter().map(|o| o.2).fold(0.0, f64::max);
        deepest = deepest.max(depth);
    });
    let end = books(&simulation);
    let (momentum, turning) =
        ((end.0 - start.0).norm() / start.0.norm(), (end.1 - start.1).norm() / start.0.norm());
    assert!(momentum < 1e-14 && turning < 1e-13, "{D}D: {momentum:e} {turning:e}");
    assert!(simulation.state.solids[1].velocity().norm() > 0.05, "{D}D: they never met");
    assert!(deepest < 0.1 * DX, "{D}D: {} dx", deepest / DX);
}

#[test]
fn an_off_centre_hit_keeps_momentum_and_spin() {
    off_centre::<2>();
    off_centre::<3>();
}

fn rests<const D: usize>(count: usize, flush: bool)
where
    Simulation<D>: Compiled<D>,
{
    let half = Vector::<D>::from_fn(|a, _| if a + 1 == D { 0.06 } else { 0.1 });
    let gap = if flush { 0.0 } else { 0.05 * DX };
    let boxes = (0..count).map(|k| {
        let mut center = Vector::repeat(0.5 + 0.003 * k as f64);
        center[D - 1] = 0.06 + gap + k as f64 * (0.12 + gap);
        block(center, half, SolidKind::Rigid)
    });
    let mut simulation = dry::<D>(boxes.collect(), down(), LONG);
    let way = |s: &Simulation<D>, start: &[SolidState<D>]| {
        let way = |(now, then): (&SolidState<D>, &SolidState<D>)| {
            let [now, then] = [now.as_rigid(), then.as_rigid()];
            (now.center - then.center).norm().max((now.rotation - then.rotation).norm() * 0.1)
        };
        s.state.solids.iter().zip(start).map(way).fold(0.0, f64::max)
    };
    // They settle on the barrier first, which only the time integration damps.
    let start = simulation.state.solids.clone();
    run(&mut simulation, 5.0, |_| ());
    let settled = way(&simulation, &start);
    let (start, mut moved, mut fastest) = (simulation.state.solids.clone(), 0.0f64, [0.0f64; 2]);
    for _ in 0..1000 {
        simulation.step(1e-3, &mut |_| ()).expect("a step");
        moved = moved.max(way(&simulation, &start));
        for s in &simulation.state.solids {
            fastest = [fastest[0].max(s.velocity()[0].abs()), fastest[1].max(last(&s.velocity()).abs())];
        }
    }
    assert!(settled < REACH * count as f64, "{D}D, {count} boxes: settled by {} dx", settled / DX);
    assert!(moved < 0.01 * DX, "{D}D, {count} boxes: moved {} dx", moved / DX);
    // Static friction creeps at most at a tenth of the speed that gravity adds in a step.
    assert!(fastest[1] < 1e-6 && fastest[0] < 0.1 * GRAVITY * 1e-3, "{D}D: {fastest:?}");
}

#[test]
fn boxes_at_rest_stay_at_rest() {
    rests::<2>(1, true);
    rests::<2>(3, true);
    rests::<2>(3, false);
    rests::<3>(1, false);
    rests::<3>(3, true);
}

fn dropped_stack<const D: usize>()
where
    Simulation<D>: Compiled<D>,
{
    let half = Vector::<D>::from_fn(|a, _| if a + 1 == D { 0.05 } else { 0.1 });
    let boxes = (0..3).map(|k| {
        let mut center = Vector::repeat(0.5 + 0.01 * k as f64);
        center[D - 1] = 0.1 + k as f64 * 0.13;
        block(center, half, SolidKind::Rigid)
    });
    let mut simulation = dry::<D>(boxes.collect(), down(), LONG);
    run(&mut simulation, 3.0, |_| ());
    let heights: Vec<f64> = simulation.state.solids.iter().map(|s| last(&s.center_of_mass())).collect();
    let fastest = simulation.state.solids.iter().map(|s| s.velocity().norm()).fold(0.0, f64::max);
    for (k, height) in heights.iter().enumerate() {
        let gaps = height - 0.05 - 0.1 * k as f64;
        assert!(gaps > 0.0 && gaps < REACH * (k + 1) as f64, "{D}D: {heights:?}");
    }
    assert!(fastest < 1e-5, "{D}D: {fastest}");
}

#[test]
fn a_dropped_stack_comes_to_rest() {
    dropped_stack::<2>();
    dropped_stack::<3>();
}

fn bar_meets_plate<const D: usize>()
where
    Simulation<D>: Compiled<D>,
{
    let thin = |a: usize| if a == 0 { 0.15 * DX } else { 0.2 };
    let mut center = Vector::repeat(0.5);
    center[0] = 0.3;
    let mut bar = block::<D>(center, Vector::from_fn(|a, _| thin(a)), SolidKind::Rigid);
    bar.initial_velocity = Vector::from_fn(|a, _| if a == 0 { 50.0 } else { 0.0 });
    let plate = block::<D>(Vector::repeat(0.6), Vector::from_fn(|a, _| thin(a)), SolidKind::Rigid);
    let mut simulation = dry::<D>(vec![bar, plate], Vector::zeros(), LONG);
    let mut fastest = 0.0f64;
    for _ in 0..60 {
        let before: Vec<SolidState<D>> = simulation.state.solids.clone();
        simulation.step(f64::INFINITY, &mut |_| ()).expect("a step");
        let way = before
            .iter()
            .zip(&simulation.state.solids)
            .map(|(a, b)| (a.center_of_mass() - b.center_of_mass()).norm());
        fastest = way.fold(fastest, f64::max);
        let x = |i: usize| simulation.state.solids[i].center_of_mass()[0];
        assert!(x(1) > x(0), "{D}D: the bar is through: {} {}", x(0), x(1));
        assert!(x(1) < 1.0 && x(0) > 0.0);
    }
    assert!(fastest > 0.6 * DX && fastest < DX, "{D}D: {} cells in a step", fastest / DX);
}

#[test]
fn nothing_passes_through_thin_plates() {
    bar_meets_plate::<2>();
    bar_meets_plate::<3>();
}

#[test]
fn a_pusher_moves_a_box_with_its_own_speed_and_its_work_is_told() {
    let path = PrescribedMotion {
        velocity: Vector::<2>::new(0.3, 0.0),
        angular_velocity: [0.0; 3],
        keyframes: Vec::new(),
    };
    let pusher = block(Vector::<2>::new(0.2, 0.3), Vector::<2>::new(0.05, 0.2), SolidKind::Prescribed(path));
    let mut cargo = block(Vector::<2>::new(0.42, 0.1), Vector::<2>::new(0.1, 0.1), SolidKind::Rigid);
    cargo.friction = 0.2;
    let mut simulation = dry(vec![pusher, cargo], down(), LONG);
    run(&mut simulation, 1.6, |_| ());
    let cargo = simulation.state.solids[1].as_rigid();
    assert!((cargo.velocity - Vector::<2>::new(0.3, 0.0)).norm() < 1e-6, "{}", cargo.velocity);
    assert!(
        (cargo.center[0] - 0.83).abs() < 0.3 * DX && cargo.rotation[(0, 0)] > 0.99999,
        "{}",
        cargo.center
    );
}

/// Of two boxes the smaller is looked at first: it may be the bat or what it hits.
#[test]
fn what_a_bat_hits_leaves_it_twice_as_fast() {
    for (bat, hit) in [(0.04, 0.15), (0.15, 0.04)] {
        let path = PrescribedMotion {
            velocity: Vector::from([1.0, 0.0]),
            angular_velocity: [0.0; 3],
            keyframes: Vec::new(),
        };
        let at = |x: f64| Vector::<2>::from([x, 0.5]);
        let mut solids = vec![
            block(at(0.4 - bat), Vector::repeat(bat), SolidKind::Prescribed(path)),
            block(at(0.45 + hit), Vector::repeat(hit), SolidKind::Rigid),
        ];
        solids.iter_mut().for_each(|s| s.restitution = 1.0);
        let mut simulation = dry(solids, Vector::zeros(), 5e-3);
        run(&mut simulation, 0.1, |_| {});
        let speed = simulation.state.solids[1].velocity();
        assert!((speed - Vector::from([2.0, 0.0])).norm() < 1e-6, "{speed}");
    }
}

#[test]
fn what_is_left_no_room_ends_with_an_error_in_bounded_time() {
    let path = PrescribedMotion {
        velocity: Vector::<2>::new(0.3, 0.0),
        angular_velocity: [0.0; 3],
        keyframes: Vec::new(),
    };
    let pusher = block(Vector::<2>::new(0.4, 0.3), Vector::<2>::new(0.05, 0.2), SolidKind::Prescribed(path));
    let ball = ball(Vector::<2>::new(0.8, 0.1 + 0.1 * DX), 0.1, Vector::zeros());
    let mut s = dry(vec![pusher, ball], down(), LONG);
    let mut steps = 0;
    while s.step(1.2 - s.state.time, &mut |_| ()).is_ok() {
        let now = &s.state.solids[1];
        assert!(now.velocity().norm() < 1.0 && meniscus_sim::overlaps(s.solids()).is_empty());
        steps += 1;
        assert!(steps < 1000, "{} s", s.state.time);
    }
    // The pusher's face is at 0.45 + 0.3 t, the wall at 1, the ball 0.2 wide.
    assert!((s.state.time - 0.35 / 0.3).abs() < 1e-2, "{} s", s.state.time);
}

#[test]
fn a_ball_comes_to_rest_between_two_slopes_and_in_a_bowl() {
    let slope =
        |x: f64| Shape::HalfSpace { point: Vector::<2>::repeat(0.2), normal: Vector::<2>::new(x, 1.0) };
    let valley = Solid::new(Shape::Union(vec![slope(1.0), slope(-1.0)]), SolidKind::Fixed, 1.0);
    let all = Shape::Box {
        center: Vector::<2>::new(0.5, 0.3),
        half_size: Vector::<2>::new(0.45, 0.25),
        rotation: Matrix::identity(),
    };
    let hole = Shape::Ball { center: Vector::<2>::new(0.5, 0.6), radius: 0.4 };
    let bowl =
        Solid::new(Shape::Difference { of: Box::new(all), minus: Box::new(hole) }, SolidKind::Fixed, 1.0);
    for (rest, lowest) in
        [(valley, Vector::<2>::new(0.2, 0.2 + 0.1 * 2.0f64.sqrt())), (bowl, Vector::<2>::new(0.5, 0.3))]
    {
        let mut ball = ball(lowest + Vector::<2>::new(0.1, 0.2), 0.1, Vector::zeros());
        ball.friction = 0.0;
        let mut simulation = dry(vec![rest, ball], down(), LONG);
        let mut highest = 0.0f64;
        run(&mut simulation, 4.0, |s| {
            if s.state.time > 3.0 {
                highest = highest.max((s.state.solids[1].center_of_mass() - lowest)[1]);
            }
        });
        assert!(highest < 2.0 * DX && highest > 0.0, "{} dx", highest / DX);
    }
}

#[test]
fn a_heavy_ball_sinks_and_rests_on_the_floor() {
    let mut ball = ball(Vector::<2>::new(0.51, 0.8), 0.12, Vector::zeros());
    ball.young_cosine = 0.3;
    let mut model = model([32; 2], vec![ball], down());
    (model.kinematic_viscosity, model.surface_tension) = (0.01, 0.05);
    let dx = model.grid.dx;
    let distance = |x: &Vector<2>| x[1] - 0.5;
    let mut simulation =
        Simulation::new(model, &[LiquidRegion { signed_distance: &distance, velocity: Vector::zeros() }]);
    let weight = GRAVITY * simulation.model.solids[0].mass_properties.mass;
    let mut settled = None;
    while simulation.state.time < 2.5 {
        let report = simulation.step(0.05, &mut |_| ()).expect("a step");
        let (now, time) = (&simulation.state.solids[0], simulation.state.time);
        let gap = (now.center_of_mass()[1] - 0.12) / dx;
        let speed = report.diagnostics.max_speed;
        assert!(gap > 0.0 && speed < 5.0, "{time}: {gap} {speed}");
        if time > 1.0 {
            let settled = *settled.get_or_insert(gap);
            // On the barrier it gives way to the liquid, which still swings.
            assert!((gap - settled).abs() < 0.01 && gap < 0.25, "{time}: {gap} of {settled}");
        }
        if time > 2.0 {
            // Floor and liquid together hold it, though the liquid still swings.
            let liquid = now.pressure_force[1] + now.contact_line_force[1];
            let held = (now.contact_acceleration[1] * weight / GRAVITY + liquid) / weight;
            assert!((held - 1.0).abs() < 1e-3, "{time}: {held} of its weight is held");
        }
    }
}

/// A drop on a plate in free fall sideways: the plate hits the side, the drop does not feel it until its pressure does.
#[test]
fn a_hit_is_not_given_back_to_the_drop() {
    let mut plate = block(Vector::<2>::new(0.3, 0.4), Vector::<2>::new(0.25, 0.06), SolidKind::Rigid);
    (plate.initial_velocity, plate.restitution, plate.young_cosine) = (Vector::<2>::new(-1.0, 0.0), 1.0, 0.5);
    let mass = plate.mass_properties.mass;
    let mut model = model([48; 2], vec![plate], Vector::zeros());
    model.surface_tension = 0.2;
    let distance = |x: &Vector<2>| ((x - Vector::<2>::new(0.3, 0.46)).norm() - 0.14).max(0.4 - x[1]);
    let velocity = Vector::<2>::new(-1.0, 0.0);
    let mut simulation = Simulation::new(model, &[LiquidRegion { signed_distance: &distance, velocity }]);
    let momentum = |s: &Simulation<2>| s.diagnostics().momentum + s.state.solids[0].velocity() * mass;
    let start = momentum(&simulation);
    let (mut before, mut after) = (start, None);
    while simulation.state.time < 0.12 {
        let held = simulation.state.solids[0].velocity()[0];
        simulation.step(0.05, &mut |_| ()).expect("a step");
        let now = momentum(&simulation);
        if held < 0.0 && simulation.state.solids[0].velocity()[0] > 0.0 {
            assert!((before - start).norm() < 1e-13, "before the hit: {before} of {start}");
            after = Some(now);
        } else if let Some(after) = after {
            assert!((now - after).norm() < 1e-13, "after the hit: {now} of {after}");
        }
        before = now;
    }
    let after = after.expect("a hit");
    // An elastic hit turns the plate's momentum round, and no other.
    assert!((after[0] - start[0] - 2.0 * mass).abs() < 0.05 * mass, "{after} of {start}");
}
