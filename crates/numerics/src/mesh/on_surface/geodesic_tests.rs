use super::*;
use crate::mesh::icosphere::icosphere;

/// Mean and largest error of the distance from the circle of colatitude 1 about `pole` within `band` of it, and the
/// relative error of its length.
fn errors(mesh: &SurfaceMesh<3>, pole: Vector<3>, band: f64) -> (f64, f64, f64) {
    let exact: Vec<f64> = mesh.positions.iter().map(|x| x.normalize().dot(&pole).acos() - 1.0).collect();
    let contour = Contour::of(&mesh.facets, &exact);
    let geodesic = Geodesic::new(&mesh.positions, &mesh.facets);
    let found = geodesic.distance(mesh, &contour, &exact, band + 0.2);
    let errors: Vec<f64> =
        exact.iter().zip(&found).filter(|(e, _)| e.abs() < band).map(|(e, f)| (e - f).abs()).collect();
    let at = contour.positions(mesh);
    let length: f64 = contour.segments.iter().map(|s| (at[s[1] as usize] - at[s[0] as usize]).norm()).sum();
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    (mean, errors.iter().fold(0.0, |m, e| e.max(m)), length / (TAU * 1.0f64.sin()) - 1.0)
}

/// A sphere stretched so that many triangles are obtuse, with its vertices projected back onto it.
fn squeezed(level: usize) -> (SurfaceMesh<3>, usize) {
    let mut mesh = icosphere(level);
    let squeeze = |x: &Vector<3>| Vector::<3>::new(x[0], 0.7 * x[1] + 0.2 * x[0], 1.6 * x[2]).normalize();
    mesh.positions.iter_mut().for_each(|x| *x = squeeze(x));
    let obtuse = |f: &&[u32; 3]| {
        (0..3).any(|k| {
            let [a, b, c] = [k, k + 1, k + 2].map(|k| mesh.positions[f[k % 3] as usize]);
            (b - a).dot(&(c - a)) < 0.0
        })
    };
    let count = mesh.facets.iter().filter(obtuse).count();
    (mesh, count)
}

#[test]
fn geodesic_distance_from_a_circle_on_a_sphere() {
    for pole in [Vector::<3>::new(0.0, 0.0, 1.0), Vector::<3>::new(0.36, -0.48, 0.8)] {
        let [coarse, middle, fine] = [3, 4, 5].map(|level| errors(&icosphere(level), pole, 0.5));
        println!("{coarse:?} {middle:?} {fine:?}");
        assert!(middle.0 < 5e-4 && middle.1 < 2e-3, "{middle:?}");
        assert!(coarse.0 / fine.0 > 8.0, "order below 1.5: {coarse:?} {fine:?}");
        assert!(middle.2.abs() < 1e-3 && (coarse.2 / fine.2 - 16.0).abs() < 3.0, "length: {middle:?}");
    }
}

#[test]
fn geodesic_distance_on_obtuse_triangles() {
    let pole = Vector::<3>::new(0.36, -0.48, 0.8);
    let [coarse, fine] = [4, 5].map(|level| {
        let (mesh, obtuse) = squeezed(level);
        assert!(4 * obtuse > mesh.facets.len(), "{obtuse} of {}", mesh.facets.len());
        errors(&mesh, pole, 0.5)
    });
    println!("{coarse:?} {fine:?}");
    assert!(coarse.0 < 2e-3 && coarse.0 / fine.0 > 2.0, "{coarse:?} {fine:?}");
}

#[test]
fn geodesic_distance_across_a_crease_and_along_segments() {
    // For a sheet folded at a right angle the distance equals that on the flat sheet.
    let n = 24;
    let flat = |i: usize, j: usize| [i as f64 / n as f64 + 0.013 * (j % 2) as f64, j as f64 / n as f64];
    let fold = |[x, y]: [f64; 2]| {
        if x < 0.513 { Vector::<3>::new(x, y, 0.0) } else { Vector::<3>::new(0.513, y, x - 0.513) }
    };
    // A column of vertices lies in the crease.
    let crease = |i: usize, p: [f64; 2]| if i == n / 2 { [0.513, p[1]] } else { p };
    let points: Vec<[f64; 2]> =
        (0..=n).flat_map(|j| (0..=n).map(move |i| (i, j))).map(|(i, j)| crease(i, flat(i, j))).collect();
    let at = |i: usize, j: usize| (j * (n + 1) + i) as u32;
    let quad = |i: usize, j: usize| {
        let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
        [[a, b, c], [a, c, d]]
    };
    let facets = (0..n).flat_map(|j| (0..n).flat_map(move |i| quad(i, j))).collect();
    let mesh = SurfaceMesh { positions: points.iter().map(|p| fold(*p)).collect(), facets };
    let exact: Vec<f64> = points.iter().map(|[x, y]| 0.8 * x + 0.6 * y - 0.43).collect();
    let contour = Contour::of(&mesh.facets, &exact);
    let found = Geodesic::new(&mesh.positions, &mesh.facets).distance(&mesh, &contour, &exact, 2.0);
    // Points whose nearest point of the line is not one of its ends.
    let from_line = |p: &[f64; 2], d: f64| {
        let foot = [p[0] - 0.8 * d, p[1] - 0.6 * d];
        foot.iter().all(|c| (0.15..0.85).contains(c))
    };
    for ((p, e), f) in points.iter().zip(&exact).zip(&found).filter(|((p, e), _)| from_line(p, **e)) {
        assert!((e - f).abs() < 1e-9, "{p:?}: {f} for {e}");
    }

    let positions: Vec<Vector<2>> =
        (0..40).map(|i| Vector::<2>::new((0.1 * f64::from(i)).sin(), 0.0)).collect();
    let facets: Vec<[u32; 2]> = (0..39).map(|i| [i, i + 1]).collect();
    let line = SurfaceMesh { positions, facets };
    let values: Vec<f64> = (0..40).map(|i| f64::from(i) - 7.3).collect();
    let contour = Contour::of(&line.facets, &values);
    let found = Geodesic::new(&line.positions, &line.facets).distance(&line, &contour, &values, 0.4);
    let middle = contour.points[0].position(&line)[0];
    assert!(contour.segments.is_empty() && contour.points.len() == 1);
    for (x, d) in line.positions.iter().zip(&found).take(15) {
        assert!((d - (x[0] - middle).clamp(-0.4, 0.4)).abs() < 1e-12, "{d} at {x}");
    }
}

#[test]
fn contours_are_closed_loops_with_the_negative_side_on_the_left() {
    let mesh = icosphere(3);
    let values: Vec<f64> =
        mesh.positions.iter().map(|x| x[0].sin() * x[1] + 0.3 * (5.0 * x[2]).cos() - 0.1).collect();
    let contour = Contour::of(&mesh.facets, &values);
    let (mut starts, mut ends) = (vec![0; contour.points.len()], vec![0; contour.points.len()]);
    for [a, b] in &contour.segments {
        starts[*a as usize] += 1;
        ends[*b as usize] += 1;
    }
    assert!(contour.points.len() > 50 && starts.iter().chain(&ends).all(|n| *n == 1));
    let at = contour.positions(&mesh);
    for (s, f) in contour.segments.iter().zip(&contour.facets) {
        let [a, b] = s.map(|p| at[p as usize]);
        for v in mesh.facets[*f as usize] {
            let left = mesh.area_vector(*f as usize).dot(&(b - a).cross(&(mesh.positions[v as usize] - a)));
            assert!(left * values[v as usize] < 1e-12, "{left} {}", values[v as usize]);
        }
    }
}
