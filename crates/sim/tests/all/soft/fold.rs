//! Solids that deform and run into themselves, meet with their edges first, or lie in a heap.

#![allow(clippy::expect_used)]

use crate::soft::collide::{
    DENSITY, DX, at, ball, block, books, depth, down, dry, lattice, mapped, places, rigid, run, soft,
};
use meniscus_elastic::Anchor;
use meniscus_numerics::Vector;
use meniscus_numerics::shape::Shape;
use meniscus_sim::{Compiled, Kinematics, LiquidRegion, Simulation, Solid, SolidKind};

/// Distance of far parts of a strip with so many columns of vertices, m.
fn own_distance(s: &Simulation<2>, columns: usize) -> f64 {
    let all = places(s, 0);
    let far = |i: usize, j: usize| (i % columns).abs_diff(j % columns) > 8;
    let pairs = (0..all.len()).flat_map(|i| (0..i).map(move |j| (i, j))).filter(|(i, j)| far(*i, *j));
    pairs.map(|(i, j)| (all[i] - all[j]).norm()).fold(1.0, f64::min)
}

/// A strip whose ends are pulled together above its middle, and pressed on each other.
fn closes(apart: f64, time: f64) {
    let n = [48, 2];
    let (half, low) = (0.4, 0.3);
    let mesh = block::<2>(n, Vector::from([0.5, low]), Vector::from([half, 0.01]));
    let end = |side: f64, x: &Vector<2>| side * (x[0] - 0.5) > half - 1e-9;
    let mut left = Anchor::within(&mesh, |x| end(-1.0, x));
    let mut right = Anchor::within(&mesh, |x| end(1.0, x));
    let keys = |side: f64| {
        let way = side * (half - apart);
        meniscus_elastic::AnchorMotion::Keyframes(vec![
            (0.0, Vector::zeros()),
            (0.4, Vector::from([-0.2 * side, 0.25])),
            (1.0, Vector::from([-way, 0.25])),
        ])
    };
    (left.motion, right.motion) = (keys(-1.0), keys(1.0));
    let strip = soft(mesh, 2e5, 0.1, vec![left, right]);
    let mut simulation = dry::<2>(vec![strip], Vector::zeros(), 5e-3);
    let (mut worst, mut late, mut near) = (f64::NEG_INFINITY, 0.0f64, 1.0f64);
    run(&mut simulation, time, |s| {
        worst = worst.max(depth(s));
        near = near.min(own_distance(s, 49));
        if s.state.time > 0.8 * time {
            late = late.max(s.model.solids[0].max_speed(&s.state.solids[0]));
        }
    });
    let shape: Vec<_> = places(&simulation, 0).iter().take(49).step_by(6).map(|x| [x[0], x[1]]).collect();
    println!(
        "closing strip: depth {:.2e} dx, near {:.3} dx, late speed {late:.1e}, {shape:.3?}",
        worst / DX,
        near / DX
    );
    assert!(near < 0.4 * DX, "it never met itself: {near}");
    assert!(worst < 0.0, "{worst}");
    assert!(late < 0.05, "{late}");
}

#[test]
fn the_ends_of_a_strip_press_on_each_other() {
    closes(0.004, 2.5);
}

/// A strip curled by hand into a spiral that is let go: it meets itself.
#[test]
fn a_curled_strip_meets_itself() {
    let n = [64, 2];
    let mesh = block::<2>(n, Vector::from([0.5, 0.5]), Vector::from([0.42, 0.008]));
    let ends = Anchor::within(&mesh, |x: &Vector<2>| x[0] < 0.09);
    let mut strip = soft(mesh, 2e4, 0.02, vec![ends]);
    strip.initial_velocity = Vector::zeros();
    let mut simulation = dry::<2>(vec![strip], Vector::zeros(), 1.0);
    // A blow that turns the free end over and over.
    if let Kinematics::Deformable(body) = &mut simulation.state.solids[0].kinematics {
        for (x, v) in body.vertices.positions.iter().zip(&mut body.vertices.velocities) {
            *v = Vector::from([0.0, 100.0 * (x[0] - 0.09).powi(2)]);
        }
    }
    let (mut worst, mut near) = (f64::NEG_INFINITY, 1.0f64);
    run(&mut simulation, 0.6, |s| {
        worst = worst.max(depth(s));
        near = near.min(own_distance(s, 65));
    });
    println!(
        "curled: depth {:.2e} dx, near {:.3} dx in {} steps",
        worst / DX,
        near / DX,
        simulation.state.step
    );
    assert!(near < 0.4 * DX, "it never met itself: {near}");
    assert!(worst < 0.0, "{worst}");
}

/// A sheet whose halves are thrown at each other.
fn claps(n: [usize; 3], speed: f64, step: f64) {
    let half = Vector::from([0.3, 0.3, 0.012]);
    let mesh = block::<3>(n, Vector::from([0.5, 0.5, 0.3]), half);
    let mut simulation = dry::<3>(vec![soft(mesh, 100.0, 0.05, Vec::new())], Vector::zeros(), step);
    if let Kinematics::Deformable(body) = &mut simulation.state.solids[0].kinematics {
        for (x, v) in body.vertices.positions.iter().zip(&mut body.vertices.velocities) {
            let arm = x[0] - 0.47;
            *v = Vector::from([-arm, 0.1 * arm, 3.0 * arm.abs() - 0.3]) * speed;
        }
    }
    let start = books(&simulation);
    let mut worst = f64::NEG_INFINITY;
    run(&mut simulation, 2.0 / speed, |s| worst = worst.max(depth(s)));
    let wrong = (books(&simulation).0 - start.0).norm() / start.0.norm();
    let steps = simulation.state.step;
    println!("sheet of {n:?} at {speed}: depth {:.2e} dx, momentum {wrong:.1e}, {steps} steps", worst / DX);
    assert!(worst < 0.0, "{worst}");
    assert!(wrong < 1e-11, "{wrong}");
}

#[test]
fn the_halves_of_a_sheet_meet() {
    claps([10, 8, 1], 4.0, 1.0);
    claps([17, 12, 1], 20.0, 1.0);
    claps([17, 12, 1], 2.0, 1.0);
}

#[test]
fn the_halves_of_a_fine_sheet_meet() {
    claps([31, 28, 1], 10.0, 1.0);
}

/// Plates thrown at each other with their edges ahead, and at a rigid box.
fn edges_first<const D: usize>(n: [usize; D], speed: f64)
where
    Simulation<D>: Compiled<D>,
{
    let flat = Vector::<D>::from_fn(|a, _| if a + 1 == D { 0.012 } else { 0.15 });
    let plate = |angle: f64, yaw: f64, center: Vector<D>| {
        let turned = move |x: &Vector<D>| {
            let mut y = x.component_mul(&flat);
            if D == 3 {
                (y[0], y[1]) = (y[0] * yaw.cos() - y[1] * yaw.sin(), y[0] * yaw.sin() + y[1] * yaw.cos());
            }
            (y[0], y[D - 1]) =
                (y[0] * angle.cos() - y[D - 1] * angle.sin(), y[0] * angle.sin() + y[D - 1] * angle.cos());
            center + y
        };
        soft(mapped(lattice(n), turned), 3e4, 0.02, Vec::new())
    };
    let mut solids = vec![plate(1.4, 0.6, at(0.25, 0.5)), plate(0.1, 0.2, at(0.62, 0.52))];
    solids[0].initial_velocity[0] = speed;
    solids[1].initial_velocity[0] = -speed;
    solids.push(rigid(at(0.5, 0.15), Vector::repeat(0.08), SolidKind::Rigid));
    solids[2].initial_velocity[D - 1] = 0.7 * speed;
    let mut simulation = dry::<D>(solids, Vector::zeros(), 1.0);
    let start = books(&simulation);
    let (mut worst, mut wrong) = (f64::NEG_INFINITY, 0.0f64);
    let mut inside = true;
    run(&mut simulation, 0.6 / speed, |s| {
        worst = worst.max(depth(s));
        // The sides of the domain take momentum.
        inside = inside
            && (0..2).all(|i| places(s, i).iter().all(|x| x.min() > 0.1 * DX && x.max() < 1.0 - 0.1 * DX));
        if inside {
            wrong =
                wrong.max((books(s).0 - start.0).norm() / (speed * s.model.solids[0].mass_properties.mass));
        }
    });
    let steps = simulation.state.step;
    println!("{D}D edges first at {speed}: depth {:.2e} dx, momentum {wrong:.1e}, {steps} steps", worst / DX);
    assert!(worst < 0.0, "{D}D: {worst}");
    assert!(wrong < 1e-11, "{D}D: {wrong}");
}

#[test]
fn plates_meet_with_their_edges_first() {
    for speed in [1.0, 30.0] {
        edges_first::<2>([24, 2], speed);
        edges_first::<3>([8, 8, 1], speed);
    }
}

/// Soft and rigid balls in a heap.
fn heaps<const D: usize>(n: usize, time: f64)
where
    Simulation<D>: Compiled<D>,
{
    let mut solids = Vec::new();
    for k in 0..9 {
        let place = Vector::<D>::from_fn(|a, _| match a {
            0 => 0.2 + 0.29 * (k % 3) as f64 + 0.02 * (k / 3) as f64,
            a if a + 1 == D => 0.15 + 0.28 * (k / 3) as f64,
            _ => 0.5 + 0.01 * (k % 4) as f64,
        });
        solids.push(if k % 4 == 3 {
            Solid::new(Shape::Ball { center: place, radius: 0.12 }, SolidKind::Rigid, DENSITY)
        } else {
            soft(ball(n, place, 0.12), 300.0, 0.1, Vec::new())
        });
    }
    let mut simulation = dry::<D>(solids, down(), 1.0);
    let mut worst = f64::NEG_INFINITY;
    run(&mut simulation, time, |s| worst = worst.max(depth(s)));
    let all = simulation.model.solids.iter().zip(&simulation.state.solids);
    let speed = all.map(|(s, now)| s.max_speed(now)).fold(0.0, f64::max);
    println!("{D}D heap: depth {:.2e} dx, speed {speed:.1e}, {} steps", worst / DX, simulation.state.step);
    assert!(worst < 0.0, "{D}D: {worst}");
}

#[test]
fn soft_and_rigid_balls_make_a_heap() {
    heaps::<2>(8, 1.0);
    heaps::<3>(4, 0.4);
}

/// Under water it rests with its weight less what the water carries.
#[test]
fn a_soft_disc_rests_on_the_floor_of_a_bath() {
    let radius = 0.15;
    let mut disc = soft(ball::<2>(12, at(0.5, radius + 0.05 * DX), radius), 2e3, 0.5, Vec::new());
    disc.friction = 0.0;
    let model = dry::<2>(vec![disc], down(), 1.0).model;
    let surface = |x: &Vector<2>| x[1] - 0.7;
    let mut simulation =
        Simulation::new(model, &[LiquidRegion { signed_distance: &surface, velocity: Vector::zeros() }]);
    let (mut worst, mut held, mut fastest) = (f64::NEG_INFINITY, Vec::new(), 0.0f64);
    run(&mut simulation, 1.2, |s| {
        worst = worst.max(depth(s));
        if s.state.time > 0.8 {
            held.push(s.state.solids[0].contact_acceleration[1] / 10.0);
            fastest = fastest.max(s.diagnostics().max_speed);
        }
    });
    let mean = held.iter().sum::<f64>() / held.len() as f64;
    let most = held.iter().copied().fold(0.0, f64::max);
    let steps = simulation.state.step;
    println!(
        "bath: depth {:.2e} dx, force {mean:.4}, at most {most:.4}, speed {fastest:.1e}, {steps} steps",
        worst / DX
    );
    assert!(worst < 0.0, "{worst}");
    assert!((mean - 0.5).abs() < 0.05, "{mean}");
}
