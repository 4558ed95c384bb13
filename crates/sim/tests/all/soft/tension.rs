//! What the tension of its wetted surface does to a solid that deforms.

#![allow(clippy::expect_used)]

use crate::soft::collide::{block, soft};
use meniscus_numerics::Vector;
use meniscus_numerics::grid::Grid;
use meniscus_sim::{LiquidRegion, Model, Numerics, Simulation, Wall};

/// Under liquid altogether there is no line, and yet the surface's tension, more by `−γ cos θ` than where it is dry, presses
/// it together: the mean stress of a square of side 2 a is `γ cos θ / a` along both axes, whatever the stress within is.
#[test]
fn what_is_under_liquid_is_pressed_by_its_tension() {
    const CELLS: usize = 32;
    const HALF: f64 = 0.15;
    let (young, poisson, gamma, cosine) = (400.0, 0.3, 1.0, -0.5);
    let middle = Vector::<2>::from([0.51, 0.42]);
    let mut square = soft(block([8, 8], middle, Vector::repeat(HALF)), young, 0.5, Vec::new());
    square.young_cosine = cosine;
    let model = Model {
        grid: Grid::new([CELLS; 2], 1.0 / CELLS as f64),
        walls: [[Wall::Slip; 2]; 2],
        density: 1.0,
        kinematic_viscosity: 0.1,
        surface_tension: gamma,
        gravity: Vector::zeros(),
        solids: vec![square],
        numerics: Numerics::default(),
    };
    let level = |x: &Vector<2>| x[1] - 0.85;
    let mut simulation =
        Simulation::new(model, &[LiquidRegion { signed_distance: &level, velocity: Vector::zeros() }]);
    let area = |s: &Simulation<2>| -> f64 {
        let elastic = s.model.solids[0].elastic().expect("soft");
        let x = &s.state.solids[0].as_deformable().expect("soft").vertices.positions;
        elastic.rest_mesh().simplices.iter().map(|simplex| simplex.volume(x)).sum()
    };
    let rest = area(&simulation);
    while simulation.state.time < 1.0 {
        simulation.step(f64::INFINITY, &mut |_| ()).expect("a step");
    }
    let mu = 0.5 * young / (1.0 + poisson);
    let lambda = 2.0 * mu * poisson / (1.0 - 2.0 * poisson);
    // Plane strain: σ = 2 (λ + μ) ε, and the area changes by 2 ε.
    let expected = gamma * cosine / HALF / (lambda + mu);
    let found = area(&simulation) / rest - 1.0;
    println!("area by {found:.5} for {expected:.5}");
    assert!((found / expected - 1.0).abs() < 0.06, "{found} for {expected}");
}
