//! The flag of Turek & Hron 2006 by itself: tests CSM1 (at rest) and CSM3 (swinging), a beam of 0.35 m × 0.02 m at a
//! cylinder of radius 0.05 m, ρ = 1000 kg/m³, E = 1.4 MPa, ν = 0.4, under 2 m/s².
#![allow(clippy::unwrap_used)]

mod lattice;

use lattice::{block, free, rubber};
use meniscus_elastic::{Anchor, Elastic, Integrator};
use meniscus_numerics::Vector;

const GRAVITY: f64 = 2.0;

/// The flag, its left end along the cylinder, its tip's middle vertex.
fn flag(cells: [usize; 2], damping_ratio: f64, dissipation: f64) -> (Elastic<2>, usize) {
    let mut mesh = block::<2>(cells, [1.0, 0.02]);
    let row = cells[0] + 1;
    let held: Vec<u32> = (0..=cells[1]).map(|k| (k * row) as u32).collect();
    for x in &mut mesh.positions {
        let start = (0.05f64.powi(2) - (x[1] - 0.01).powi(2)).sqrt();
        x[0] = start + x[0] * (0.4 - start);
    }
    let tip = cells[1] / 2 * row + cells[0];
    let mut description = free(mesh, 1000.0, rubber(1.4e6, 0.4), Integrator { dissipation, iterations: 0 });
    description.anchors = vec![Anchor { vertices: held, motion: meniscus_elastic::Motion::Fixed }];
    description.damping_ratio = damping_ratio;
    (Elastic::new(description).unwrap(), tip)
}

fn weight(body: &Elastic<2>) -> Vec<Vector<2>> {
    body.masses().iter().map(|m| Vector::from([0.0, -GRAVITY * m])).collect()
}

fn moved(body: &Elastic<2>, positions: &[Vector<2>], tip: usize) -> Vector<2> {
    positions[tip] - body.mesh().positions[tip]
}

#[test]
fn csm1_rest() {
    for layers in [2, 4] {
        let (body, tip) = flag([17 * layers, layers], 0.8, 0.1);
        let (h, weight) = (0.005, weight(&body));
        let mut state = body.at_rest(h);
        (0..600).for_each(|_| body.step(&mut state, h, &weight).unwrap());
        let u = moved(&body, &state.positions, tip) * 1e3;
        println!("CSM1, {layers} layers: ux {:.3} uy {:.3} (told -7.187 -66.10)", u[0], u[1]);
        assert!((u[1] / -66.10 - 1.0).abs() < 0.025 && (u[0] / -7.187 - 1.0).abs() < 0.04);
    }
}

#[test]
fn csm3_swing() {
    for (layers, h, dissipation, bar) in [(2, 0.005, 0.3, 0.04), (4, 0.005, 0.3, 0.015)] {
        let (body, tip) = flag([17 * layers, layers], 0.0, dissipation);
        let weight = weight(&body);
        let mut state = body.at_rest(h);
        // The velocity is half a step ahead: forces act for half a step before the first.
        state.velocities.iter_mut().zip(body.held()).for_each(|(v, held)| {
            if !held {
                v[1] = -0.5 * h * GRAVITY;
            }
        });
        let mut path = Vec::new();
        for _ in 0..(10.0 / h) as usize {
            body.step(&mut state, h, &weight).unwrap();
            path.push(moved(&body, &state.positions, tip) * 1e3);
        }
        let late = &path[path.len() / 2..];
        let range = |a: usize| {
            let (low, high) = late.iter().fold((f64::MAX, f64::MIN), |(l, g), u| (l.min(u[a]), g.max(u[a])));
            (0.5 * (low + high), 0.5 * (high - low))
        };
        let ((ux, dx), (uy, dy)) = (range(0), range(1));
        let rises: Vec<f64> = (1..late.len())
            .filter(|k| late[k - 1][1] < uy && late[*k][1] >= uy)
            .map(|k| k as f64 * h)
            .collect();
        let frequency = (rises.len() - 1) as f64 / (rises[rises.len() - 1] - rises[0]);
        println!(
            "CSM3, {layers} layers, h {h}, theta {dissipation}: ux {ux:.3}±{dx:.3} uy {uy:.3}±{dy:.3} f {frequency:.4} \
             (told -14.279±14.280 -63.541±65.094 1.0995)"
        );
        for (found, told) in [(ux, -14.279), (dx, 14.280), (uy, -63.541), (dy, 65.094), (frequency, 1.0995)] {
            assert!((found / told - 1.0).abs() < bar, "{layers} layers: {found} for {told}");
        }
    }
}
