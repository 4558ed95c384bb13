//! Cantilevers against beam theory, 2D (plane strain) and 3D.

use crate::lattice::{clamped, quadratic, rubber};
use meniscus_elastic::{ConstitutiveLaw, Elastic, ElasticState, ElementOrder, SurfaceTension, lowest_modes};
use meniscus_numerics::Vector;

/// The wave numbers of a clamped beam over its length.
const WAVES: [f64; 3] = [1.875104069, 4.694091133, 7.854757438];
const LENGTH: f64 = 4.0;
const THICK: f64 = 0.2;
const DENSITY: f64 = 1.2;
const YOUNG: f64 = 1e8;

/// Frequencies of Timoshenko's beam, rad/s: those of the thin beam with the corrections for rotary inertia and shear to
/// first order (Timoshenko 1922), `stiffness` the modulus of bending, Pa.
fn timoshenko(stiffness: f64, poisson: f64) -> [f64; 3] {
    let shear = YOUNG / (2.0 * (1.0 + poisson)) * 10.0 * (1.0 + poisson) / (12.0 + 11.0 * poisson);
    WAVES.map(|k| {
        let thin = (k / LENGTH).powi(2) * (stiffness * THICK * THICK / 12.0 / DENSITY).sqrt();
        // The effective wave number of a clamped mode's bends, from the mean of its squared slope.
        let slope = [4.6478, 32.417, 77.299][WAVES.iter().position(|w| *w == k).unwrap()];
        let ratio = slope * THICK * THICK / 12.0 / LENGTH.powi(2);
        thin / (1.0 + ratio * (1.0 + stiffness / shear)).sqrt()
    })
}

fn frequencies<const D: usize>(cells: [usize; D], size: [f64; D], poisson: f64) -> Vec<f64> {
    let (mesh, law) = (quadratic::<D>(cells, size), rubber(YOUNG, poisson));
    let body = Elastic::new(clamped(mesh, DENSITY, law)).unwrap();
    lowest_modes(&body, 3 + 5 * (D - 2)).unwrap().iter().map(|m| m.frequency).collect()
}

#[test]
fn frequencies_of_a_thin_beam() {
    for poisson in [0.0, 0.3, 0.45] {
        let told = timoshenko(YOUNG / (1.0 - poisson * poisson), poisson);
        for layers in [2, 4, 6] {
            let found = frequencies([20 * layers, layers], [LENGTH, THICK], poisson);
            let ratios = std::array::from_fn::<f64, 3, _>(|k| found[k] / told[k]);
            println!("nu {poisson}, {layers} layers: {ratios:.4?}");
            assert!(ratios.iter().all(|r| (r - 1.0).abs() < 0.015), "nu {poisson}: {ratios:?}");
        }
    }
}

#[test]
fn frequencies_of_a_bar() {
    // As wide as it is high: the modulus of bending is Young's; every mode is there twice.
    let told = timoshenko(YOUNG, 0.3);
    for layers in [2, 4] {
        let size = [LENGTH, THICK, THICK];
        let found = frequencies([20 * layers, layers, layers], size, 0.3);
        let ratios = [0, 1, 2, 3].map(|k| found[k] / told[k / 2]);
        println!("bar of {layers} layers: {ratios:.4?}");
        assert!(ratios.iter().all(|r| (r - 1.0).abs() < 0.03));
    }
}

/// Drop and place of the end's middle relative to the length, at rest under gravity `g` along the last axis.
fn tip<const D: usize>(body: &Elastic<D>, gravity: f64, step: f64) -> (f64, f64) {
    let weight = |m: &f64| Vector::from_fn(|r, _| if r == D - 1 { -gravity * m } else { 0.0 });
    let weight: Vec<Vector<D>> = body.masses().iter().map(weight).collect();
    let mut state = body.rest_state(step);
    for _ in 0..2000 {
        body.step(&mut state, step, &weight).unwrap();
        if body.kinetic_energy(&state.velocities) < 1e-12 * body.elastic_energy(&state.positions)
            && state.time > 0.1
        {
            break;
        }
    }
    let rest = &body.rest_mesh().positions;
    let end: Vec<usize> = (0..rest.len()).filter(|v| rest[*v][0] > LENGTH - 1e-9).collect();
    let mean = |a: usize, x: &[Vector<D>]| end.iter().map(|v| x[*v][a]).sum::<f64>() / end.len() as f64;
    ((mean(D - 1, rest) - mean(D - 1, &state.positions)) / LENGTH, mean(0, &state.positions) / LENGTH)
}

fn damped<const D: usize>(cells: [usize; D], size: [f64; D], law: ConstitutiveLaw) -> Elastic<D> {
    let mut description = clamped(quadratic::<D>(cells, size), DENSITY, law);
    description.damping_ratio = 0.7;
    Elastic::new(description).unwrap()
}

#[test]
fn small_deflection() {
    // Under gravity, q L⁴/8EI by the theory of thin beams; shear adds a thousandth.
    let gravity = 0.0981;
    for poisson in [0.0, 0.3] {
        let told =
            1.5 * DENSITY * gravity * LENGTH.powi(4) * (1.0 - poisson * poisson) / (YOUNG * THICK * THICK);
        for layers in [2, 4] {
            let (drop, _) =
                tip(&damped([20 * layers, layers], [LENGTH, THICK], rubber(YOUNG, poisson)), gravity, 1e-3);
            println!("nu {poisson}, {layers} layers: {:.4}", drop * LENGTH / told);
            assert!((drop * LENGTH / told - 1.0).abs() < 0.01);
        }
    }
}

#[test]
fn large_deflection() {
    // Tip's drop and place for q L³/EI, by the elastica.
    let told = [
        (1.0, 0.123471, 0.991246),
        (2.0, 0.238507, 0.966893),
        (5.0, 0.495905, 0.846657),
        (10.0, 0.700200, 0.656354),
    ];
    let (poisson_ratio, order) = (0.3, ElementOrder::Quadratic);
    let plate = YOUNG / (1.0 - poisson_ratio * poisson_ratio) * THICK.powi(3) / 12.0;
    let laws = [
        ConstitutiveLaw::neo_hookean(YOUNG, poisson_ratio, order),
        ConstitutiveLaw::corotated(YOUNG, poisson_ratio, order),
    ];
    for law in laws {
        for layers in [2, 4] {
            let body = damped([20 * layers, layers], [LENGTH, THICK], law);
            for (load, drop, along) in told {
                let (d, a) = tip(&body, load * plate / (DENSITY * THICK * LENGTH.powi(3)), 1e-3);
                println!("{layers} layers, load {load}: drop {:.4}, place {:.4}", d / drop, a / along);
                assert!((d / drop - 1.0).abs() < 0.01 && (a / along - 1.0).abs() < 0.01);
            }
        }
    }
}

#[test]
fn large_deflection_in_3d() {
    // A bar: Young's modulus itself.
    let rigid = YOUNG * THICK.powi(3) / 12.0;
    let body = damped([40, 2, 2], [LENGTH, THICK, THICK], rubber(YOUNG, 0.3));
    let (drop, along) = tip(&body, 5.0 * rigid / (DENSITY * THICK * LENGTH.powi(3)), 1e-3);
    println!("bar of 2 layers, load 5: drop {:.4}, place {:.4}", drop / 0.495905, along / 0.846657);
    assert!((drop / 0.495905 - 1.0).abs() < 0.03 && (along / 0.846657 - 1.0).abs() < 0.02);
}

/// A thin beam of bending stiffness `B`, N m, whose two surfaces have the tension `γ = 3 B/2 L²` each, N/m.
fn tense(damping_ratio: f64) -> Elastic<2> {
    let bending = YOUNG / (1.0 - 0.3 * 0.3) * THICK.powi(3) / 12.0;
    let mesh = quadratic([40, 2], [LENGTH, THICK]);
    let tension = SurfaceTension::new(&mesh, 1.5 * bending / LENGTH.powi(2));
    let mut description = clamped(mesh, DENSITY, rubber(YOUNG, 0.3));
    description.damping_ratio = damping_ratio;
    Elastic::with_terms(description, vec![Box::new(tension)]).unwrap()
}

#[test]
fn surface_tension_changes_no_frequency() {
    // Gurtin, Markenscoff & Thurston 1976. The tension of a taut string, which the stress within does not balance, would raise the lowest
    // frequency by more than a third.
    let mode = lowest_modes(&tense(0.0), 1).unwrap()[0].frequency;
    let without = frequencies([40, 2], [LENGTH, THICK], 0.3)[0];
    assert!((mode / without - 1.0).abs() < 1e-6, "{}", mode / without);
    // The beam comes to rest under a load, then swings freely about its relaxed shape.
    let (slow, free) = (tense(0.7), tense(0.0));
    let load: Vec<Vector<2>> = free.masses().iter().map(|m| Vector::<2>::new(0.0, -0.1 * m)).collect();
    let none = vec![Vector::zeros(); load.len()];
    let period = std::f64::consts::TAU / mode;
    let mut state = slow.rest_state(period / 20.0);
    (0..400).for_each(|_| slow.step(&mut state, period / 20.0, &load).unwrap());
    let end =
        (0..load.len()).max_by(|a, b| state.positions[*a][0].total_cmp(&state.positions[*b][0])).unwrap();
    let swing = |state: &mut ElasticState<2>| {
        free.step(state, period / 200.0, &none).unwrap();
        state.positions[end][1]
    };
    let heights: Vec<f64> = (0..2000).map(|_| swing(&mut state)).collect();
    let middle = 0.5
        * heights.iter().fold([f64::MAX, f64::MIN], |[l, h], y| [l.min(*y), h.max(*y)]).iter().sum::<f64>();
    let rises: Vec<f64> = (1..heights.len())
        .filter(|k| heights[k - 1] < middle && heights[*k] >= middle)
        .map(|k| k as f64 - (heights[k] - middle) / (heights[k] - heights[k - 1]))
        .collect();
    let steps = (rises[rises.len() - 1] - rises[0]) / (rises.len() - 1) as f64;
    println!("period of the swing over that of the mode: {}", steps / 200.0);
    // The clamp holds the end as it was before it relaxed, which is felt over a thickness of it, a twentieth of the length; 0.0015 found.
    assert!((steps / 200.0 - 1.0).abs() < 0.005);
}
