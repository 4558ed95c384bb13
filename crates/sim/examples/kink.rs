use meniscus_elastic::*;
use meniscus_numerics::grid::Grid;
use meniscus_numerics::mesh::VolumeMesh;
use meniscus_numerics::shape::Shape;
use meniscus_numerics::{Matrix, Vector};
use meniscus_sim::{Body, Model, Numerics, Simulation, Solid, Wall};
use std::sync::Arc;
type V = Vector<2>;
fn arg(k: usize, d: f64) -> f64 { std::env::args().nth(k).and_then(|s| s.parse().ok()).unwrap_or(d) }
fn main() {
    // theta, cells per cm, thickness in cells, place of the drop (cm), clamped, t_end, poisson, nu (m2/s), dissipation-damping, edge in dx, tilt degrees
    let (theta, per, thick_cells, place, clamped, t_end, poisson, nu, damping, edge) =
        (arg(1, 90.0), arg(2, 32.0), arg(3, 3.0), arg(4, 0.0), arg(5, 0.0), arg(6, 0.3), arg(7, 0.3), arg(8, 1e-4), arg(9, 0.3), arg(10, 1.0 / 1.5));
    let dx = 1e-2 / per;
    let (gamma, b) = (0.1, arg(12, 1e-5));
    let area: f64 = 0.2e-4;
    let t = theta.to_radians();
    let radius = (area / (t - t.sin() * t.cos())).sqrt();
    let a = radius * t.sin();
    let length = 2e-2;
    let thick = thick_cells * dx;
    let young = b * 12.0 * (1.0 - poisson * poisson) / thick.powi(3);
    let tilt = arg(11, 0.0).to_radians();
    let middle = V::new(1.2e-2 + 0.13 * dx, 0.6e-2 + 0.3 * dx);
    let rotation = Matrix::<2>::new(tilt.cos(), -tilt.sin(), tilt.sin(), tilt.cos());
    let half = V::new(0.5 * length, 0.5 * thick);
    let mesh = VolumeMesh::of_box(&middle, &half, &rotation, edge * dx).unwrap();
    let local = |x: &V| rotation.transpose() * (x - middle);
    let anchors = if clamped > 0.0 { vec![Anchor::within(&mesh, |x: &V| local(x)[0] < -half[0] + 1e-9)] } else { Vec::new() };
    println!("{} vertices, {} elements, thick {:.3} mm, E {young:.3e}", mesh.positions.len(), mesh.simplices.len(), thick * 1e3);
    let rest = mesh.positions.clone();
    let law = Law::NeoHookean { young, poisson, smoothing: Smoothing::default() };
    let elastic = Elastic::new(Description { mesh, density: 1000.0, law, damping_ratio: damping, anchors, integrator: Integrator { dissipation: arg(13, 0.1), ..Integrator::default() } }).unwrap();
    let shape = Shape::Box { center: middle, half_size: half, rotation };
    let rigid = arg(15, 0.0) > 0.0;
    let mut solid = Solid::new(shape, if rigid { meniscus_sim::Motion::Free } else { meniscus_sim::Motion::Soft(Arc::new(elastic)) }, 1000.0);
    solid.cosine = t.cos();
    let model = Model {
        grid: Grid::<2>::new([(2.4 * per) as usize, (1.4 * per) as usize], dx), walls: [[Wall::Slip; 2]; 2], density: 1000.0, kinematic_viscosity: nu,
        surface_tension: gamma, gravity: V::zeros(), solids: vec![solid], numerics: Numerics { capillary_step: arg(14, 5.0), ..Numerics::default() },
    };
    let up = rotation.column(1).into_owned();
    let center = middle + rotation * V::new(place * 1e-2, half[1] - radius * t.cos());
    let distance = move |x: &V| ((x - center).norm() - radius).max(-(x - middle).dot(&up));
    let mut sim = Simulation::new(model, &[Body { distance: &distance, velocity: V::zeros() }]);
    // mean slope over a stretch of the plate, from a fit
    let slope = |sim: &Simulation<2>, from: f64, to: f64| {
        let s = &sim.state.solids[0].soft.as_ref().unwrap().body;
        let pick: Vec<V> = rest.iter().zip(&s.positions).filter(|(r, _)| { let u = local(r)[0] / length; u >= from - 1e-9 && u <= to + 1e-9 }).map(|(_, x)| rotation.transpose() * (x - middle)).collect();
        let n = pick.len() as f64;
        let m: V = pick.iter().sum::<V>() / n;
        let (mut sxx, mut sxy) = (0.0, 0.0);
        for p in &pick { let d = p - m; sxx += d[0] * d[0]; sxy += d[0] * d[1]; }
        ((sxy / sxx).atan(), m)
    };
    let exact = 2.0 / 3.0 * gamma * t.sin() * a * a / b;
    println!("a {:.3} mm = {:.1} dx, exact kink {exact:.5}", a * 1e3, a / dx);
    let (mut next, mut steps, mut iterations) = (0.0, 0, 0);
    while sim.state.time < t_end {
        let r = match sim.step(t_end - sim.state.time, &mut |_| ()) { Ok(r) => r, Err(e) => { println!("FAIL {e}"); break } };
        steps += 1; iterations += r.iterations;
        if rigid { if sim.state.time >= next { next = sim.state.time + t_end / 15.0; let st = &sim.state.solids[0]; println!("t {:.4} turn {:+.5} centre {:+.4} {:+.4} dx u {:.1e} it {} L solid {:+.2e} pulled {:+.2e} {:+.2e}", sim.state.time, st.rotation[(1, 0)], (st.center - middle)[0] / dx, (st.center - middle)[1] / dx, r.ledger.max_speed, r.iterations, 0.0, st.pulled[0], st.pulled[1]); } continue; }
        if sim.state.time >= next || steps < 2 {
            next = sim.state.time + t_end / 15.0;
            let (l, ml) = slope(&sim, -0.5, -0.3); let (rr, mr) = slope(&sim, 0.35, 0.5);
            let (_, mm) = slope(&sim, -0.02, 0.02);
            let st = &sim.state.solids[0];
            let e = match &sim.model.solids[0].motion { meniscus_sim::Motion::Soft(e) => e.clone(), _ => panic!() };
            let b = &st.soft.as_ref().unwrap().body;
            let (l_liquid, l_solid) = (r.ledger.angular_momentum[2], e.angular_momentum(b)[2]);
            println!("   L liquid {l_liquid:+.3e} solid {l_solid:+.3e} sum {:+.3e} (scale {:.1e})", l_liquid + l_solid, gamma * a * sim.state.time);
            println!("t {:.4} left {l:+.5} right {rr:+.5} kink {:+.5} ({:+.2} %) | rise l {:.4} r {:.4} mm | pulled {:+.2e} {:+.2e} pressed {:+.2e} {:+.2e} | max u {:.1e} el {:.3e} it {} dt {:.1e}", sim.state.time, rr - l, ((rr - l) / exact - 1.0) * 100.0, (ml[1] - mm[1]) * 1e3, (mr[1] - mm[1]) * 1e3, st.pulled[0], st.pulled[1], st.pressed[0], st.pressed[1], r.ledger.max_speed, r.ledger.elastic_energy, r.iterations, r.dt);
        }
    }
    println!("steps {steps} mean iterations {:.1}", iterations as f64 / steps as f64);
}
