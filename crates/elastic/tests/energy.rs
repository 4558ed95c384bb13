//! Energy and momenta over many steps.

mod lattice;

use lattice::{block, clamped, free, rubber};
use meniscus_elastic::{Elastic, Integrator, Weights};
use meniscus_numerics::Vector;

/// The highest frequency of a body at rest, rad/s, by power iteration.
fn highest<const D: usize>(body: &Elastic<D>) -> f64 {
    let stiffness = body.tangent(&body.mesh().positions, Weights { stiffness: 1.0, viscosity: 0.0 });
    let mut v = lattice::Noise(3).vectors::<D>(body.masses().len());
    let mut square = 0.0;
    for _ in 0..100 {
        let mut w = vec![Vector::zeros(); v.len()];
        stiffness.add_product(&v, &mut w);
        w.iter_mut().zip(body.masses()).for_each(|(w, m)| *w /= *m);
        let size = w.iter().map(|w| w.norm_squared()).sum::<f64>().sqrt();
        square = size;
        v = w.iter().map(|w| w / size).collect();
    }
    f64::sqrt(square)
}

fn swing<const D: usize>(cells: [usize; D], size: [f64; D], load: f64, nu: f64) {
    let (density, young) = (1.2, 1e8);
    for iterations in [0, 2] {
        for dissipation in [0.0, 0.05, 0.1, 0.2, 0.3, 0.5, 1.0] {
            let integrator = Integrator { dissipation, iterations };
            let body = Elastic::new(clamped(block::<D>(cells, size), density, rubber(young, nu), integrator))
                .unwrap();
            let top = highest(&body);
            let (length, thick) = (size[0], size[D - 1]);
            let gravity = load * young / (1.0 - nu * nu) * thick * thick / 12.0 / (density * length.powi(3));
            let weight: Vec<Vector<D>> = body
                .masses()
                .iter()
                .map(|m| Vector::from_fn(|r, _| if r == D - 1 { -gravity * m } else { 0.0 }))
                .collect();
            let total = |s: &meniscus_elastic::ElasticState<D>, h: f64| {
                let w: f64 = s
                    .positions
                    .iter()
                    .zip(&s.velocities)
                    .zip(&weight)
                    .zip(&body.mesh().positions)
                    .map(|(((x, v), w), r)| -w.dot(&(x + v * (0.5 * h) - r)))
                    .sum();
                body.energy(s, h) + w
            };
            let period = 1.0 / 18.433;
            let line: Vec<String> = [10.0, 30.0, 100.0, 300.0]
                .iter()
                .map(|ratio| {
                    let h = ratio / top;
                    let n = (4.0 * period / h) as usize;
                    if n > 3000 {
                        return String::from("-");
                    }
                    let mut state = body.at_rest(h);
                    let (mut most, mut scale) = (f64::NEG_INFINITY, 0.0f64);
                    let mut last = 0.0;
                    for _ in 0..n {
                        if body.step(&mut state, h, &weight).is_err() {
                            return String::from("FAIL");
                        }
                        last = total(&state, h);
                        most = most.max(last);
                        scale = scale.max(body.kinetic_energy(&state.velocities));
                    }
                    format!("{n}: {:.1e}/{:.1e}", most / scale, last / scale)
                })
                .collect();
            println!("{D}D load {load} it {iterations} theta {dissipation}: {line:?}");
        }
    }
}

#[test]
fn swinging() {
    swing::<2>([40, 2], [4.0, 0.2], 5.0, 0.3);
    swing::<2>([40, 2], [4.0, 0.2], 20.0, 0.3);
}

#[test]
fn a_free_body_keeps_its_momenta() {
    for iterations in [0, 4] {
        for dissipation in [0.0, 0.1] {
            let integrator = Integrator { dissipation, iterations };
            let body = Elastic::new(free(
                block::<3>([6, 4, 2], [0.6, 0.4, 0.2]),
                1000.0,
                rubber(1e5, 0.4),
                integrator,
            ))
            .unwrap();
            for h in [1e-3, 5e-3] {
                let mut state = body.at_rest(h);
                for (v, x) in state.velocities.iter_mut().zip(&state.positions) {
                    *v = Vector::from([
                        0.3 - 6.0 * x[1] + 3.0 * x[2] * x[0],
                        6.0 * x[0] + 10.0 * x[2] * x[1],
                        0.1 - 3.0 * x[0] * x[0],
                    ]);
                }
                let (p, l, e) =
                    (body.momentum(&state), body.angular_momentum(&state), body.energy(&state, h));
                let none = vec![Vector::zeros(); body.masses().len()];
                let n = (1.0 / h) as usize;
                for _ in 0..n {
                    body.step(&mut state, h, &none).unwrap();
                }
                let l2 = body.angular_momentum(&state);
                let size = l.iter().map(|l| l * l).sum::<f64>().sqrt();
                let drift = (0..3).map(|k| (l2[k] - l[k]).powi(2)).sum::<f64>().sqrt() / size;
                println!(
                    "it {iterations} theta {dissipation} h {h}: momentum {:.1e} angular {drift:.2e} energy {:.4}",
                    (body.momentum(&state) - p).norm() / p.norm(),
                    body.energy(&state, h) / e
                );
            }
        }
    }
}
