//! Energy and momenta over many steps.

use crate::lattice::{Noise, clamped, free, quadratic, rubber};
use meniscus_elastic::{Anchor, ConstitutiveLaw, Elastic, ElasticState, ElementOrder, Lame, TangentWeights};
use meniscus_numerics::mesh::{Simplex, VolumeMesh};
use meniscus_numerics::{Matrix, Vector};

/// The highest frequency of a body at rest, rad/s, by power iteration.
fn highest<const D: usize>(body: &Elastic<D>) -> f64 {
    let stiffness = body.tangent(
        &body.rest_mesh().positions,
        TangentWeights { stiffness: 1.0, project_psd: true, viscosity: 0.0 },
    );
    let mut v = Noise(3).vectors::<D>(body.masses().len());
    let mut square = 0.0;
    for _ in 0..100 {
        let mut w = vec![Vector::zeros(); v.len()];
        stiffness.add_product(&v, &mut w);
        w.iter_mut().zip(body.masses()).for_each(|(w, m)| *w /= *m);
        square = w.iter().map(|w| w.norm_squared()).sum::<f64>().sqrt();
        v = w.iter().map(|w| w / square).collect();
    }
    f64::sqrt(square)
}

/// What a run did: the largest and the last energy over the largest kinetic one, and the largest turn in a step.
#[derive(Debug)]
struct Swing {
    steps: usize,
    most: f64,
    last: f64,
    turn: f64,
}

/// A cantilever of two layers falls from the horizontal under `load = q L³/EI` and swings for four periods of its lowest
/// mode; steps are `ratio` over the highest frequency.
fn swing(load: f64, ratio: f64) -> Swing {
    let (length, thick, density, young, poisson) = (4.0, 0.2, 1.2, 1e8, 0.3);
    let mesh = quadratic::<2>([40, 2], [length, thick]);
    let body = Elastic::new(clamped(mesh, density, rubber(young, poisson))).unwrap();
    let gravity =
        load * young / (1.0 - poisson * poisson) * thick * thick / 12.0 / (density * f64::powi(length, 3));
    let weight: Vec<Vector<2>> = body.masses().iter().map(|m| Vector::from([0.0, -gravity * m])).collect();
    let h = ratio / highest(&body);
    let total = |s: &ElasticState<2>| {
        let lifted = |k: usize| {
            -weight[k].dot(&(s.positions[k] + s.velocities[k] * (0.5 * h) - body.rest_mesh().positions[k]))
        };
        body.energy(s, h) + (0..weight.len()).map(lifted).sum::<f64>()
    };
    let mut state = body.rest_state(h);
    let (mut most, mut scale, mut turn) = (f64::NEG_INFINITY, 0.0f64, 0.0f64);
    let steps = (4.0 / 18.433 / h) as usize;
    for _ in 0..steps {
        body.step(&mut state, h, &weight).unwrap();
        turn = turn.max(h * body.max_deformation_rate(&state.velocities));
        most = most.max(total(&state));
        scale = scale.max(body.kinetic_energy(&state.velocities));
    }
    Swing { steps, most: most / scale, last: total(&state) / scale, turn }
}

/// Two bodies as one solid are damped as each by itself is, whether the second is held or not.
fn pieces<const D: usize>() {
    let one = quadratic::<D>([4; D], [1.0; D]);
    let mut two = one.clone();
    let count = one.positions.len() as u32;
    two.positions.extend(one.positions.iter().map(|x| x + Vector::repeat(5.0)));
    let moved = |s: &Simplex<D>| Simplex { root: s.root + count, others: s.others.map(|v| v + count) };
    two.simplices.extend(one.simplices.iter().map(moved));
    let time = |mesh: &VolumeMesh<D>, held: bool| {
        let mut description = free(mesh.clone(), 1.0, rubber(1e4, 0.3));
        description.damping_ratio = 0.1;
        if held {
            description.anchors = vec![Anchor::within(mesh, |x| x[0] > 5.9)];
        }
        Elastic::new(description).unwrap().damping_time()
    };
    let alone = time(&one, false);
    assert!(alone > 0.0 && (time(&two, false) / alone - 1.0).abs() < 1e-2);
    // The clamped one is the slower.
    let clamped = time(&two, true);
    assert!(clamped > alone && clamped < 10.0 * alone, "{clamped} {alone}");
}

#[test]
fn pieces_are_damped_each_by_itself() {
    pieces::<2>();
    pieces::<3>();
}

#[test]
fn energy_is_kept_in_steps_that_resolve_nothing() {
    for (load, ratio) in [(5.0, 100.0), (20.0, 30.0)] {
        let done = swing(load, ratio);
        println!("load {load}, h w_max = {ratio}: {done:?}");
        assert!(done.steps > 500 && done.turn < 0.8);
        assert!(done.most < 1e-9 && done.last.abs() < 1e-9, "{done:?}");
    }
}

/// A small oscillation over many steps.
#[test]
fn small_vibrations_keep_their_energy() {
    let body = Elastic::new(clamped(quadratic::<2>([20, 2], [2.0, 0.2]), 1.2, rubber(1e8, 0.3))).unwrap();
    for ratio in [1.0, 30.0] {
        let h = ratio / highest(&body);
        let mut state = body.rest_state(h);
        let moving = |x: &Vector<2>| Vector::from([0.0, 1e-5 * x[0] * x[0] * (1.0 - x[0])]);
        state.velocities = state.positions.iter().map(moving).collect();
        let before = body.energy(&state, h);
        let none = vec![Vector::zeros(); state.positions.len()];
        (0..500).for_each(|_| body.step(&mut state, h, &none).unwrap());
        let after = body.energy(&state, h);
        println!("h w_max = {ratio}: energy {:.2e}", after / before - 1.0);
        assert!((after / before - 1.0).abs() < 1e-5);
    }
}

#[test]
fn a_free_body_keeps_its_momenta() {
    let mesh = quadratic::<3>([6, 4, 2], [0.6, 0.4, 0.2]);
    let mut description = free(mesh, 1000.0, rubber(1e5, 0.4));
    description.damping_ratio = 0.02;
    let body = Elastic::new(description).unwrap();
    for h in [1e-3, 5e-3] {
        let mut state = body.rest_state(h);
        for (v, x) in state.velocities.iter_mut().zip(&state.positions) {
            let bend = 10.0 * x[2] * x[1] - 3.0 * x[0] * x[0];
            *v = Vector::from([0.3 - 6.0 * x[1], 6.0 * x[0] + bend, 0.1 - bend]);
        }
        let (p, l, e) = (body.momentum(&state), body.angular_momentum(&state), body.energy(&state, h));
        let none = vec![Vector::zeros(); body.masses().len()];
        (0..(1.0 / h) as usize).for_each(|_| body.step(&mut state, h, &none).unwrap());
        let late = body.angular_momentum(&state);
        let size = l.iter().map(|l| l * l).sum::<f64>().sqrt();
        let drift = (0..3).map(|k| (late[k] - l[k]).powi(2)).sum::<f64>().sqrt() / size;
        let lost = (body.momentum(&state) - p).norm() / p.norm();
        let energy = body.energy(&state, h) / e;
        println!("h {h}: momentum {lost:.1e}, angular {drift:.1e}, energy {energy:.4}");
        assert!(lost < 1e-13 && energy < 1.0 && drift < 1e-12);
    }
}

/// The same bits on one thread and on several.
#[test]
fn threads_do_not_matter() {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mesh = quadratic::<3>([12, 6, 4], [1.2, 0.6, 0.4]);
            let body = Elastic::new(clamped(mesh, 1000.0, rubber(1e5, 0.4))).unwrap();
            let weight: Vec<Vector<3>> =
                body.masses().iter().map(|m| Vector::from([0.0, 0.0, -10.0 * m])).collect();
            let mut state = body.rest_state(0.01);
            (0..5).for_each(|_| body.step(&mut state, 0.01, &weight).unwrap());
            state
        })
    };
    assert_eq!(run(1), run(3));
}

/// Hooke's law for small strains, turned with the solid; the Green strain does not turn.
fn stresses_are_hookes<const D: usize>(law: ConstitutiveLaw, lame: Lame) {
    let body = Elastic::new(free(quadratic::<D>([2; D], [1.0; D]), 1.0, law)).unwrap();
    let small = Matrix::<D>::from_fn(|r, c| 1e-5 * (1.0 + (r + c) as f64 - if r == c { 3.0 } else { 0.0 }));
    let (sin, cos) = 0.7f64.sin_cos();
    let mut turn = Matrix::<D>::identity();
    [(0, 0, cos), (0, 1, -sin), (1, 0, sin), (1, 1, cos)].into_iter().for_each(|(r, c, x)| turn[(r, c)] = x);
    let f = turn * (Matrix::identity() + small);
    let x: Vec<Vector<D>> = body.rest_mesh().positions.iter().map(|x| f * x).collect();
    let hooke = Matrix::identity() * (lame.lambda * small.trace()) + small * (2.0 * lame.mu);
    let told = turn * hooke * turn.transpose();
    for stress in body.cauchy_stresses(&x).unwrap() {
        assert!((stress - told).norm() < 1e-3 * told.norm(), "{stress} against {told}");
    }
    for strain in body.green_strains(&x) {
        assert!((strain - small).norm() < 1e-3 * small.norm(), "{strain} against {small}");
    }
    assert!(body.cauchy_stresses(&body.rest_mesh().positions).unwrap().iter().all(|s| s.norm() < 1e-9));
}

#[test]
fn stresses_of_small_strains_are_hookes() {
    let lame = Lame::new(2.0, 0.3);
    for order in [ElementOrder::Linear, ElementOrder::Quadratic] {
        for law in
            [ConstitutiveLaw::neo_hookean(2.0, 0.3, order), ConstitutiveLaw::corotated(2.0, 0.3, order)]
        {
            stresses_are_hookes::<2>(law, lame);
            stresses_are_hookes::<3>(law, lame);
        }
    }
    let springs = ConstitutiveLaw::Springs { stiffness: 1.0 };
    let body = Elastic::new(free(quadratic::<2>([2; 2], [1.0; 2]), 1.0, springs)).unwrap();
    assert!(body.cauchy_stresses(&body.rest_mesh().positions).is_none());
}
