//! Candidates for elements, measured.
#![allow(clippy::unwrap_used)]

mod lattice;

use meniscus_elastic::{
    Anchor, Description, Elastic, Integrator, Law, Order, StiffnessBlock, Weights, lowest_modes,
};
use meniscus_numerics::mesh::VolumeMesh;
use meniscus_numerics::mesh::volume::{Outline, block::block, stuff};
use meniscus_numerics::shape::Shape;
use meniscus_numerics::{Matrix, Vector};
use std::time::Instant;

/// Deflection's energy under weight across, frequency, vertices, entries, seconds for a tangent.
fn measure<const D: usize>(mesh: VolumeMesh<D>, order: Order, poisson: f64, axis: usize) -> [f64; 6] {
    let law = Law::NeoHookean { young: 1.0, poisson, order };
    let low = mesh.positions.iter().map(|x| x[0]).fold(f64::INFINITY, f64::min);
    let high = mesh.positions.iter().map(|x| x[0]).fold(f64::NEG_INFINITY, f64::max);
    let anchors = vec![Anchor::within(&mesh, |x| x[0] < low + 1e-6)];
    let integrator = Integrator { dissipation: 0.0, iterations: 0 };
    let volume = mesh.volume();
    let body = Elastic::new(Description { mesh, density: 1.0, law, damping_ratio: 0.0, anchors, integrator })
        .unwrap();
    let f = lowest_modes(&body, 2).unwrap();
    // Static: the matrix at a step so long that the mass is nothing.
    let step = 1e9;
    let none: [StiffnessBlock<D>; 0] = [];
    let system = body.system(&body.mesh().positions, step, &none).unwrap();
    let mut u: Vec<Vector<D>> = body
        .masses()
        .iter()
        .map(|m| Vector::from_fn(|r, _| if r == axis { 0.25 * step * step * m } else { 0.0 }))
        .collect();
    system.solve_vectors(&mut u);
    let x = &body.mesh().positions;
    let end: Vec<usize> = (0..x.len()).filter(|v| x[*v][0] > high - 1e-6).collect();
    let tip = end.iter().map(|v| u[*v][axis]).sum::<f64>() / end.len() as f64;
    let start = Instant::now();
    let _ = body.tangent(x, Weights { stiffness: 1.0, positive: true, viscosity: 0.0 });
    let time = start.elapsed().as_secs_f64();
    [tip, f[0].frequency, x.len() as f64, body.solver_entries() as f64, time, volume]
}

fn report(name: &str, m: [f64; 6], told: [f64; 2]) {
    println!(
        "{name:34} drop {:+7.2} %  f {:+7.2} %  nodes {:6} entries {:9} tangent {:.4} s volume {:.5}",
        100.0 * (m[0] / told[0] - 1.0),
        100.0 * (m[1] / told[1] - 1.0),
        m[2],
        m[3],
        m[4],
        m[5]
    );
}

/// Deflection of the tip under its weight (unit density and gravity), and lowest frequency, of a beam with E = 1.
fn beam(length: f64, thick: f64, stiffness: f64, poisson: f64) -> [f64; 2] {
    let i = thick * thick / 12.0;
    let g = 1.0 / (2.0 * (1.0 + poisson)) * 10.0 * (1.0 + poisson) / (12.0 + 11.0 * poisson);
    let drop = length.powi(4) / (8.0 * stiffness * i) + length * length / (2.0 * g);
    let thin = (1.875104069f64 / length).powi(2) * (stiffness * i).sqrt();
    let ratio = 4.6478 * i / length.powi(2);
    [drop, thin / (1.0 + ratio * (1.0 + stiffness / g)).sqrt()]
}

fn outline2(length: f64, thick: f64, edge: f64) -> VolumeMesh<2> {
    let o = Outline::polygon(&[[0.0, 0.0], [length, 0.0], [length, thick], [0.0, thick]]).unwrap();
    o.triangulate(edge).unwrap().mesh
}

#[test]
#[ignore = "a table"]
fn table_poisson() {
    for poisson in [0.3, 0.4, 0.45, 0.49] {
        let told = beam(20.0, 1.0, 1.0 / (1.0 - poisson * poisson), poisson);
        for layers in [2usize, 3, 4, 6] {
            let fine = outline2(20.0, 1.0, 2.0 / layers as f64).divided();
            report(
                &format!("2D outline nu {poisson} {layers}"),
                measure(fine, Order::Quadratic, poisson, 1),
                told,
            );
            if layers % 2 == 0 {
                let lattice = block::<2>([10 * layers, layers / 2], &Vector::from([20.0, 1.0])).divided();
                report(
                    &format!("2D lattice nu {poisson} {layers}"),
                    measure(lattice, Order::Quadratic, poisson, 1),
                    told,
                );
            }
        }
        let told = beam(12.0, 1.0, 1.0, poisson);
        for layers in [2usize, 4, 6] {
            let lattice =
                block::<3>([6 * layers, layers, layers / 2], &Vector::from([12.0, 2.0, 1.0])).divided();
            report(
                &format!("3D lattice nu {poisson} {layers}"),
                measure(lattice, Order::Quadratic, poisson, 2),
                told,
            );
        }
    }
}

fn stuffed(size: [f64; 3], edge: f64, turn: f64) -> VolumeMesh<3> {
    let (s, c) = turn.sin_cos();
    let rotation = Matrix::<3>::from_fn(|r, k| match (r, k) {
        (1, 1) | (2, 2) => c,
        (1, 2) => -s,
        (2, 1) => s,
        (0, 0) => 1.0,
        _ => 0.0,
    });
    let half = Vector::from(size) * 0.5;
    let shape = Shape::Box { center: half, half_size: half, rotation };
    let (lower, upper) = shape.bounds();
    stuff(&|x| shape.signed_distance(x), &lower, &upper, edge)
        .unwrap()
        .moved(&rotation.transpose(), &Vector::zeros())
}

/// Vertices of elements that lie below a place along the first axis, with all of their vertices; elements divided `times`.
fn held_elements<const D: usize>(mesh: &VolumeMesh<D>, times: u32, below: f64) -> Vec<u32> {
    let group = 1usize << (D as u32 * times);
    let mut held = Vec::new();
    for parts in mesh.simplices.chunks(group) {
        if parts.iter().all(|s| s.vertices().all(|v| mesh.positions[v as usize][0] < below)) {
            held.extend(parts.iter().flat_map(|s| s.vertices()));
        }
    }
    held.sort_unstable();
    held.dedup();
    held
}

/// Compliance (work of the weight across) and lowest frequency.
fn compliance<const D: usize>(
    mesh: &VolumeMesh<D>,
    times: u32,
    below: f64,
    order: Order,
    poisson: f64,
) -> [f64; 6] {
    let law = Law::NeoHookean { young: 1.0, poisson, order };
    let anchors =
        vec![Anchor { vertices: held_elements(mesh, times, below), motion: meniscus_elastic::Motion::Fixed }];
    let integrator = Integrator { dissipation: 0.0, iterations: 0 };
    let body = Elastic::new(Description {
        mesh: mesh.clone(),
        density: 1.0,
        law,
        damping_ratio: 0.0,
        anchors,
        integrator,
    })
    .unwrap();
    let f = lowest_modes(&body, 1).unwrap();
    let step = 1e8;
    let none: [StiffnessBlock<D>; 0] = [];
    let system = body.system(&body.mesh().positions, step, &none).unwrap();
    let pull: Vec<Vector<D>> = body
        .masses()
        .iter()
        .map(|m| Vector::from_fn(|r, _| if r + 1 == D { 0.25 * step * step * m } else { 0.0 }))
        .collect();
    let mut u = pull.clone();
    system.solve_vectors(&mut u);
    let work = u.iter().zip(&pull).map(|(u, p)| u.dot(p)).sum::<f64>() / (0.25 * step * step);
    let x = &body.mesh().positions;
    let start = Instant::now();
    let _ = body.tangent(x, Weights { stiffness: 1.0, positive: true, viscosity: 0.0 });
    let time = start.elapsed().as_secs_f64();
    [work, f[0].frequency, x.len() as f64, body.solver_entries() as f64, time, mesh.volume()]
}

/// Each mesh against its own reference: the same body, divided.
#[test]
#[ignore = "a table"]
fn table_stuffed() {
    for poisson in [0.3, 0.45, 0.49] {
        let size = [13.0, 4.0, 1.0];
        for layers in [2usize, 3, 4] {
            let edge = 1.0 / layers as f64;
            for turn in [0.0, 0.35] {
                println!("--- nu {poisson} layers {layers} turn {turn}");
                let (s, c) = f64::sin_cos(turn);
                let rotation = Matrix::<3>::from_fn(|r, k| match (r, k) {
                    (1, 1) | (2, 2) => c,
                    (1, 2) => -s,
                    (2, 1) => s,
                    (0, 0) => 1.0,
                    _ => 0.0,
                });
                let half = Vector::from(size) * 0.5;
                let shape = Shape::Box { center: half, half_size: half, rotation };
                let (lower, upper) = shape.bounds();
                let distance = |x: &Vector<3>| shape.signed_distance(x);
                let mesh = meniscus_numerics::mesh::volume::quadratic::stuff_of(
                    Order::Quadratic,
                    &distance,
                    &lower,
                    &upper,
                    edge,
                )
                .unwrap()
                .moved(&rotation.transpose(), &Vector::zeros());
                let linear = stuff(&distance, &lower, &upper, edge).unwrap();
                println!("linear volume {} quality {}", linear.volume(), mesh.quality());
                if let Err(e) = mesh.check() {
                    println!("{e:?}");
                }
                // Straight, so that its division is the same body.
                let straight = stuffed(size, 2.0 * edge, turn).divided();
                if layers < 4 {
                    let told = compliance(&straight.divided(), 2, 1.5, Order::Quadratic, poisson);
                    report(
                        "straight",
                        compliance(&straight, 1, 1.5, Order::Quadratic, poisson),
                        [told[0], told[1]],
                    );
                }
            }
        }
    }
}
