//! Newton's iterations of steps in which a soft solid turns and bends far.

#![allow(clippy::expect_used)]

use crate::soft::collide::{DENSITY, block, down, dry, places, run, soft};
use meniscus_numerics::Vector;
use meniscus_numerics::grid::Grid;
use meniscus_sim::{Kinematics, LiquidRegion, Model, Numerics, Simulation, Wall};

/// Sets a soft solid spinning, rad/s, about its centre.
fn spin(s: &mut Simulation<2>, omega: f64) {
    if let Kinematics::Deformable(body) = &mut s.state.solids[0].kinematics {
        for (v, x) in body.vertices.velocities.iter_mut().zip(&body.vertices.positions) {
            *v = Vector::<2>::from([body.center[1] - x[1], x[0] - body.center[0]]) * omega;
        }
    }
}

/// A spinning strip in a bath, after a step with so many iterations beyond the first at least: the velocities of its vertices.
fn stirred(iterations: u32) -> Vec<Vector<2>> {
    const CELLS: usize = 32;
    let strip =
        soft(block([24, 2], Vector::from([0.51, 0.45]), Vector::from([0.3, 0.05])), 20.0, 0.1, Vec::new());
    let model = Model {
        grid: Grid::new([CELLS; 2], 1.0 / CELLS as f64),
        walls: [[Wall::Slip; 2]; 2],
        density: 1.0,
        kinematic_viscosity: 1e-3,
        surface_tension: 1.0,
        gravity: Vector::zeros(),
        solids: vec![strip],
        numerics: Numerics {
            tolerance: 1e-12,
            newton_iterations: iterations,
            fixed_step: Some(0.02),
            ..Numerics::default()
        },
    };
    let level = |x: &Vector<2>| x[1] - 0.85;
    let mut s =
        Simulation::new(model, &[LiquidRegion { signed_distance: &level, velocity: Vector::zeros() }]);
    spin(&mut s, 8.0);
    s.step(f64::INFINITY, &mut |_| ()).expect("a step");
    s.state.solids[0].as_deformable().expect("soft").vertices.velocities.clone()
}

/// With the liquid's pressure in them, iterations come to an end: those beyond what Newton's method asks for itself change little, and
/// each at most a fifth of what the one before did (the lagged part of the forces converges linearly, by about 0.05 here).
#[test]
fn iterations_converge_in_liquid() {
    let all: Vec<Vec<Vector<2>>> = (0..8).map(stirred).collect();
    let size = |of: &[Vector<2>]| of.iter().map(|v| v.norm_squared()).sum::<f64>().sqrt();
    let change = |k: usize| {
        let change: Vec<Vector<2>> = all[k].iter().zip(&all[k + 1]).map(|(a, b)| b - a).collect();
        size(&change) / size(&all[7])
    };
    let changes: Vec<f64> = (0..7).map(change).filter(|c| *c > 0.0).collect();
    println!("{changes:?}");
    assert!(changes.len() >= 3 && changes[0] < 1e-5, "{changes:?}");
    assert!(changes.array_windows().all(|[one, next]| *next < 0.2 * one), "{changes:?}");
}

/// What rests on the floor, pressed by a fifth under its weight, is as high with more iterations as without.
#[test]
fn iterations_know_of_the_floor() {
    let height = |iterations| {
        let young = 2.0 * DENSITY * 9.81 * 0.4;
        let square = block([10, 10], Vector::from([0.5, 0.2]), Vector::repeat(0.2));
        let mut s = dry(vec![soft(square, young, 1.0, Vec::new())], down(), 0.02);
        s.model.numerics.newton_iterations = iterations;
        run(&mut s, 3.0, |_| ());
        let x = places(&s, 0);
        x.iter().map(|x| x[1]).fold(0.0, f64::max) - x.iter().map(|x| x[1]).fold(1.0, f64::min)
    };
    let (few, more) = (height(0), height(3));
    println!("{few:.6} and {more:.6} of 0.4 high");
    assert!(few < 0.34 && (more - few).abs() < 1e-4 * few, "{few} {more}");
}
