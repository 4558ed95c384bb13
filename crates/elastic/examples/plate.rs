//! Times a step's parts for a square plate: `cargo run --release --example plate -- 96 2`.

#[path = "../tests/lattice/mod.rs"]
mod lattice;

use lattice::{block, clamped};
use meniscus_elastic::{Elastic, Integrator, Law, Smoothing, Weights, lowest_modes};
use meniscus_numerics::Vector;
use std::time::Instant;

fn main() {
    let mut arguments = std::env::args().skip(1).filter_map(|a| a.parse::<usize>().ok());
    let (wide, high) = (arguments.next().unwrap_or(96), arguments.next().unwrap_or(2));
    for smoothing in [Smoothing::None, Smoothing::Cells, Smoothing::Edges] {
        measure(wide, high, smoothing);
    }
}

fn measure(wide: usize, high: usize, smoothing: Smoothing) {
    let cell = 1e-3;
    let mesh = block::<3>([wide, wide, high], [wide, wide, high].map(|n| n as f64 * cell));
    let law = Law::NeoHookean { young: 1e6, poisson: 0.4, smoothing };
    let clock = Instant::now();
    let body = match Elastic::new(clamped(mesh, 1000.0, law, Integrator::default())) {
        Ok(body) => body,
        Err(error) => return println!("{error}"),
    };
    let set_up = clock.elapsed().as_secs_f64();
    let h = 1e-3;
    let mut state = body.at_rest(h);
    for (v, x) in state.velocities.iter_mut().zip(&body.mesh().positions) {
        *v = Vector::from([0.0, 0.0, 10.0 * x[0] * x[0] + x[1]]);
    }
    body.advance_positions(&mut state, h);
    let clock = Instant::now();
    let tangent = body.tangent(&state.positions, Weights { stiffness: 1.0, viscosity: 1.0 });
    let assembly = clock.elapsed().as_secs_f64();
    drop(tangent);
    let clock = Instant::now();
    let Ok(system) = body.system(&state.positions, h, &[]) else { return println!("not definite") };
    let factor = clock.elapsed().as_secs_f64() - assembly;
    let clock = Instant::now();
    let forces = body.forces(&state.positions);
    let pull = clock.elapsed().as_secs_f64();
    let mut b: Vec<f64> = forces.iter().flat_map(|f| f.iter().copied()).collect();
    let clock = Instant::now();
    (0..10).for_each(|_| system.solve(&mut b));
    let solve = clock.elapsed().as_secs_f64() / 10.0;
    let clock = Instant::now();
    let lowest = lowest_modes(&body, 1).ok().and_then(|m| m.first().map(|m| m.frequency));
    println!(
        "{wide} x {wide} x {high} {smoothing:?}: {} vertices, {:.1} M entries; set up {set_up:.2} s, assembly {assembly:.2} s, \
         factor {factor:.2} s, forces {pull:.3} s, solve {solve:.4} s, lowest mode {lowest:.1?} rad/s in {:.1} s",
        body.masses().len(),
        body.factor_entries() as f64 / 1e6,
        clock.elapsed().as_secs_f64()
    );
}
