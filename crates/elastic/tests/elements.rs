//! Candidates for elements, measured.
#![allow(clippy::unwrap_used)]

mod lattice;

use meniscus_elastic::{Anchor, Description, Elastic, Integrator, Law, Smoothing, StiffnessBlock, Weights, lowest_modes};
use meniscus_numerics::mesh::VolumeMesh;
use meniscus_numerics::mesh::volume::{Outline, block::block, stuff};
use meniscus_numerics::shape::Shape;
use meniscus_numerics::{Matrix, Vector};
use std::time::Instant;

const POISSON: f64 = 0.3;

/// Deflection's energy under weight across, frequency, vertices, entries, seconds for a tangent.
fn measure<const D: usize>(mesh: VolumeMesh<D>, smoothing: Smoothing, poisson: f64, axis: usize) -> [f64; 6] {
    let law = Law::NeoHookean { young: 1.0, poisson, smoothing };
    let low = mesh.positions.iter().map(|x| x[0]).fold(f64::INFINITY, f64::min);
    let high = mesh.positions.iter().map(|x| x[0]).fold(f64::NEG_INFINITY, f64::max);
    let anchors = vec![Anchor::within(&mesh, |x| x[0] < low + 1e-6)];
    let integrator = Integrator { dissipation: 0.0, iterations: 0 };
    let volume = mesh.volume();
    let body = Elastic::new(Description { mesh, density: 1.0, law, damping_ratio: 0.0, anchors, integrator }).unwrap();
    let f = lowest_modes(&body, 2).unwrap();
    // Static: the matrix at a step so long that the mass is nothing.
    let step = 1e9;
    let none: [StiffnessBlock<D>; 0] = [];
    let system = body.system(&body.mesh().positions, step, &none).unwrap();
    let mut u: Vec<Vector<D>> = body.masses().iter().map(|m| Vector::from_fn(|r, _| if r == axis { 0.25 * step * step * m } else { 0.0 })).collect();
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
    println!("{name:34} drop {:+7.2} %  f {:+7.2} %  nodes {:6} entries {:9} tangent {:.4} s volume {:.5}", 100.0*(m[0]/told[0]-1.0), 100.0*(m[1]/told[1]-1.0), m[2], m[3], m[4], m[5]);
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
fn table_2d() {
    for poisson in [0.3, 0.49] {
        let (length, thick) = (20.0, 1.0);
        let told = beam(length, thick, 1.0 / (1.0 - poisson * poisson), poisson);
        for layers in [2usize, 3, 4] {
            println!("--- nu {poisson} layers {layers}");
            let edge = thick / layers as f64;
            let fine = outline2(length, thick, edge);
            for s in [Smoothing::None, Smoothing::Cells, Smoothing::Edges] {
                report(&format!("outline {s:?}"), measure(fine.clone(), s, poisson, 1), told);
            }
            report("outline quadratic", measure(outline2(length, thick, 2.0 * edge).divided(), Smoothing::Quadratic, poisson, 1), told);
            let cells = [20 * layers, layers];
            let lattice = block::<2>(cells, &Vector::from([length, thick]));
            for s in [Smoothing::None, Smoothing::Cells, Smoothing::Edges] {
                report(&format!("lattice {s:?}"), measure(lattice.clone(), s, poisson, 1), told);
            }
            if layers % 2 == 0 {
                report("lattice quadratic", measure(block::<2>(cells.map(|c| c / 2), &Vector::from([length, thick])).divided(), Smoothing::Quadratic, poisson, 1), told);
            }
        }
    }
}

fn stuffed(size: [f64; 3], edge: f64, turn: f64) -> VolumeMesh<3> {
    let (s, c) = turn.sin_cos();
    let rotation = Matrix::<3>::from_fn(|r, k| match (r, k) { (1, 1) | (2, 2) => c, (1, 2) => -s, (2, 1) => s, (0, 0) => 1.0, _ => 0.0 });
    let half = Vector::from(size) * 0.5;
    let shape = Shape::Box { center: half, half_size: half, rotation };
    let (lower, upper) = shape.bounds();
    stuff(&|x| shape.signed_distance(x), &lower, &upper, edge).unwrap().moved(&rotation.transpose(), &Vector::zeros())
}

#[test]
#[ignore = "a table"]
fn table_3d() {
    for poisson in [0.3, 0.49] {
        // A plate strip, ten times as long as thick; as wide as four times its thickness.
        let size = [12.0, 2.0, 1.0];
        for layers in [2usize, 3, 4] {
            println!("--- nu {poisson} layers {layers}");
            let edge = 1.0 / layers as f64;
            let told = beam(size[0], size[2], 1.0, poisson);
            let start = Instant::now();
            for turn in [0.0, 0.35] {
                let fine = stuffed(size, edge, turn);
                let coarse = stuffed(size, 2.0 * edge, turn).divided();
                // Their own reference: divided until nothing changes.
                for s in [Smoothing::None, Smoothing::Cells, Smoothing::Edges] {
                    report(&format!("stuffed {turn} {s:?}"), measure(fine.clone(), s, poisson, 2), told);
                }
                report(&format!("stuffed {turn} quadratic"), measure(coarse.clone(), Smoothing::Quadratic, poisson, 2), told);
                if layers == 2 {
                    let m = measure(coarse.divided(), Smoothing::Quadratic, poisson, 2);
                    report(&format!("stuffed {turn} quadratic divided"), m, told);
                }
                if layers < 4 {
                    report(&format!("stuffed {turn} quadratic of fine"), measure(fine.divided(), Smoothing::Quadratic, poisson, 2), told);
                }
            }
            let cells = [12 * layers, 2 * layers, layers];
            let lattice = block::<3>(cells, &Vector::from(size));
            for s in [Smoothing::None, Smoothing::Cells, Smoothing::Edges] {
                report(&format!("lattice {s:?}"), measure(lattice.clone(), s, poisson, 2), told);
            }
            if layers % 2 == 0 {
                report("lattice quadratic", measure(block::<3>(cells.map(|c| c / 2), &Vector::from(size)).divided(), Smoothing::Quadratic, poisson, 2), told);
            }
            println!("{:.1} s", start.elapsed().as_secs_f64());
        }
    }
}
