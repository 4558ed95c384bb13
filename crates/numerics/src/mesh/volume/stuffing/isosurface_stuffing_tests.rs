//! Angles and distance errors of meshed regions.

use super::*;
use crate::Matrix;
use crate::mesh::volume::quadratic::ElementOrder;
use crate::shape::{MeshShape, Shape};
use std::sync::Arc;

/// Deterministic pseudo-random numbers, 0 to 1.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Smallest and largest angle in degrees of slabs cut at random planes.
fn planes<const D: usize>(count: usize, drawn: [f64; 2]) -> [f64; 2] {
    let mut random = Random(7);
    let mut worst = [180.0f64, 0.0f64];
    for _ in 0..count {
        let normal = Vector::<D>::from_fn(|_, _| random.next() - 0.5).normalize();
        let shift = random.next() - 0.5;
        let distance = |x: &Vector<D>| {
            ((x.dot(&normal) - shift).abs() - 3.0).max((x - normal * x.dot(&normal)).norm() - 3.0)
        };
        let mesh =
            stuff_unchecked(&distance, &Vector::repeat(-6.0), &Vector::repeat(6.0), 1.0, drawn).unwrap();
        for simplex in &mesh.simplices {
            let x = simplex.center(&mesh.positions);
            if (x - normal * x.dot(&normal)).norm() > 1.5 {
                continue;
            }
            let angles = simplex.shape(&mesh.positions).unwrap().angles.map(f64::to_degrees);
            worst = [worst[0].min(angles[0]), worst[1].max(angles[1])];
        }
    }
    worst
}

/// Smallest and largest angle in degrees if the signs at the lattice's vertices are nearly random: the worst case.
fn noise<const D: usize>(half: f64, drawn: [f64; 2]) -> [f64; 2] {
    let mut random = Random(3);
    let mut wave = || (Vector::<D>::from_fn(|_, _| 12.0 * (random.next() - 0.5)), 6.3 * random.next());
    let waves: Vec<_> = (0..12).map(|_| wave()).collect();
    let size = Vector::<D>::repeat(half);
    let distance = |x: &Vector<D>| {
        let sum = waves.iter().map(|(k, phase)| (k.dot(x) + phase).sin()).sum::<f64>();
        sum.max((x.abs() - size).max() * 20.0)
    };
    let mesh = stuff_unchecked(&distance, &-size, &size, 1.0, drawn).unwrap();
    let mut worst = [180.0f64, 0.0f64];
    for simplex in &mesh.simplices {
        let angles = simplex.shape(&mesh.positions).unwrap().angles.map(f64::to_degrees);
        worst = [worst[0].min(angles[0]), worst[1].max(angles[1])];
    }
    worst
}

#[test]
#[ignore = "a search for the best constants"]
fn scan() {
    for a in [0.3, 0.35, 0.38, 0.4, 0.42, 0.44, 0.46, 0.48] {
        println!("2D {a}: {:?} {:?}", planes::<2>(1000, [a, a]), noise::<2>(100.0, [a, a]));
    }
    for drawn in [[0.25, 0.38], [0.25, 0.41], [0.25, 0.43], [0.25, 0.45], [0.3, 0.41], [0.2, 0.41]] {
        println!("3D {drawn:?}: {:?} {:?}", planes::<3>(200, drawn), noise::<3>(20.0, drawn));
    }
}

/// Largest distance of boundary vertices from the surface, and of facet centres, in edges.
fn off<const D: usize>(mesh: &VolumeMesh<D>, distance: &dyn Fn(&Vector<D>) -> f64, edge: f64) -> [f64; 2] {
    let (surface, _) = mesh.surface();
    let vertices = surface.positions.iter().map(|x| distance(x).abs()).fold(0.0, f64::max);
    let center = |f: usize| surface.corners(f).iter().sum::<Vector<D>>() / D as f64;
    let facets = (0..surface.facets.len()).map(|f| distance(&center(f)).abs()).fold(0.0, f64::max);
    assert!(surface.is_watertight());
    [vertices / edge, facets / edge]
}

fn fill<const D: usize>(name: &str, shape: &Shape<D>, edge: f64) -> VolumeMesh<D> {
    let distance = |x: &Vector<D>| shape.signed_distance(x);
    let mesh = VolumeMesh::of_shape(shape, edge, ElementOrder::Linear).unwrap();
    let [vertices, facets] = off(&mesh, &distance, edge);
    let quality = mesh.quality();
    println!("{D}D {name}: {quality}; vertices off by {vertices:.1e} edges, facets by {facets:.3}");
    assert!(vertices < 1e-9);
    let least = if D == 2 { 16.0 } else { 10.7 };
    assert!(quality.smallest_angle.0.to_degrees() > least && quality.components == 1);
    assert!((quality.edge_lengths[1] / edge - 1.0).abs() < 0.15);
    mesh
}

fn regions<const D: usize>() {
    let middle = Vector::from_fn(|a, _| 0.49 + 0.017 * a as f64);
    let ball = Shape::Ball { center: middle, radius: 0.21 };
    let errors = [0.05, 0.025].map(|edge| {
        let mesh = fill::<D>("ball", &ball, edge);
        let distance = |x: &Vector<D>| ball.signed_distance(x);
        (mesh.volume() / ball.volume().unwrap() - 1.0, off(&mesh, &distance, edge)[1] * edge)
    });
    println!("{D}D ball, errors of volume and facets at two edges: {errors:?}");
    assert!(errors[1].0 < 0.0 && errors[0].0 / errors[1].0 > 3.3, "volume not of second order");
    assert!(errors[0].1 / errors[1].1 > 2.8, "surface not of second order");

    let end = Vector::from_fn(|a, _| [0.6, 0.5, 0.3][a]);
    fill::<D>("capsule", &Shape::Capsule { a: middle, b: end, radius: 0.08 }, 0.03);
    let mut rotation = Matrix::<D>::identity();
    let (s, c) = 0.4f64.sin_cos();
    (rotation[(0, 0)], rotation[(0, 1)], rotation[(1, 0)], rotation[(1, 1)]) = (c, -s, s, c);
    let radii = Vector::from_fn(|a, _| [0.3, 0.1, 0.2][a]);
    fill::<D>("ellipsoid", &Shape::Ellipsoid { center: middle, radii, rotation }, 0.04);
    let pair = Shape::Union(vec![
        Shape::Ball { center: middle, radius: 0.2 },
        Shape::Ball { center: middle + Vector::repeat(0.12), radius: 0.15 },
    ]);
    fill::<D>("two balls", &pair, 0.04);
    let cube = VolumeMesh::of_box(&middle, &Vector::repeat(0.2), &rotation, 0.2, ElementOrder::Linear)
        .unwrap()
        .surface()
        .0;
    fill::<D>("mesh of a cube", &Shape::Mesh(Arc::new(MeshShape::new(cube))), 0.04);
}

#[test]
fn stuffing_follows_the_surface() {
    regions::<2>();
    regions::<3>();
}

#[test]
fn stuffing_keeps_angles() {
    let flat = [planes::<2>(60, WARP_THRESHOLDS_2D), noise::<2>(20.0, WARP_THRESHOLDS_2D)];
    let solid = [planes::<3>(8, WARP_THRESHOLDS_3D), noise::<3>(5.0, WARP_THRESHOLDS_3D)];
    println!("angles at random planes and random signs, degrees: 2D {flat:?}, 3D {solid:?}");
    assert!(flat[0][0] > 16.0 && flat[0][1] < 131.0 && flat[1][0] > 16.0 && flat[1][1] < 139.0);
    assert!(solid[0][0] > 17.0 && solid[0][1] < 141.0 && solid[1][0] > 10.7 && solid[1][1] < 164.8);
}

/// Mirror images of the mesh of a ball equal the mesh.
#[test]
fn stuffing_is_symmetric() {
    let shape = Shape::<3>::Ball { center: Vector::repeat(0.3), radius: 0.2 };
    let mesh = fill("symmetric ball", &shape, 0.06);
    let keys = |flip: Option<usize>| {
        let key = |x: &Vector<3>| -> [i64; 3] {
            std::array::from_fn(|a| {
                let d = (x[a] - 0.3) * if flip == Some(a) { -1.0 } else { 1.0 };
                (d * 1e8).round() as i64
            })
        };
        let mut all: Vec<_> = mesh.positions.iter().map(key).collect();
        all.sort_unstable();
        all
    };
    (0..3).for_each(|a| assert!(keys(None) == keys(Some(a))));
}

fn refusals<const D: usize>() {
    let ball = |x: &Vector<D>| x.norm() - 1.0;
    let one = Vector::<D>::repeat(1.0);
    assert!(matches!(stuff(&ball, &-one, &one, 0.0), Err(StuffingError::Size { .. })));
    assert!(matches!(stuff(&ball, &-one, &(one * f64::INFINITY), 0.1), Err(StuffingError::Size { .. })));
    assert!(matches!(stuff(&ball, &-one, &one, 1e-7), Err(StuffingError::TooFine { .. })));
    assert!(matches!(stuff(&ball, &(-one * 0.1), &(one * 0.1), 0.05), Err(StuffingError::Beyond { .. })));
    let half = Shape::HalfSpace { point: one, normal: one };
    assert!(matches!(
        VolumeMesh::of_shape(&half, 0.1, ElementOrder::Linear),
        Err(StuffingError::Size { .. })
    ));
    let nothing = |_: &Vector<D>| 1.0;
    assert!(matches!(stuff(&nothing, &-one, &one, 0.1), Err(StuffingError::Empty { .. })));
}

#[test]
fn stuffing_refuses_what_cannot_be() {
    refusals::<2>();
    refusals::<3>();
}
