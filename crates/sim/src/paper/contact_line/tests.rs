use super::RADIUS_CELLS;
use super::forces::InterfaceSamples;
use super::level_set::{OFFSET_CELLS, contact_line_level_set};
use super::line_mesh::LineMesh;
use super::mass::{control_volume_mass, intrinsic_mass};
use super::plane_fit::FittedPlane;
use super::repair::Chains;
use crate::model::Wall;
use crate::paper::Tensions;
use crate::paper::fluid::cells::CellTypes;
use crate::paper::fluid::fractions::{closed_along_solids, virtual_density};
use meniscus_numerics::Vector;
use meniscus_numerics::grid::{BoundaryExtension, Grid, Sampler};
use meniscus_numerics::mesh::icosphere::icosphere;
use meniscus_numerics::mesh::{Geodesic, SurfaceMesh};
use std::f64::consts::PI;

/// A flat surface at the height `y`, its normal along the second axis, with edges of `1/n`.
fn flat<const D: usize>(n: usize, y: f64) -> SurfaceMesh<D> {
    let across = if D == 2 { 1 } else { n + 1 };
    let place = |v: usize| {
        let at = [(v % (n + 1)) as f64 / n as f64, y, (v / (n + 1)) as f64 / n as f64];
        Vector::from_fn(|a, _| at[a])
    };
    let at = |i: usize, k: usize| (k * (n + 1) + i) as u32;
    let mut facets: Vec<[u32; D]> = Vec::new();
    for i in 0..n {
        if D == 2 {
            facets.push(std::array::from_fn(|k| at(i + 1 - k, 0)));
            continue;
        }
        for k in 0..n {
            let corners =
                [[at(i, k), at(i, k + 1), at(i + 1, k)], [at(i, k + 1), at(i + 1, k + 1), at(i + 1, k)]];
            facets.extend(corners.map(|c| std::array::from_fn(|j| c[j])));
        }
    }
    SurfaceMesh { positions: (0..(n + 1) * across).map(place).collect(), facets }
}

/// A circle as a polygon, or a sphere, of a radius around the middle of the unit cube.
fn round<const D: usize>(radius: f64) -> SurfaceMesh<D> {
    let middle = Vector::repeat(0.5);
    if D == 2 {
        let n = 160;
        let at = |i: usize| 2.0 * PI * i as f64 / n as f64;
        let place = |i| middle + Vector::from_fn(|a, _| radius * [at(i).cos(), at(i).sin()][a]);
        let edge = |i: usize| std::array::from_fn(|k| ((i + k) % n) as u32);
        return SurfaceMesh { positions: (0..n).map(place).collect(), facets: (0..n).map(edge).collect() };
    }
    let sphere = icosphere(4);
    SurfaceMesh {
        positions: sphere.positions.iter().map(|x| middle + Vector::from_fn(|a, _| radius * x[a])).collect(),
        facets: sphere.facets.iter().map(|f| std::array::from_fn(|k| f[k])).collect(),
    }
}

fn level_set<const D: usize>(
    mesh: &SurfaceMesh<D>,
    phi: &(dyn Fn(&Vector<D>) -> f64 + Sync),
    dx: f64,
) -> Vec<f64> {
    contact_line_level_set(mesh, &Geodesic::new(&mesh.positions, &mesh.facets), phi, [dx, OFFSET_CELLS * dx])
}

/// A liquid up to the height `y` around a fixed ball: of dry points the nearest liquid is the line, on wetted ones φ has noise.
fn line_around_a_ball<const D: usize>() {
    let (radius, y, dx) = (0.3, 0.58, 0.05);
    let mesh = round::<D>(radius);
    let (along, rise) = ((radius * radius - 0.08f64 * 0.08).sqrt(), 0.08);
    let phi = |x: &Vector<D>| {
        let from_middle = x - Vector::repeat(0.5);
        let across = (from_middle.norm_squared() - from_middle[1].powi(2)).max(0.0).sqrt();
        let noise = 0.02 * dx * (97.0 * x[0] + 53.0 * x[1]).sin();
        if x[1] <= y { noise } else { (across - along).hypot(from_middle[1] - rise) }
    };
    let line = LineMesh::new(&mesh, &level_set(&mesh, &phi, dx));
    let off = line.particles.iter().map(|p| (p.at[1] - y).abs()).fold(0.0, f64::max);
    println!("{D}D: {off:.2e} with {} particles", line.particles.len());
    assert!(off < 0.1 * dx, "{off}");
    if D == 2 {
        assert!(line.particles.len() == 2 && line.particles.iter().all(|p| p.length == 1.0));
        return;
    }
    let length: f64 = line.particles.iter().map(|p| p.length).sum();
    assert!((length / (2.0 * PI * along) - 1.0).abs() < 1e-2, "{length}");
    assert!(line.segments.len() == line.particles.len());
    for p in &line.particles {
        let radial = p.at - Vector::repeat(0.5);
        assert!(p.tangent.dot(&radial).abs() < 0.05 && p.tangent[1].abs() < 0.15, "{}", p.tangent);
        let corners = mesh.corners(p.facet as usize);
        let at: Vector<D> = (0..D).map(|k| corners[k] * p.weights[k]).sum();
        assert!((at - p.at).norm() < 1e-12);
    }
}

#[test]
fn enlarge_and_shrink_finds_the_line_around_a_ball() {
    line_around_a_ball::<2>();
    line_around_a_ball::<3>();
}

#[test]
fn the_line_is_where_the_offset_lies_along_the_surface_and_too_far_out_under_overhanging_liquid() {
    let (dx, x0) = (0.05, 0.4137);
    let mesh = flat::<2>(60, 0.3);
    for (degrees, error) in [(30.0, 0.0), (90.0, 0.0), (150.0, 1.0), (120.0, 1.0 / (PI / 3.0).sin() - 1.0)] {
        let rise = if degrees > 90.0 { f64::to_radians(degrees).sin() } else { 1.0 };
        let phi = |x: &Vector<2>| (rise * (x[0] - x0)).max(0.0);
        let line = LineMesh::new(&mesh, &level_set(&mesh, &phi, dx));
        let off = (line.particles[0].at[0] - x0) / (OFFSET_CELLS * dx);
        assert!(line.particles.len() == 1 && (off - error).abs() < 0.02, "{degrees}: {off} {error}");
    }
}

#[test]
fn small_wetted_parts_keep_their_line_and_a_surface_near_liquid_or_all_wet_has_none() {
    let mesh = flat::<2>(60, 0.3);
    let bump = |x: &Vector<2>| ((x[0] - 0.5).abs() - 0.01).max(0.0);
    assert_eq!(LineMesh::new(&mesh, &level_set(&mesh, &bump, 0.05)).particles.len(), 2);
    let near = |x: &Vector<2>| (x[0] - 0.5).abs() + 0.04;
    assert!(LineMesh::new(&mesh, &level_set(&mesh, &near, 0.05)).particles.is_empty());
    assert!(LineMesh::new(&mesh, &level_set(&mesh, &|_| -0.01, 0.05)).particles.is_empty());
    assert!(LineMesh::new(&mesh, &level_set(&mesh, &|_| 0.3, 0.05)).particles.is_empty());
}

#[test]
fn edges_of_the_line_are_even_after_the_repair_and_loops_stay_closed() {
    let n = 60;
    let angle = |i: usize| 2.0 * PI * (i as f64 + 0.45 * (3.7 * i as f64).sin()) / n as f64;
    let positions: Vec<Vector<3>> = (0..n)
        .map(|i| Vector::<3>::new(angle(i).cos(), angle(i).sin(), 0.1 * (3.0 * angle(i)).cos()))
        .collect();
    let segments: Vec<[u32; 2]> = (0..n as u32).map(|i| [i, (i + 1) % n as u32]).collect();
    let length = |c: &Chains<3>| -> Vec<f64> {
        let ends = |s: &[u32; 2]| s.map(|v| c.positions[v as usize]);
        c.segments().iter().map(|s| (ends(s)[1] - ends(s)[0]).norm()).collect()
    };
    let mut chains = Chains::new(positions, &segments);
    let before = length(&chains);
    chains.repair();
    let after = length(&chains);
    let mean = before.iter().sum::<f64>() / n as f64;
    assert!(after.iter().all(|l| (0.5 * mean..2.0 * mean).contains(l)), "{after:?} {mean}");
    assert!(before.iter().any(|l| *l < 0.5 * mean) && before.iter().any(|l| *l > 1.5 * mean));
    assert!((after.iter().sum::<f64>() / before.iter().sum::<f64>() - 1.0).abs() < 0.05);
    let mut counts = vec![[0; 2]; chains.positions.len()];
    chains.segments().iter().for_each(|[a, b]| (counts[*a as usize][0] += 1, counts[*b as usize][1] += 1).0);
    assert!(counts.iter().all(|c| *c == [1, 1]) && counts.len() == after.len());

    // An open chain with a short end, and a loop of three points that may not shrink.
    let open = [0.0, 0.1, 1.1, 2.1, 4.1].map(|x| Vector::<3>::new(x, 0.0, 0.0)).to_vec();
    let mut chains = Chains::new(open, &[[0, 1], [1, 2], [2, 3], [3, 4]]);
    chains.repair();
    let after = length(&chains);
    assert!(after.len() == 4 && after.iter().all(|l| (0.9..1.1).contains(l)), "{after:?}");
    let tiny = [[0.0, 0.0], [1.0, 0.0], [0.0, 1e-3]].map(|x| Vector::<3>::new(x[0], x[1], 0.0)).to_vec();
    let mut chains = Chains::new(tiny, &[[0, 1], [1, 2], [2, 0]]);
    chains.repair();
    assert!(chains.segments().len() >= 3);
}

/// Liquid at `x < 0.5` on a solid below `y = 0.5`: a quarter of the ball is liquid, and half of it solid.
fn mass_of_quarters<const D: usize>(radius_cells: f64) -> f64 {
    let (n, densities) = (24, [1.0, 2.5]);
    let grid = Grid::<D>::new([n; D], 1.0 / n as f64);
    let lattice = grid.lattice();
    let solid = |x: &Vector<D>| x[1] - 0.507;
    let of = |of: &dyn Fn(&Vector<D>) -> f64| -> Vec<f64> {
        (0..lattice.len()).map(|c| of(&grid.center(lattice.coordinates(c)))).collect()
    };
    let phi = closed_along_solids(&grid, &of(&|x| x[0] - 0.493), &solid);
    let psi = of(&solid);
    let [phi, psi] = [&phi, &psi].map(|data| Sampler::cells(&grid, data, [[BoundaryExtension::Even; 2]; D]));
    let density = virtual_density(&grid, &phi, &psi, densities);
    let mut center = Vector::repeat(0.5);
    (center[0], center[1]) = (0.493, 0.507);
    let radius = radius_cells * grid.dx;
    let ball = if D == 2 { PI * radius.powi(2) } else { 4.0 / 3.0 * PI * radius.powi(3) };
    control_volume_mass(&grid, &density, &center, radius)
        / (ball * (0.25 * densities[0] + 0.5 * densities[1]))
        - 1.0
}

#[test]
fn the_mass_of_a_particle_is_the_integral_of_the_virtual_density() {
    for errors in [[3.0, 6.0].map(mass_of_quarters::<2>), [3.0, 6.0].map(mass_of_quarters::<3>)] {
        println!("{errors:?}");
        assert!(errors[0].abs() < 0.04 && errors[1].abs() < 0.01, "{errors:?}");
    }
    assert_eq!(intrinsic_mass(2.0, 0.1, 1.0), 2e-4);
}

fn planes_are_exact<const D: usize>() {
    let normal = Vector::<D>::from_fn(|a, _| [0.36, -0.48, 0.8][a]).normalize();
    let spread = |i: usize| Vector::<D>::from_fn(|a, _| ((i * 31 + a * 17) as f64 * 0.7).sin());
    let through = Vector::<D>::from_fn(|a, _| [3.0, -2.0, 1.0][a]);
    let points: Vec<Vector<D>> =
        (0..9).map(|i| through + spread(i) - normal * normal.dot(&spread(i))).collect();
    let plane = FittedPlane::new(&points).unwrap();
    assert!((plane.normal().dot(&normal).abs() - 1.0).abs() < 1e-14);
    assert!(plane.directions[0].dot(&normal).abs() < 1e-13);
    assert!(normal.dot(&(plane.center - through)).abs() < 1e-13);
    // Seen from beside the points, the tangent leads to them, within the plane and across the line.
    let along = Vector::<D>::from_fn(|a, _| [0.8, 0.6, 0.0][a]);
    let from = plane.center + (points[0] - plane.center) * 5.0;
    let tangent = plane.tangent(&from, &along).unwrap();
    assert!((tangent.norm() - 1.0).abs() < 1e-14 && tangent.dot(&normal).abs() < 1e-13);
    assert!(D == 2 || tangent.dot(&along).abs() < 1e-13);
    assert!(tangent.dot(&(plane.center - from)) > 0.0);

    assert_eq!(FittedPlane::new(&points[..2]), None);
    assert_eq!(FittedPlane::new(&[points[0]; 4]), None);
    let on_a_line: Vec<Vector<D>> = (0..5).map(|i| points[0] + (points[1] - points[0]) * i as f64).collect();
    assert_eq!(FittedPlane::new(&on_a_line).is_some(), D == 2);
}

#[test]
fn planes_through_points_of_a_plane_are_exact() {
    planes_are_exact::<2>();
    planes_are_exact::<3>();
}

/// Largest error of the tangents in degrees, and of the force along the solid over `Υ_la`, at a flat surface that meets a flat solid at an
/// angle, with tensions of that angle.
fn force_errors<const D: usize>(degrees: f64) -> [f64; 2] {
    let n = 32;
    let (x0, y0) = (0.513, 0.3);
    let grid = Grid::<D>::new([n; D], 1.0 / n as f64);
    let lattice = grid.lattice();
    let (sine, cosine) = degrees.to_radians().sin_cos();
    let solid = |x: &Vector<D>| x[1] - y0;
    let plane = |x: &Vector<D>| (x[0] - x0) * sine + (x[1] - y0) * cosine;
    let phi: Vec<f64> = (0..lattice.len()).map(|c| plane(&grid.center(lattice.coordinates(c)))).collect();
    let phi = closed_along_solids(&grid, &phi, &solid);
    let types = CellTypes::new(grid, [[Wall::Slip; 2]; D], &phi, &solid);
    let surface = flat::<D>(48, y0);
    // The exact level set of the line: this test is of the directions.
    let phi_c: Vec<f64> = surface.positions.iter().map(|x| x[0] - x0).collect();
    let line = LineMesh::new(&surface, &phi_c);
    let sampler = Sampler::cells(&grid, &phi, [[BoundaryExtension::Even; 2]; D]);
    let samples = InterfaceSamples::new(&types, &sampler, &surface, &phi_c);
    let tensions = Tensions { liquid_air: 2.0, liquid_solid: 0.3, solid_air: 0.3 + 2.0 * cosine };
    assert!((tensions.young_cosine() - cosine).abs() < 1e-15);
    let (forces, degenerate) = samples.forces(&line, RADIUS_CELLS * grid.dx, &|_| tensions, None);
    assert!(degenerate == 0 && (D == 2 || forces.len() > 30), "{degenerate}");
    let exact = [[-cosine, sine], [-1.0, 0.0], [1.0, 0.0]];
    let mut errors = [0.0f64; 2];
    for (force, particle) in forces.iter().zip(&line.particles) {
        for (t, exact) in force.tangents.iter().zip(exact) {
            let exact = Vector::<D>::from_fn(|a, _| if a < 2 { exact[a] } else { 0.0 });
            errors[0] = errors[0].max(t.unwrap().dot(&exact).clamp(-1.0, 1.0).acos().to_degrees());
        }
        let (along, up) = (force.force[0], force.force[1]);
        errors[1] = errors[1].max((along / particle.length / 2.0).abs());
        assert!((up / particle.length / 2.0 - sine).abs() < 0.1, "{up}");
    }
    if D == 3 {
        let length: f64 = line.particles.iter().map(|p| p.length).sum();
        assert!((length - 1.0).abs() < 1e-9, "{length}");
    }
    errors
}

#[test]
fn tensions_balance_at_youngs_angle_on_flat_interfaces() {
    for degrees in [60.0, 90.0, 120.0] {
        let (flat, space) = (force_errors::<2>(degrees), force_errors::<3>(degrees));
        println!("{degrees}: {flat:?} {space:?}");
        assert!(flat[0] < 6.0 && space[0] < 6.0, "{degrees}: {flat:?} {space:?}");
        assert!(flat[1] < 0.1 && space[1] < 0.1, "{degrees}: {flat:?} {space:?}");
    }
}

#[test]
fn interfaces_with_too_few_samples_pull_at_nothing_and_are_counted() {
    let surface = flat::<2>(48, 0.3);
    let phi_c: Vec<f64> = surface.positions.iter().map(|x| x[0] - 0.513).collect();
    let line = LineMesh::new(&surface, &phi_c);
    let wall = surface.positions.iter().filter(|x| x[0] < 0.513).copied().collect();
    let samples = InterfaceSamples {
        liquid_air: vec![Vector::from([0.5, 0.33]); 2],
        liquid_solid: wall,
        solid_air: Vec::new(),
    };
    let tensions = Tensions { liquid_air: 2.0, liquid_solid: 0.3, solid_air: 1.0 };
    let (forces, degenerate) = samples.forces(&line, 0.1, &|_| tensions, None);
    assert_eq!(degenerate, 2);
    assert!((forces[0].force - Vector::from([-0.3, 0.0])).norm() < 1e-12);
}
