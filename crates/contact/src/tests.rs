//! Tests of derivatives against finite differences, and of step fractions against distances.

use crate::*;
use meniscus_numerics::{Matrix, Vector};

/// Pseudo-random numbers between -1 and 1.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    fn points<const D: usize>(&mut self, count: usize) -> Vec<Vector<D>> {
        (0..count).map(|_| Vector::from_fn(|_, _| self.next())).collect()
    }
}

const KINDS_2: [StencilKind; 1] = [StencilKind::PointSegment];
const KINDS_3: [StencilKind; 2] = [StencilKind::PointTriangle, StencilKind::EdgeEdge];

fn stencil(kind: StencilKind) -> Stencil {
    Stencil { kind, points: [0, 1, 2, if kind.point_count() == 4 { 3 } else { 0 }] }
}

/// Distance of two features by sampling both.
fn tried<const D: usize>(kind: StencilKind, x: &[Vector<D>]) -> f64 {
    const MANY: usize = 200;
    let part = |i: usize| i as f64 / MANY as f64;
    let mut least = f64::INFINITY;
    for i in 0..=MANY {
        for j in 0..=MANY {
            let (s, t) = (part(i), part(j));
            let apart = match kind {
                StencilKind::PointSegment => x[0] - x[1].lerp(&x[2], s),
                StencilKind::PointTriangle => x[0] - x[1].lerp(&x[2].lerp(&x[3], t), s),
                StencilKind::EdgeEdge => x[0].lerp(&x[1], s) - x[2].lerp(&x[3], t),
            };
            least = least.min(apart.norm());
        }
    }
    least
}

fn check_distances<const D: usize>(kinds: &[StencilKind]) {
    let mut numbers = Numbers(7);
    for kind in kinds {
        for _ in 0..40 {
            let x = numbers.points::<D>(kind.point_count());
            let closest = ClosestPair::new(*kind, &stencil(*kind).positions(&x));
            let tried = tried(*kind, &x);
            assert!((closest.distance() - tried).abs() < 0.02, "{kind:?} {x:?}");
            let sum: Vector<D> = x.iter().zip(closest.weights).map(|(x, w)| x * w).sum();
            assert!((sum - closest.separation).norm() < 1e-14);
            let first: f64 = closest.weights[..kind.first_count()].iter().sum();
            assert!((first - 1.0).abs() < 1e-14 && closest.weights.iter().sum::<f64>().abs() < 1e-14);
        }
    }
}

#[test]
fn distances_are_those_of_all_points() {
    check_distances::<2>(&KINDS_2);
    check_distances::<3>(&KINDS_3);
}

/// Compares derivatives with finite differences of the energy and of its gradient.
fn check_derivatives<const D: usize>(
    x: &[Vector<D>],
    scale: f64,
    energy: impl Fn(&[Vector<D>]) -> f64,
    derivatives: impl Fn(&[Vector<D>]) -> Option<LocalDerivatives<D>>,
) -> bool {
    let Some(local) = derivatives(x) else { return false };
    let step = 1e-6;
    for k in 0..local.point_count {
        for a in 0..D {
            let moved = |by: f64| {
                let mut x = x.to_vec();
                x[k][a] += by;
                x
            };
            let [more, less] = [moved(step), moved(-step)];
            let slope = (energy(&more) - energy(&less)) / (2.0 * step);
            assert!((slope - local.gradient[k][a]).abs() < 1e-5 * scale, "{slope} {}", local.gradient[k][a]);
            let (Some(more), Some(less)) = (derivatives(&more), derivatives(&less)) else { return false };
            for l in 0..local.point_count {
                let bend = (more.gradient[l] - less.gradient[l]) / (2.0 * step);
                let told = local.hessian[l][k].column(a);
                assert!((bend - told).norm() < 1e-3 * scale, "{k} {a} {l}: {bend:?} {told:?}");
            }
        }
    }
    true
}

fn check_barrier<const D: usize>(kinds: &[StencilKind]) {
    let mut numbers = Numbers(3);
    for kind in kinds {
        let mut checked = 0;
        for _ in 0..400 {
            let x = numbers.points::<D>(kind.point_count());
            let closest = ClosestPair::new(*kind, &stencil(*kind).positions(&x));
            // The second derivative jumps where a coordinate reaches its bound.
            let inner = closest.weights[..kind.point_count()].iter().all(|w| w.abs() > 1e-4 || *w == 0.0);
            if !(0.1..0.49).contains(&closest.distance()) || !inner {
                continue;
            }
            let contact = Contact {
                stencil: stencil(*kind),
                area: 0.3,
                stiffness: 2.0,
                squared_length_product: 400.0,
                thickness: 0.03,
                activation_distance: 0.5,
            };
            let energy = |x: &[Vector<D>]| contact.energy(x);
            let derivatives = |x: &[Vector<D>]| contact.derivatives(x);
            checked += usize::from(check_derivatives(&x, 10.0, energy, derivatives));
            // The force is the gradient of the first feature.
            if let Some(local) = (Contact { squared_length_product: 0.0, ..contact }).derivatives(&x) {
                let first: Vector<D> = local.gradient[..kind.first_count()].iter().sum();
                let force = Contact { squared_length_product: 0.0, ..contact }.force(&x);
                assert!((first.norm() - force).abs() < 1e-12);
            }
        }
        assert!(checked > 20, "{kind:?} {checked}");
    }
}

#[test]
fn barriers_have_the_derivatives_they_tell() {
    check_barrier::<2>(&KINDS_2);
    check_barrier::<3>(&KINDS_3);
}

fn check_positive<const D: usize>(kind: StencilKind) {
    let mut numbers = Numbers(11);
    let mut checked = 0;
    for _ in 0..200 {
        let x = numbers.points::<D>(kind.point_count());
        let contact = Contact {
            stencil: stencil(kind),
            area: 1.0,
            stiffness: 1.0,
            squared_length_product: 400.0,
            thickness: 0.0,
            activation_distance: 0.6,
        };
        let Some(local) = contact.derivatives(&x).map(LocalDerivatives::projected_psd) else {
            continue;
        };
        for _ in 0..20 {
            let way = numbers.points::<D>(4);
            let bend: f64 = (0..kind.point_count())
                .flat_map(|k| (0..kind.point_count()).map(move |l| (k, l)))
                .map(|(k, l)| way[k].dot(&(local.hessian[k][l] * way[l])))
                .sum();
            assert!(bend > -1e-9, "{bend}");
        }
        checked += 1;
    }
    assert!(checked > 10);
}

#[test]
fn hessians_are_positive() {
    check_positive::<2>(StencilKind::PointSegment);
    check_positive::<3>(StencilKind::PointTriangle);
    check_positive::<3>(StencilKind::EdgeEdge);
}

fn check_friction<const D: usize>(kind: StencilKind) {
    let mut numbers = Numbers(5);
    let friction = Friction { max_elastic_slip: 0.7 };
    let mut checked = 0;
    for _ in 0..40 {
        let (from, x) = (numbers.points::<D>(kind.point_count()), numbers.points::<D>(kind.point_count()));
        let contact = Contact {
            stencil: stencil(kind),
            area: 1.0,
            stiffness: 1.0,
            squared_length_product: 0.0,
            thickness: 0.0,
            activation_distance: 0.6,
        };
        let Some(rubbing) = FrictionPair::new(&contact, 0.4, &from) else { continue };
        let rubbing = FrictionPair { slip: friction.return_mapped(numbers.points::<D>(1)[0]), ..rubbing };
        let energy = |x: &[Vector<D>]| friction.energy(&rubbing, &from, x);
        let derivatives = |x: &[Vector<D>]| Some(friction.derivatives(&rubbing, &from, x));
        checked += usize::from(check_derivatives(&x, 1.0, energy, derivatives));
    }
    assert!(checked > 10);
}

#[test]
fn friction_has_the_derivatives_it_tells() {
    check_friction::<2>(StencilKind::PointSegment);
    check_friction::<3>(StencilKind::PointTriangle);
    check_friction::<3>(StencilKind::EdgeEdge);
}

/// Spring and slider: the force is kept where the limit grows, no energy is created, and no force exceeds the limit.
fn check_slip<const D: usize>() {
    let mut numbers = Numbers(17);
    let friction = Friction { max_elastic_slip: 0.7 };
    let kind = if D == 2 { StencilKind::PointSegment } else { StencilKind::PointTriangle };
    let still = vec![Vector::<D>::zeros(); 4];
    let normal = Vector::from_fn(|a, _| f64::from(u8::from(a + 1 == D)));
    let force = |slip: Vector<D>, friction_limit: f64| {
        let weights = [1.0, -0.5, -0.5, 0.0];
        let rubbing = FrictionPair { stencil: stencil(kind), weights, normal, friction_limit, slip };
        friction.derivatives(&rubbing, &still, &still).gradient[0]
    };
    for _ in 0..200 {
        let slip = friction.return_mapped(numbers.points::<D>(1)[0]);
        let slip = slip - normal * slip.dot(&normal);
        let [from, to] = [1.0 + 0.9 * numbers.next(), 1.0 + 0.9 * numbers.next()];
        let carried = friction.rescaled_slip(&slip, from, to);
        assert!(carried.norm() <= friction.max_elastic_slip * (1.0 + 1e-12));
        let expected = if to > from { force(slip, from) } else { force(slip, to) };
        assert!((force(carried, to) - expected).norm() < 1e-9, "{slip:?} {from} {to}");
        assert!(friction.slip_energy(to, &carried) <= friction.slip_energy(from, &slip) + 1e-12);
        let far = friction.return_mapped(slip * 10.0);
        assert!(far.norm() <= friction.max_elastic_slip * (1.0 + 1e-12));
        assert!((force(slip * 1e3, from).norm() - from).abs() < 1e-12);
    }
    assert_eq!(friction.rescaled_slip(&Vector::<D>::zeros(), 1.0, 2.0).norm(), 0.0);
}

#[test]
fn friction_carries_its_force_from_step_to_step() {
    check_slip::<2>();
    check_slip::<3>();
}

fn check_steps<const D: usize>(kinds: &[StencilKind]) {
    let mut numbers = Numbers(23);
    for kind in kinds {
        let mut hits = 0;
        for _ in 0..300 {
            let (x, ways) =
                (numbers.points::<D>(kind.point_count()), numbers.points::<D>(kind.point_count()));
            let (at, ways) = (stencil(*kind).positions(&x), stencil(*kind).positions(&ways).map(|w| w * 3.0));
            let kept_fraction = 0.2;
            let part =
                collision_free_fraction(*kind, &at, &ways, Clearance { thickness: 0.0, kept_fraction });
            let distance = |part: f64| {
                ClosestPair::new(*kind, &std::array::from_fn(|k| at[k] + ways[k] * part)).distance()
            };
            let start = distance(0.0);
            let least =
                (0..=1000).map(|i| distance(part * f64::from(i) / 1000.0)).fold(f64::INFINITY, f64::min);
            assert!(least >= kept_fraction * start * (1.0 - 1e-12), "{kind:?}: {least} of {start}");
            if part < 1.0 {
                // The fraction is not much below the largest possible.
                hits += 1;
                let near = distance(part);
                assert!(near < (kept_fraction + 0.11) * start, "{kind:?}: {near} of {start} at {part}");
            }
        }
        assert!(hits > 10, "{kind:?}: {hits}");
    }
}

#[test]
fn steps_end_before_features_meet() {
    check_steps::<2>(&KINDS_2);
    check_steps::<3>(&KINDS_3);
}

fn check_upright<const D: usize>() {
    let mut numbers = Numbers(31);
    let mut short = 0;
    for _ in 0..2000 {
        let edges = Matrix::<D>::from_fn(|i, j| f64::from(i == j) + 0.3 * numbers.next());
        let ways = Matrix::<D>::from_fn(|_, _| 2.0 * numbers.next());
        let start = crate::ccd::determinant(&edges);
        if start < 0.1 {
            continue;
        }
        let part = inversion_free_fraction(&edges, &ways, 0.1);
        let volume = |part: f64| crate::ccd::determinant(&(edges + ways * part));
        for i in 0..=500 {
            assert!(volume(part * f64::from(i) / 500.0) > (0.1 - 1e-9) * start);
        }
        if part < 1.0 {
            short += 1;
            assert!(volume(part + 1e-6) < (0.1 + 1e-3) * start);
        }
    }
    assert!(short > 100, "{short}");
}

#[test]
fn steps_end_before_elements_turn_inside_out() {
    check_upright::<2>();
    check_upright::<3>();
}

/// Contacts of the surfaces of two boxes.
#[test]
fn what_is_near_is_found() {
    let square = |low: [f64; 2]| {
        [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
            .map(|c| Vector::<2>::new(low[0] + c[0], low[1] + c[1]))
    };
    let x = [square([0.0, 0.0]), square([0.2, 1.05])].concat();
    let facets = (0..8u32).map(|k| [k, k / 4 * 4 + (k + 1) % 4]).collect();
    let surface = CollisionMesh::new(facets, &x, (0..8).map(|k| k / 4).collect());
    let near = surface.nearby_pairs(std::slice::from_ref(&x), 0.1, |_| false, |_| false);
    let contacts = near.contacts(0.1, &x, |_, _| 1.0);
    // Corner 2 of the lower square and corner 4 of the upper one are beside a side of the other square.
    let points: Vec<u32> = contacts.iter().map(|c| c.stencil.points[0]).collect();
    assert_eq!(points, [2, 4]);
    let narrowest = near.gaps(&x).map(|d| d.1).fold(f64::INFINITY, f64::min);
    assert!((narrowest - 0.05).abs() < 1e-12);
    let mut ways = vec![Vector::zeros(); 8];
    (4..8).for_each(|k| ways[k] = Vector::<2>::new(0.0, -0.1));
    let part = near.collision_free_fraction(&x, &ways, 0.2);
    assert!(part > 0.35 && part <= 0.4, "{part}");
}

/// Edges that are parallel up to rounding have the distance of their lines.
#[test]
fn nearly_parallel_edges_have_their_distance() {
    for tilt in [0.0, 1e-16, 1e-12, 1e-9, 1e-6] {
        let x =
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.3, 0.1, 0.0], [1.7, 0.1 + tilt, tilt]].map(Vector::from);
        let distance = ClosestPair::<3>::new(StencilKind::EdgeEdge, &x).distance();
        assert!((distance - 0.1).abs() < 2.0 * tilt + 1e-15, "{tilt}: {distance}");
    }
}

/// Points keep their fraction of the distance to a plane and move away from it freely.
#[test]
fn points_stay_off_planes() {
    let plane = Plane { point: Vector::<2>::new(0.0, 1.0), normal: Vector::<2>::new(0.0, 1.0) };
    let step = |way: f64| {
        plane.collision_free_fraction(
            &Vector::<2>::new(3.0, 1.5),
            &Vector::<2>::new(1.0, way),
            Clearance { thickness: 0.0, kept_fraction: 0.2 },
        )
    };
    assert!((step(-0.8) - 0.5).abs() < 1e-15);
    assert_eq!([step(-0.4), step(0.0), step(9.0)], [1.0; 3]);
}

/// Brute force: whichever two features come within reach of each other on a straight path between configurations are among the pairs,
/// and bounds on their distance and motion hold.
fn pairs_that_come_near_are_found<const D: usize>() {
    let random = |k: usize| (k as f64 * 0.618_034 + (k * k) as f64 * 0.324_718).fract();
    let facet_count = 24;
    let facets: Vec<[u32; D]> =
        (0..facet_count).map(|f| std::array::from_fn(|k| (f * D + k) as u32)).collect();
    let at = |p: usize, spread: f64, seed: usize| {
        let origin = Vector::<D>::from_fn(|a, _| 2.0 * random(p / D * 7 + a));
        origin + Vector::from_fn(|a, _| spread * (random(p * 11 + a + seed) - 0.5))
    };
    let count = facet_count * D;
    let rest: Vec<Vector<D>> = (0..count).map(|p| at(p, 0.5, 3)).collect();
    let moved = |seed| (0..count).map(|p| rest[p] + at(p, 0.4, seed) - at(p, 0.0, 0)).collect();
    let configurations: Vec<Vec<Vector<D>>> = vec![rest.clone(), moved(101), moved(211)];
    let (reach, own): (f64, Vec<f64>) = (0.08, (0..count).map(|p| 0.02 + 0.12 * random(p + 5)).collect());
    let bodies = (0..count).map(|p| (p / D) as u32).collect();
    let mesh = CollisionMesh::new(facets.clone(), &rest, bodies).with_activation_distances(own.clone());
    let found = mesh.nearby_pairs(&configurations, reach, |_| false, |_| false);
    let found: Vec<Stencil> = found.gaps(&rest).map(|(stencil, _)| stencil).collect();
    let mut all: Vec<Stencil> = (0..count as u32)
        .flat_map(|p| facets.iter().filter(move |f| !f.contains(&p)).map(move |f| Stencil::point_facet(p, f)))
        .collect();
    if D == 3 {
        let edges: Vec<[u32; 2]> =
            facets.iter().flat_map(|f| [[0, 1], [0, 2], [1, 2]].map(|e| e.map(|k| f[k]))).collect();
        let apart = |(i, j): (usize, usize)| i / 3 != j / 3;
        let pairs = (0..edges.len()).flat_map(|j| (0..j).map(move |i| (i, j))).filter(|p| apart(*p));
        all.extend(pairs.map(|(i, j)| Stencil::edge_edge(edges[i], edges[j])));
    }
    let mut near = 0;
    for stencil in &all {
        let own = stencil.points().iter().map(|p| own[*p as usize]).fold(reach, f64::min);
        let distance = |one: &[Vector<D>], other: &[Vector<D>], part: f64| {
            let (a, b) = (stencil.positions(one), stencil.positions(other));
            let x = std::array::from_fn(|k| a[k] + (b[k] - a[k]) * part);
            let (distance, ways) =
                (ClosestPair::new(stencil.kind, &x).distance(), std::array::from_fn(|k| x[k] - a[k]));
            let before = ClosestPair::new(stencil.kind, &a).distance();
            assert!(stencil.kind.least_distance(&x) <= distance + 1e-12);
            assert!(distance >= before - stencil.kind.relative_motion(&ways) - 1e-12);
            distance
        };
        let paths = [(0, 1), (0, 2), (1, 2)].map(|(a, b)| (&configurations[a], &configurations[b]));
        let samples = paths.iter().flat_map(|(a, b)| (0..=20).map(|t| distance(a, b, f64::from(t) / 20.0)));
        if samples.fold(f64::INFINITY, f64::min) < own {
            near += 1;
            assert!(found.contains(stencil), "{D}D: {stencil:?} comes within {own} and is not found");
        }
    }
    assert!(
        near > 20 && found.len() < all.len() / 2,
        "{D}D: {near} near, {} found of {}",
        found.len(),
        all.len()
    );
}

#[test]
fn no_near_pair_is_left_out() {
    pairs_that_come_near_are_found::<2>();
    pairs_that_come_near_are_found::<3>();
}
