//! Energies, forces and tangents fit together, in 2D and 3D.

use crate::lattice::{Noise, quadratic};
use meniscus_elastic::{
    CRUSHED_VOLUME_RATIO, ConstitutiveLaw, Continuum, Corotated, DiscreteGradientTerm, Elastic,
    ElasticSpecification, ElasticState, ElementOrder, ForceTerm, IncrementalPotential, InversionBarrier,
    Lame, NeoHookean, Springs, SurfaceTension, TangentWeights,
};
use meniscus_numerics::mesh::VolumeMesh;
use meniscus_numerics::{Vector, rotation_planes};

const BOTH: [ElementOrder; 2] = [ElementOrder::Linear, ElementOrder::Quadratic];

fn terms<const D: usize>() -> Vec<Box<dyn DiscreteGradientTerm<D>>> {
    let mesh = quadratic::<D>([2; D], [1.0; D]);
    let lame = Lame::new(3.0, 0.35);
    let mut terms: Vec<Box<dyn DiscreteGradientTerm<D>>> = vec![Box::new(Springs::new(&mesh, 2.0))];
    for order in BOTH {
        terms.push(Box::new(Continuum::new(&mesh, NeoHookean, lame, order).unwrap()));
        terms.push(Box::new(Continuum::new(&mesh, Corotated, lame, order).unwrap()));
    }
    terms
}

/// These, and the tension of the surface, whose positive tangent is but that against heights over it.
fn all_terms<const D: usize>() -> Vec<Box<dyn DiscreteGradientTerm<D>>> {
    let mut terms = terms::<D>();
    let mesh = quadratic::<D>([2; D], [1.0; D]);
    terms.push(Box::new(SurfaceTension::new(&mesh, 0.7)));
    terms
}

fn dot<const D: usize>(a: &[Vector<D>], b: &[Vector<D>]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(b)).sum()
}

fn moved<const D: usize>(x: &[Vector<D>], along: &[Vector<D>], by: f64) -> Vec<Vector<D>> {
    x.iter().zip(along).map(|(x, a)| x + a * by).collect()
}

/// A body of a term only (and of one so soft that it does not count).
fn body<const D: usize>(term: Box<dyn DiscreteGradientTerm<D>>) -> Elastic<D> {
    let law = ConstitutiveLaw::corotated(1e-200, 0.0, ElementOrder::Quadratic);
    let mesh = quadratic::<D>([2; D], [1.0; D]);
    let description =
        ElasticSpecification { mesh, density: 1.0, law, damping_ratio: 0.0, anchors: Vec::new() };
    Elastic::with_terms(description, vec![term]).unwrap()
}

fn forces<const D: usize>(term: &dyn DiscreteGradientTerm<D>, x: &[Vector<D>]) -> Vec<Vector<D>> {
    let mut forces = vec![Vector::zeros(); x.len()];
    term.add_forces(x, &mut forces);
    forces
}

fn forces_are_the_slope_of_the_energy<const D: usize>() {
    let rest = quadratic::<D>([2; D], [1.0; D]).positions;
    for (k, term) in all_terms::<D>().iter().enumerate() {
        for size in [0.0, 0.05, 0.1, 0.6] {
            let mut noise = Noise(k as u64);
            let x = moved(&rest, &noise.vectors(rest.len()), size);
            if size > 0.1 && term.energy(&x) == f64::INFINITY {
                continue;
            }
            let along = noise.vectors(rest.len());
            let step = 1e-5;
            let slope = (term.energy(&moved(&x, &along, step)) - term.energy(&moved(&x, &along, -step)))
                / (2.0 * step);
            let f = forces(term.as_ref(), &x);
            assert!((slope + dot(&f, &along)).abs() < 1e-7 * (1.0 + slope.abs()), "{D}D term {k} at {size}");
            let total: Vector<D> = f.iter().sum();
            let largest = f.iter().map(|f| f.norm()).fold(0.0, f64::max);
            assert!(total.norm() < 1e-13 * (1.0 + largest));
            for (a, b, _) in rotation_planes::<D>() {
                let torque: f64 = x.iter().zip(&f).map(|(x, f)| x[*a] * f[*b] - x[*b] * f[*a]).sum();
                assert!(torque.abs() < 1e-12 * (1.0 + largest), "{D}D term {k}: torque {torque:e}");
            }
        }
    }
}

fn tangents_are_slopes_of_forces<const D: usize>() {
    // Stretched, so that nothing of the stiffness is negative; and as it comes.
    let cases = [(1.05, 0.003, true, terms::<D>()), (1.0, 0.1, false, all_terms::<D>())];
    for (grown, size, project_psd, terms) in cases {
        let rest = quadratic::<D>([2; D], [1.0; D]).positions;
        for (k, term) in terms.into_iter().enumerate() {
            let body = body(term);
            let mut noise = Noise(k as u64);
            let grown: Vec<Vector<D>> = rest.iter().map(|x| x * grown).collect();
            let x = moved(&grown, &noise.vectors(rest.len()), size);
            let along = noise.vectors(rest.len());
            let mut product = vec![Vector::zeros(); x.len()];
            let weights = TangentWeights { stiffness: 1.0, project_psd, viscosity: 0.0 };
            body.tangent(&x, weights).add_product(&along, &mut product);
            let step = 1e-5;
            let (up, down) = (body.forces(&moved(&x, &along, step)), body.forces(&moved(&x, &along, -step)));
            for v in 0..x.len() {
                let slope = (down[v] - up[v]) / (2.0 * step);
                let error = (slope - product[v]).norm();
                assert!(error < 1e-7 * (1.0 + slope.norm()), "{D}D term {k}: {slope} {}", product[v]);
            }
        }
    }
}

fn tangents_are_positive_and_rates_of_strain_keep_momenta<const D: usize>() {
    let rest = quadratic::<D>([2; D], [1.0; D]).positions;
    for (k, term) in all_terms::<D>().into_iter().enumerate() {
        let mut noise = Noise(k as u64);
        let x = moved(&rest, &noise.vectors(rest.len()), 0.12);
        let (mut viscous, v) = (vec![Vector::zeros(); x.len()], noise.vectors(x.len()));
        term.add_viscous_forces(&x, &v, 2.0, &mut viscous);
        let body = body(term);
        let product = |weights, v: &[Vector<D>]| {
            let mut product = vec![Vector::zeros(); x.len()];
            body.tangent(&x, weights).add_product(v, &mut product);
            product
        };
        for _ in 0..20 {
            let along = noise.vectors(x.len());
            assert!(
                dot(
                    &along,
                    &product(TangentWeights { stiffness: 1.0, project_psd: true, viscosity: 0.0 }, &along)
                ) > 0.0
            );
        }
        // Viscous forces are what the tangent says, and vanish for rigid motions of the strained body.
        let told = product(TangentWeights { stiffness: 0.0, project_psd: true, viscosity: 2.0 }, &v);
        assert!(told.iter().zip(&viscous).all(|(a, b)| (a + b).norm() < 1e-11), "{D}D term {k}");
        for (a, b, _) in rotation_planes::<D>() {
            let turn = |x: &Vector<D>| {
                Vector::from_fn(|r, _| {
                    if r == *a {
                        -x[*b]
                    } else if r == *b {
                        x[*a]
                    } else {
                        0.0
                    }
                })
            };
            let turning: Vec<Vector<D>> = x.iter().map(turn).collect();
            let felt =
                product(TangentWeights { stiffness: 0.0, project_psd: true, viscosity: 1.0 }, &turning);
            assert!(felt.iter().all(|f| f.norm() < 1e-12), "{D}D term {k}");
        }
    }
}

/// A block of which one extent is pressed to a part of itself, with some noise.
fn crushed<const D: usize>(part: f64, noise: &mut Noise) -> Vec<Vector<D>> {
    let rest = quadratic::<D>([2; D], [1.0; D]).positions;
    let pressed: Vec<Vector<D>> =
        rest.iter().map(|x| Vector::from_fn(|a, _| if a == 0 { part * x[a] } else { x[a] })).collect();
    moved(&pressed, &noise.vectors(rest.len()), 0.02 * part)
}

/// Forces between two configurations do the work by which the energy changes, and keep both momenta about places half-way.
fn forces_between_conserve<const D: usize>() {
    let rest = quadratic::<D>([2; D], [1.0; D]).positions;
    for (k, term) in all_terms::<D>().iter().enumerate() {
        for size in [0.0, 1e-9, 1e-3, 0.1] {
            let mut noise = Noise(k as u64 + 20);
            let first = moved(&rest, &noise.vectors(rest.len()), 0.1);
            // The second is turned, too, by half a radian.
            let (s, c) = 0.5f64.sin_cos();
            let turned = |x: &Vector<D>| {
                let mut y = *x;
                (y[0], y[1]) = (c * x[0] - s * x[1], s * x[0] + c * x[1]);
                y
            };
            let second = moved(&first, &noise.vectors(rest.len()), size);
            let second: Vec<Vector<D>> = second.iter().map(turned).collect();
            let mut forces = vec![Vector::zeros(); rest.len()];
            term.add_forces_between([&first, &second], &mut forces);
            let work: f64 = (0..rest.len()).map(|v| forces[v].dot(&(second[v] - first[v]))).sum();
            let (before, after) = (term.energy(&first), term.energy(&second));
            assert!((work + after - before).abs() < 1e-13 * (1.0 + before.abs()), "{D}D term {k}: {work}");
            let sum: Vector<D> = forces.iter().sum();
            let torque: f64 = rotation_planes::<D>()
                .iter()
                .map(|(p, q, _)| {
                    let of = |v: usize| {
                        let x = (first[v] + second[v]) * 0.5;
                        x[*p] * forces[v][*q] - x[*q] * forces[v][*p]
                    };
                    (0..rest.len()).map(of).sum::<f64>().abs()
                })
                .fold(0.0, f64::max);
            assert!(sum.norm() < 1e-13 && torque < 1e-13, "{D}D term {k}: {sum} {torque:e}");
        }
    }
}

#[test]
fn forces_between() {
    forces_between_conserve::<2>();
    forces_between_conserve::<3>();
}

fn crushed_elements_resist<const D: usize>() {
    let mesh = quadratic::<D>([2; D], [1.0; D]);
    let crush =
        || Continuum::new(&mesh, InversionBarrier, Lame::new(3.0, 0.35), ElementOrder::Quadratic).unwrap();
    let mut noise = Noise(5);
    assert!(crush().energy(&crushed(1.2 * CRUSHED_VOLUME_RATIO, &mut noise)) == 0.0);
    assert!(crush().energy(&crushed(-0.1, &mut noise)) == f64::INFINITY);
    let (x, step) = (crushed::<D>(0.5 * CRUSHED_VOLUME_RATIO, &mut noise), 1e-7);
    let along = noise.vectors(x.len());
    let mut f = vec![Vector::zeros(); x.len()];
    crush().add_forces(&x, &mut f);
    let slope =
        (crush().energy(&moved(&x, &along, step)) - crush().energy(&moved(&x, &along, -step))) / (2.0 * step);
    assert!((slope + dot(&f, &along)).abs() < 1e-6 * slope.abs(), "{D}D: {slope}");
}

#[test]
fn crushed_elements() {
    crushed_elements_resist::<2>();
    crushed_elements_resist::<3>();
}

/// The potential of a step has the gradient and the second derivatives that it says.
fn potentials_of_steps_have_their_derivatives<const D: usize>(pressed: f64) {
    let mesh = quadratic::<D>([2; D], [1.0; D]);
    let law = ConstitutiveLaw::neo_hookean(3.0, 0.35, ElementOrder::Quadratic);
    let description =
        ElasticSpecification { mesh, density: 1.0, law, damping_ratio: 0.3, anchors: Vec::new() };
    let elastic = Elastic::new(description).unwrap();
    let mut noise = Noise(11);
    let x = crushed::<D>(pressed, &mut noise);
    let count = x.len();
    let noisy = crushed(pressed, &mut noise);
    let still = vec![Vector::zeros(); count];
    let velocities = moved(&still, &noise.vectors(count), 0.3 * pressed);
    let state = ElasticState { positions: x, velocities, time: 0.0 };
    let impulses = noise.vectors(count);
    let potential = IncrementalPotential {
        elastic: &elastic,
        state: &state,
        viscosity_positions: noisy,
        discrete_gradient_correction: noise.vectors(count),
        extra_stiffness: &[],
        impulses: &impulses,
        impulse_time: 0.3,
        velocity_lead: 0.2,
        lookahead: 0.2,
    };
    let (v, along) = (moved(&still, &noise.vectors(count), 0.3 * pressed), noise.vectors::<D>(count));
    let h = 1e-5;
    let slope =
        (potential.value(&moved(&v, &along, h)) - potential.value(&moved(&v, &along, -h))) / (2.0 * h);
    let gradient = potential.gradient(&v);
    assert!((slope - dot(&gradient, &along)).abs() < 1e-6 * (1.0 + slope.abs()), "{D}D: {slope}");
    let (up, down) = (potential.gradient(&moved(&v, &along, h)), potential.gradient(&moved(&v, &along, -h)));
    let mut product = vec![Vector::zeros(); count];
    potential.hessian(&v, false).unwrap().add_product(&along, &mut product);
    for k in 0..count {
        let slope = (up[k] - down[k]) / (2.0 * h);
        assert!((slope - product[k]).norm() < 1e-6 * (1.0 + slope.norm()), "{D}D: {slope} {}", product[k]);
    }
}

/// Half-way through a step, where the law is taken, and at the end of the coming one an element without volume makes the potential
/// infinite; as far as elements may go to the latter is told.
fn potentials_are_infinite_without_volume_at_the_end<const D: usize>() {
    let mesh = quadratic::<D>([2; D], [1.0; D]);
    let x = mesh.positions.clone();
    let law = ConstitutiveLaw::neo_hookean(3.0, 0.35, ElementOrder::Quadratic);
    let description =
        ElasticSpecification { mesh, density: 1.0, law, damping_ratio: 0.0, anchors: Vec::new() };
    let elastic = Elastic::new(description).unwrap();
    let zero = vec![Vector::zeros(); x.len()];
    let state = ElasticState { positions: x.clone(), velocities: zero.clone(), time: 0.0 };
    let potential = |impulse_time: f64, lookahead: f64| IncrementalPotential {
        elastic: &elastic,
        state: &state,
        viscosity_positions: x.clone(),
        discrete_gradient_correction: zero.clone(),
        extra_stiffness: &[],
        impulses: &zero,
        impulse_time,
        velocity_lead: 0.5 * impulse_time,
        lookahead,
    };
    // A corner goes through the body to where its elements have no volume.
    let far = (0..x.len()).max_by(|a, b| x[*a].sum().total_cmp(&x[*b].sum())).unwrap();
    let pressed = |by: f64| {
        let mut v = zero.clone();
        v[far] = Vector::repeat(-by);
        v
    };
    // Half-way that is no matter.
    assert!(potential(4.0, 1e-6).value(&pressed(1.0)).is_finite(), "{D}D");
    assert!(potential(1e-6, 1.0).value(&pressed(0.01)).is_finite(), "{D}D");
    assert!(potential(1e-6, 1.0).value(&pressed(1.0)) == f64::INFINITY, "{D}D");
    let part = potential(1e-6, 1.0).inversion_free_fraction(&zero, &pressed(1.0), 0.2);
    assert!(part > 0.0 && part < 1.0, "{D}D: {part}");
    assert!(potential(1e-6, 1.0).value(&pressed(part)).is_finite(), "{D}D");
}

#[test]
fn potentials_of_steps() {
    potentials_are_infinite_without_volume_at_the_end::<2>();
    potentials_are_infinite_without_volume_at_the_end::<3>();
    [0.9, 0.5 * CRUSHED_VOLUME_RATIO].into_iter().for_each(potentials_of_steps_have_their_derivatives::<2>);
    [0.9, 0.5 * CRUSHED_VOLUME_RATIO].into_iter().for_each(potentials_of_steps_have_their_derivatives::<3>);
}

fn heights_over_a_surface_are_resisted_as_its_size_grows<const D: usize>() {
    let mesh = quadratic::<D>([2; D], [1.0; D]);
    let rest = mesh.positions.clone();
    let body = body(Box::new(SurfaceTension::new(&mesh, 0.7)));
    // The middle of a side, which lies in its plane.
    let at = |x: &Vector<D>| (0..D).all(|a| (x[a] - if a + 1 == D { 1.0 } else { 0.5 }).abs() < 1e-9);
    let middles: Vec<usize> = (0..rest.len()).filter(|v| at(&rest[*v])).collect();
    assert_eq!(middles.len(), 1, "vertices in the middle of the upper side");
    let middle = middles[0];
    let mut along = vec![Vector::zeros(); rest.len()];
    along[middle][D - 1] = 1.0;
    let mut product = vec![Vector::zeros(); rest.len()];
    body.tangent(&rest, TangentWeights { stiffness: 1.0, project_psd: true, viscosity: 0.0 })
        .add_product(&along, &mut product);
    let step = 1e-5;
    let (up, down) = (body.forces(&moved(&rest, &along, step)), body.forces(&moved(&rest, &along, -step)));
    let slope = (down[middle] - up[middle]) / (2.0 * step);
    assert!(
        (slope - product[middle]).norm() < 1e-7 && slope[D - 1] > 0.1,
        "{D}D: {slope} {}",
        product[middle]
    );
}

#[test]
fn surfaces_with_tension() {
    heights_over_a_surface_are_resisted_as_its_size_grows::<2>();
    heights_over_a_surface_are_resisted_as_its_size_grows::<3>();
}

fn small_strains_obey_hooke<const D: usize>() {
    let (young, poisson) = (3.0, 0.35);
    let Lame { lambda, mu } = Lame::new(young, poisson);
    let mesh = quadratic::<D>([2; D], [1.0; D]);
    for (k, term) in terms::<D>().iter().enumerate().skip(1) {
        let size = 1e-6;
        let strain = |x: &Vector<D>| {
            Vector::from_fn(|r, _| x[r] + size * if r == 0 { x[0] + 0.5 * x[1] } else { 0.0 })
        };
        let energy = term.energy(&mesh.positions.iter().map(strain).collect::<Vec<_>>());
        let told = size * size * (mu * (1.0 + 2.0 * 0.25 * 0.25) + 0.5 * lambda);
        assert!((energy / told - 1.0).abs() < 1e-4, "{D}D term {k}: {energy:e} {told:e}");
    }
}

/// The laws resist however inverted a solid is.
fn pressed_elements_resist<const D: usize>() {
    let mesh = quadratic::<D>([2; D], [1.0; D]);
    let lame = Lame::new(3.0, 0.35);
    for order in BOTH {
        let laws: [Box<dyn DiscreteGradientTerm<D>>; 2] = [
            Box::new(Continuum::new(&mesh, NeoHookean, lame, order).unwrap()),
            Box::new(Continuum::new(&mesh, Corotated, lame, order).unwrap()),
        ];
        for law in laws {
            let squeezed = |by: f64| -> Vec<Vector<D>> {
                let at = |x: &Vector<D>| Vector::from_fn(|r, _| if r == 0 { by * x[r] } else { x[r] });
                mesh.positions.iter().map(at).collect()
            };
            let mut last = 0.0;
            for by in [0.5, 0.1, 1e-3, 1e-9, 0.0, -0.1, -0.9] {
                let energy = law.energy(&squeezed(by));
                assert!(energy.is_finite() && energy > last, "{D}D {by}: {energy} after {last}");
                last = energy;
                let f = forces(law.as_ref(), &squeezed(by));
                let apart: f64 = f.iter().zip(&mesh.positions).map(|(f, x)| f[0] * (x[0] - 0.5)).sum();
                assert!(
                    f.iter().all(|f| f.iter().all(|c| c.is_finite())) && apart > 0.0,
                    "{D}D {by}: {apart}"
                );
            }
        }
    }
}

/// No motion but a rigid one is without energy: as many zeros among the eigenvalues of the stiffness as there are of these.
fn stiffness_has_full_rank<const D: usize>() {
    for cells in [[2; D], [4; D]] {
        let mesh = quadratic::<D>(cells, [1.0; D]);
        // Nodes out of the middles, as curved surfaces have them.
        let mut noise = Noise(3);
        let rest = moved(&mesh.positions, &noise.vectors(mesh.positions.len()), 0.02);
        let bent = VolumeMesh { positions: rest, ..mesh.clone() };
        for mesh in [mesh, bent] {
            let law = ConstitutiveLaw::neo_hookean(1.0, 0.3, ElementOrder::Quadratic);
            let description =
                ElasticSpecification { mesh, density: 1.0, law, damping_ratio: 0.0, anchors: Vec::new() };
            let body = Elastic::new(description).unwrap();
            let x = &body.rest_mesh().positions;
            let stiffness =
                body.tangent(x, TangentWeights { stiffness: 1.0, project_psd: false, viscosity: 0.0 });
            let n = x.len() * D;
            let column = |k: usize| {
                let mut unit = vec![Vector::<D>::zeros(); x.len()];
                unit[k / D][k % D] = 1.0;
                let mut product = vec![Vector::zeros(); x.len()];
                stiffness.add_product(&unit, &mut product);
                product.iter().flat_map(|v| v.iter().copied().collect::<Vec<_>>()).collect::<Vec<f64>>()
            };
            let dense = nalgebra::DMatrix::from_vec(n, n, (0..n).flat_map(column).collect());
            let mut values: Vec<f64> = dense.symmetric_eigenvalues().iter().copied().collect();
            values.sort_by(f64::total_cmp);
            let rigid = D * (D + 1) / 2;
            assert!(
                values[rigid - 1].abs() < 1e-12 && values[0] > -1e-12,
                "{D}D: {:?}",
                &values[..rigid + 1]
            );
            // The slowest elastic motion of a unit cube of E = 1 in so few elements.
            assert!(values[rigid] > 1e-3, "{D}D: {:?}", &values[..rigid + 1]);
        }
    }
}

#[test]
fn rank() {
    stiffness_has_full_rank::<2>();
    stiffness_has_full_rank::<3>();
}

#[test]
fn derivatives() {
    forces_are_the_slope_of_the_energy::<2>();
    forces_are_the_slope_of_the_energy::<3>();
    tangents_are_slopes_of_forces::<2>();
    tangents_are_slopes_of_forces::<3>();
}

#[test]
fn tangents() {
    tangents_are_positive_and_rates_of_strain_keep_momenta::<2>();
    tangents_are_positive_and_rates_of_strain_keep_momenta::<3>();
}

#[test]
fn hooke() {
    small_strains_obey_hooke::<2>();
    small_strains_obey_hooke::<3>();
}

#[test]
fn inversion() {
    pressed_elements_resist::<2>();
    pressed_elements_resist::<3>();
}
