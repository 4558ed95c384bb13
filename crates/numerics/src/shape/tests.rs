//! Distances, bounds and volumes against closed forms and against each other.

use super::*;

/// A small generator of numbers in -1..1 (SplitMix64).
pub(super) struct Random(pub u64);
impl Random {
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
    pub fn point<const D: usize>(&mut self, reach: f64) -> Vector<D> {
        Vector::from_fn(|_, _| reach * self.next())
    }
}

/// A rotation about an oblique direction.
fn turn<const D: usize>() -> Matrix<D> {
    let mut m = Matrix::identity();
    for (a, b, angle) in [(0, 1, 0.4f64), (1, D - 1, if D == 3 { 0.9 } else { 0.0 })] {
        let mut g = Matrix::<D>::identity();
        if a != b && b > a {
            (g[(a, a)], g[(a, b)], g[(b, a)], g[(b, b)]) =
                (angle.cos(), -angle.sin(), angle.sin(), angle.cos());
        }
        m *= g;
    }
    m
}

/// Shapes of about unit size near the origin, with true distances.
fn smooth<const D: usize>() -> Vec<Shape<D>> {
    let c = Vector::from_fn(|a, _| 0.1 * a as f64 - 0.05);
    let radii = Vector::from_fn(|a, _| [0.9, 0.4, 0.65][a]);
    let ball = |mode, amplitude| Shape::PerturbedBall { center: c, radius: 0.7, mode, amplitude };
    vec![
        Shape::Ball { center: c, radius: 0.6 },
        Shape::Box { center: c, half_size: radii * 0.8, rotation: turn() },
        Shape::HalfSpace { point: c, normal: radii },
        Shape::Cylinder { center: c, axis: radii, radius: 0.4, height: 1.1 },
        Shape::Capsule { a: -c - radii * 0.5, b: c + radii * 0.5, radius: 0.3 },
        Shape::Ellipsoid { center: c, radii, rotation: turn() },
        Shape::Ellipsoid { center: c, radii: Vector::repeat(0.5), rotation: turn() },
        ball(2, 0.15),
        ball(3, -0.1),
        ball(4, 0.08),
        ball(1, 0.2),
    ]
}

fn gradient<const D: usize>(shape: &Shape<D>, x: &Vector<D>, h: f64) -> Vector<D> {
    Vector::from_fn(|a, _| {
        let mut e = Vector::zeros();
        e[a] = h;
        (shape.signed_distance(&(x + e)) - shape.signed_distance(&(x - e))) / (2.0 * h)
    })
}

fn check_distances<const D: usize>() {
    let mut random = Random(11);
    for shape in smooth::<D>() {
        for _ in 0..400 {
            let x: Vector<D> = random.point(1.3);
            let d = shape.signed_distance(&x);
            assert_eq!(shape.contains(&x), d < 0.0);
            let y: Vector<D> = x + random.point(0.3);
            assert!(
                (shape.signed_distance(&y) - d).abs() <= (y - x).norm() * (1.0 + 1e-9),
                "{shape:?} at {x}"
            );
            let g = gradient(&shape, &x, 1e-6);
            if (g.norm() - 1.0).abs() >= 1e-5 {
                continue; // on the skeleton or at an edge of it
            }
            // The point at that distance along the negative gradient is on the surface.
            let foot = x - g.normalize() * d;
            assert!(
                shape.signed_distance(&foot).abs() < 2e-6,
                "{shape:?} at {x}: {}",
                shape.signed_distance(&foot)
            );
        }
    }
}

fn check_near_surface<const D: usize>() {
    let mut random = Random(5);
    for (k, shape) in smooth::<D>().into_iter().enumerate() {
        let (mut seen, mut off) = (0, 0);
        for _ in 0..2000 {
            let x: Vector<D> = random.point(1.2);
            let d = shape.signed_distance(&x);
            if d.abs() > 0.05 {
                continue;
            }
            seen += 1;
            off += usize::from((gradient(&shape, &x, 1e-5).norm() - 1.0).abs() > 1e-6);
        }
        let edges = matches!(shape, Shape::Box { .. } | Shape::Cylinder { .. });
        assert!(seen > 30 && (off == 0 || edges && off * 8 < seen), "{D}D shape {k}: {off} of {seen}");
    }
}

#[test]
fn shape_distances_are_distances() {
    check_distances::<2>();
    check_distances::<3>();
}

#[test]
fn shape_gradient_is_one_near_the_surface() {
    check_near_surface::<2>();
    check_near_surface::<3>();
}

/// Points at a known distance along the exact normal have that signed distance.
#[test]
fn shape_closest_points_are_exact_to_ten_digits() {
    let mut random = Random(2);
    for _ in 0..500 {
        let radii = Vector::<3>::from([0.9, 0.4, 0.65]);
        let u = random.point::<3>(1.0).normalize();
        let on = u.component_mul(&radii);
        let normal = u.component_div(&radii).normalize();
        let ellipsoid = Shape::Ellipsoid { center: Vector::zeros(), radii, rotation: Matrix::identity() };
        for s in [-0.08, -1e-3, 0.0, 1e-3, 0.05, 3.0] {
            assert!((ellipsoid.signed_distance(&(on + normal * s)) - s).abs() < 1e-12);
        }
        let t = 3.0 * random.next();
        let (r, r1) = (0.7 * (1.0 + 0.1 * (3.0 * t).cos()), -0.21 * (3.0 * t).sin());
        let e = Vector::from([t.cos(), t.sin()]);
        let normal = (e * r - Vector::from([-t.sin(), t.cos()]) * r1).normalize();
        let disc =
            Shape::<2>::PerturbedBall { center: Vector::zeros(), radius: 0.7, mode: 3, amplitude: 0.1 };
        for s in [-0.08, -1e-3, 0.0, 1e-3, 0.05, 3.0] {
            assert!((disc.signed_distance(&(e * r + normal * s)) - s).abs() < 1e-12, "{t} {s}");
        }
        let t = t.abs();
        let c = t.cos();
        let (r, r1) = (0.7 * (1.0 + 0.1 * (1.5 * c * c - 0.5)), 0.07 * 3.0 * c * -t.sin());
        let (e, f) =
            (Vector::from([0.6 * t.sin(), 0.8 * t.sin(), c]), Vector::from([0.6 * c, 0.8 * c, -t.sin()]));
        let normal = (e * r - f * r1).normalize();
        let drop =
            Shape::<3>::PerturbedBall { center: Vector::zeros(), radius: 0.7, mode: 2, amplitude: 0.1 };
        for s in [-0.08, -1e-3, 0.0, 1e-3, 0.05, 3.0] {
            assert!((drop.signed_distance(&(e * r + normal * s)) - s).abs() < 1e-12, "{t} {s}");
        }
    }
}

#[test]
fn shape_distances_at_centres_and_axes() {
    let radii = Vector::from([0.9, 0.4, 0.65]);
    let ellipsoid = Shape::Ellipsoid { center: Vector::zeros(), radii, rotation: Matrix::identity() };
    assert!((ellipsoid.signed_distance(&Vector::zeros()) + 0.4).abs() < 1e-15);
    assert!((ellipsoid.signed_distance(&Vector::from([0.0, 0.0, 2.0])) - 1.35).abs() < 1e-14);
    let near = ellipsoid.signed_distance(&Vector::from([0.2, 1e-13, 0.1]));
    assert!((near - ellipsoid.signed_distance(&Vector::from([0.2, 0.0, 0.1]))).abs() < 1e-12);
    let drop = Shape::<3>::PerturbedBall { center: Vector::zeros(), radius: 1.0, mode: 2, amplitude: 0.2 };
    assert!((drop.signed_distance(&Vector::zeros()) + 0.9).abs() < 1e-12);
    assert!((drop.signed_distance(&Vector::from([0.0, 0.0, 1.3])) - 0.1).abs() < 1e-12);
    let plate = Shape::<2>::Cylinder {
        center: Vector::from([1.0, 1.0]),
        axis: Vector::from([0.0, 3.0]),
        radius: 0.5,
        height: 0.2,
    };
    assert!((plate.signed_distance(&Vector::from([1.8, 1.5])) - 0.5).abs() < 1e-15);
    assert!((plate.signed_distance(&Vector::from([1.0, 1.0])) + 0.1).abs() < 1e-15);
}

/// Compares volumes with lattice sums smoothed by the distance; the bounds contain and touch the shape.
fn check_volumes<const D: usize>() {
    let n: usize = if D == 2 { 400 } else { 60 };
    for shape in smooth::<D>() {
        let Some(volume) = shape.volume() else { continue };
        let h = 2.6 / n as f64;
        let sum: f64 = (0..n.pow(D as u32))
            .map(|mut k| {
                let x = Vector::<D>::from_fn(|_, _| {
                    let i = k % n;
                    k /= n;
                    (i as f64 + 0.5) * h - 1.3
                });
                (0.5 - shape.signed_distance(&x) / h).clamp(0.0, 1.0)
            })
            .sum();
        let counted = sum * h.powi(D as i32);
        assert!((counted / volume - 1.0).abs() < 3e-3, "{shape:?}: {counted} {volume}");
        let (lower, upper) = shape.bounds();
        let mut random = Random(9);
        for _ in 0..2000 {
            let x: Vector<D> = random.point(1.3);
            assert!(!shape.contains(&x) || (0..D).all(|a| lower[a] <= x[a] && x[a] <= upper[a]));
        }
    }
}

#[test]
fn shape_volumes_and_bounds() {
    check_volumes::<2>();
    check_volumes::<3>();
    // mode 4: the mean of P_4 cubed is 18 / 1001.
    assert!(
        (perturbed::relative_volume::<3>(4, 0.1) - (1.0 + 0.03 / 9.0 + 1e-3 * 18.0 / 1001.0)).abs() < 1e-14
    );
}

fn check_extrusion<const D: usize>() {
    let square = crate::mesh::SurfaceMesh {
        positions: [[0.4, 0.3], [-0.4, 0.3], [-0.4, -0.3], [0.4, -0.3]].map(Vector::from).to_vec(),
        facets: vec![[0, 1], [1, 2], [2, 3], [3, 0]],
    };
    let (center, rotation) = (Vector::repeat(0.1), turn());
    let outline = Arc::new(MeshShape::new(square));
    let plate = Shape::<D>::Extrusion { outline, center, thickness: 0.2, rotation };
    let half_size = Vector::from_fn(|a, _| [0.4, 0.3, 0.1][a]);
    let exact = Shape::Box { center, half_size, rotation };
    let mut random = Random(1);
    for _ in 0..500 {
        let x = random.point(1.0);
        assert!((plate.signed_distance(&x) - exact.signed_distance(&x)).abs() < 1e-14);
    }
    assert!((plate.volume().unwrap() - exact.volume().unwrap()).abs() < 1e-15);
    assert!((plate.bounds().0 - exact.bounds().0).norm() < 1e-15);
}

#[test]
fn shape_extrusion_of_a_rectangle_is_a_box() {
    check_extrusion::<2>();
    check_extrusion::<3>();
}

#[test]
fn shape_sampled_on_a_grid() {
    let outline = |r: f64| {
        let mut mesh = crate::mesh::SurfaceMesh::<2>::default();
        for k in 0..40 {
            let (s, c) = (2.0 * PI * f64::from(k) / 40.0).sin_cos();
            mesh.positions.push(Vector::from([0.5 + r * c * (1.0 - 0.6 * s), 0.5 + r * s]));
            mesh.facets.push([k as u32, (k as u32 + 1) % 40]);
        }
        Shape::Mesh(Arc::new(MeshShape::new(mesh)))
    };
    let ring = Shape::Difference { of: Box::new(outline(0.3)), minus: Box::new(outline(0.2)) };
    let shape = Shape::Union(vec![ring, Shape::Ball { center: Vector::repeat(0.5), radius: 0.1 }]);
    let grid = crate::grid::Grid::<2>::new([37, 41], 0.025);
    let field = shape.signed_distance_field(grid);
    for (i, v) in field.data.iter().enumerate() {
        let exact = shape.signed_distance(&grid.center(grid.lattice().coordinates(i)));
        assert!((v - exact).abs() < 1e-14);
    }
}

#[test]
fn shape_sets() {
    let ball = |x: f64| Shape::<2>::Ball { center: Vector::from([x, 0.0]), radius: 1.0 };
    let two = Shape::Union(vec![ball(0.0), ball(3.0)]);
    assert!((two.volume().unwrap() - 2.0 * PI).abs() < 1e-14);
    assert_eq!(two.bounds(), (Vector::from([-1.0, -1.0]), Vector::from([4.0, 1.0])));
    assert!(two.contains(&Vector::from([3.5, 0.0])) && !two.contains(&Vector::from([1.5, 0.0])));
    let moon = Shape::Difference { of: Box::new(ball(0.0)), minus: Box::new(ball(1.0)) };
    assert!(moon.volume().is_none());
    assert!(moon.contains(&Vector::from([-0.5, 0.0])) && !moon.contains(&Vector::from([0.5, 0.0])));
    assert_eq!(Shape::<2>::Union(vec![]).signed_distance(&Vector::zeros()), f64::INFINITY);
}

#[test]
#[ignore = "a measurement: run with --release --nocapture"]
fn shape_speed() {
    let n = 64;
    let time = |name: &str, f: &dyn Fn(Vector<3>) -> f64| {
        let start = std::time::Instant::now();
        let mut sum = 0.0;
        for k in 0..n * n * n {
            let x = [k % n, k / n % n, k / n / n].map(|i| (i as f64 + 0.5) * 2.6 / n as f64 - 1.3);
            sum += f(Vector::from(x));
        }
        let each = start.elapsed().as_secs_f64() / (n * n * n) as f64;
        println!("{name}: {:.0} ns per point (sum {sum:.3})", 1e9 * each);
    };
    for shape in smooth::<3>() {
        let name: String = format!("{shape:?}").chars().take(14).collect();
        time(&name, &|x| shape.signed_distance(&x));
    }
    time("plane_box_fraction", &|x| plane_box_fraction(0.4 * x[0], [x[1], x[2], 0.3]));
    let grid = crate::grid::Grid::<3>::new([n; 3], 2.6 / n as f64);
    let mut phi = crate::grid::CellField::new(grid, 0.0);
    let mut runs = Vec::new();
    for k in 0..phi.data.len() {
        phi.data[k] = (grid.center(grid.lattice().coordinates(k)) - Vector::repeat(1.3)).norm() - 0.8;
        if phi.data[k] < 0.0 {
            let (row, start) = ((k / n) as u32, (k % n) as u32);
            runs.push(crate::grid::Run { row, start, end: start + 1, component: 0 });
        }
    }
    let surface = crate::mesh::extract_isosurface(&phi, &crate::grid::Runs { runs, components: 1 }).mesh;
    let facets = surface.facets.len();
    let mesh = MeshShape::new(surface.transformed(1.0, &Matrix::identity(), &Vector::repeat(-1.3)));
    time(&format!("mesh of {facets} facets"), &|x| mesh.signed_distance(&x));
    let shape = Shape::Mesh(Arc::new(mesh));
    let start = std::time::Instant::now();
    shape.signed_distance_field(crate::grid::Grid::<3>::new([192; 3], 1.0 / 192.0));
    println!("mesh of {facets} facets sampled at 192^3 cells in {:.2} s", start.elapsed().as_secs_f64());
}
