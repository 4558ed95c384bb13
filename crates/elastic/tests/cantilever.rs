//! Cantilevers against beam theory.

mod lattice;

use lattice::{block, clamped};
use meniscus_elastic::{Elastic, Integrator, Law, Smoothing, lowest_modes};
use meniscus_numerics::Vector;

/// Bending frequencies of a clamped beam, Timoshenko's theory in the plane strain: roots by the thin beam's, corrected for
/// shear and rotary inertia to first order would do; here the thin beam's are enough (L/t = 20).
const WAVES: [f64; 3] = [1.875104069, 4.694091133, 7.854757438];

fn law(young: f64, poisson: f64, smoothing: Smoothing) -> Law {
    Law::NeoHookean { young, poisson, smoothing }
}

/// Where a body comes to rest under gravity along its last axis: steps of backward Euler that hardly end.
fn settled<const D: usize>(body: &Elastic<D>, gravity: f64, step: f64, steps: usize) -> Vec<Vector<D>> {
    let weight = |m: &f64| Vector::from_fn(|r, _| if r == D - 1 { -gravity * m } else { 0.0 });
    let weight: Vec<Vector<D>> = body.masses().iter().map(weight).collect();
    let mut state = body.at_rest(step);
    for _ in 0..steps {
        body.step(&mut state, step, &weight).unwrap();
    }
    state.positions
}

/// Tip's drop and place of the middle of the end, relative to the length.
fn tip<const D: usize>(body: &Elastic<D>, positions: &[Vector<D>], length: f64) -> (f64, f64) {
    let rest = &body.mesh().positions;
    let end: Vec<usize> = (0..rest.len()).filter(|v| rest[*v][0] > length - 1e-9).collect();
    let mean = |a: usize| end.iter().map(|v| positions[*v][a]).sum::<f64>() / end.len() as f64;
    let start = |a: usize| end.iter().map(|v| rest[*v][a]).sum::<f64>() / end.len() as f64;
    ((start(D - 1) - mean(D - 1)) / length, mean(0) / length)
}

fn frequencies(cells: [usize; 2], poisson: f64, smoothing: Smoothing) -> [f64; 3] {
    let (length, thick, density, young) = (4.0, 0.2, 1.2, 1e8);
    let body = Elastic::new(clamped(
        block::<2>(cells, [length, thick]),
        density,
        law(young, poisson, smoothing),
        Integrator::default(),
    ))
    .unwrap();
    let modes = lowest_modes(&body, 3).unwrap();
    let plate = young / (1.0 - poisson * poisson);
    std::array::from_fn(|k| {
        let thin = (WAVES[k] / length).powi(2) * (plate * thick * thick / 12.0 / density).sqrt();
        modes[k].frequency / thin
    })
}

#[test]
fn frequencies_of_a_thin_beam() {
    for poisson in [0.0, 0.3, 0.45] {
        for layers in [2, 3, 4, 6] {
            let cells = [20 * layers, layers];
            let all =
                [Smoothing::None, Smoothing::Cells, Smoothing::Edges].map(|s| frequencies(cells, poisson, s));
            println!("nu {poisson} layers {layers}: {all:.4?}");
        }
    }
}

#[test]
fn large_deflection() {
    let (length, thick, density, young, poisson) = (4.0, 0.2, 1.2, 1e8, 0.3);
    let stiffness = young / (1.0 - poisson * poisson) * thick * thick * thick / 12.0;
    let told = [
        (1.0, 0.123471, 0.991246),
        (2.0, 0.238507, 0.966893),
        (5.0, 0.495905, 0.846657),
        (10.0, 0.700200, 0.656354),
    ];
    for layers in [2, 4] {
        for (load, drop, along) in told {
            for neo in [true, false] {
                let law = if neo {
                    Law::NeoHookean { young, poisson, smoothing: Smoothing::Cells }
                } else {
                    Law::Corotated { young, poisson, smoothing: Smoothing::Cells }
                };
                let integrator = Integrator { dissipation: 1.0, iterations: 0 };
                let mesh = block::<2>([20 * layers, layers], [length, thick]);
                let body = Elastic::new(clamped(mesh, density, law, integrator)).unwrap();
                let gravity = load * stiffness / (density * thick * length.powi(3));
                let x = settled(&body, gravity, 0.001, 300);
                let (d, a) = tip(&body, &x, length);
                println!("layers {layers} load {load} neo {neo}: drop {:.4} x {:.4}", d / drop, a / along);
            }
        }
    }
}
