//! Distances and lengths on a solid's surface, on which the contact-line extraction relies.

use crate::measure::{at_least, at_most, bars, convergence_order};
use crate::{Bars, Case, Check};
use meniscus_numerics::Vector;
use meniscus_numerics::mesh::icosphere::icosphere;
use meniscus_numerics::mesh::{Contour, Geodesic};
use std::f64::consts::TAU;

/// Distances.
pub const DISTANCE: Case = Case {
    name: "mesh-distance",
    title: "Distance along a surface",
    theory: "On the unit sphere as 642, 2562 and 10242 vertices (icosphere) the distance from the circle of \
        colatitude 1 rad is the difference in colatitude. Fast marching from the circle's contour, mean error \
        within 0.5 rad of it, the worse of a pole on an axis and off all axes. Planar fronts, as in the paper, \
        have 1.05e-3 at 2562 vertices and order 1; exact distances on the polyhedron are of second order.",
    quick: true,
    run: |_| distance(),
};

/// Lengths.
pub const LENGTH: Case = Case {
    name: "contour-length",
    title: "Length of a contour on a surface",
    theory: "On the same spheres the contour (marching triangles) of the colatitude at 1 rad is 2π sin 1 long; relative \
        error at 2562 vertices, the worse of the two poles, and its order.",
    quick: true,
    run: |_| length(),
};

/// Colatitude of the circle, rad.
const COLATITUDE: f64 = 1.0;
/// Half-width of the band in which distances are compared, rad.
const BAND: f64 = 0.5;
/// Subdivision levels of the icospheres.
const LEVELS: [usize; 3] = [3, 4, 5];

/// Mean error of the distance and relative error of the length on one sphere.
fn errors(level: usize, pole: &Vector<3>) -> [f64; 2] {
    let mesh = icosphere(level);
    let exact: Vec<f64> =
        mesh.positions.iter().map(|x| x.dot(pole).clamp(-1.0, 1.0).acos() - COLATITUDE).collect();
    let contour = Contour::of(&mesh.facets, &exact);
    let geodesic = Geodesic::new(&mesh.positions, &mesh.facets);
    let found = geodesic.distance(&mesh, &contour, &exact, 1.5 * BAND);
    let within: Vec<(f64, f64)> = exact.into_iter().zip(found).filter(|(e, _)| e.abs() < BAND).collect();
    let mean = within.iter().map(|(e, f)| (e - f).abs()).sum::<f64>() / within.len() as f64;
    let at = contour.positions(&mesh);
    let length: f64 = contour.segments.iter().map(|s| (at[s[1] as usize] - at[s[0] as usize]).norm()).sum();
    [mean, (length / (TAU * COLATITUDE.sin()) - 1.0).abs()]
}

/// The larger errors of the two poles, against the mean edge length, per sphere.
fn worst(which: usize) -> Vec<(f64, f64)> {
    let poles = [Vector::<3>::new(0.0, 0.0, 1.0), Vector::<3>::new(0.36, -0.48, 0.8)];
    let error = |level: usize| poles.iter().map(|p| errors(level, p)[which]).fold(0.0, f64::max);
    LEVELS.iter().map(|l| (0.5f64.powi(*l as i32), error(*l))).collect()
}

/// Checks of the error on the middle sphere, and of its order; `order` has the bar and the aim of it.
fn checks(case: &str, what: &str, errors: &[(f64, f64)], bars: Bars, order: [f64; 2]) -> Vec<Check> {
    let all: Vec<String> = errors.iter().map(|e| format!("{:.1e}", e.1)).collect();
    vec![
        at_most(case, format!("{what}, 2562 vertices"), errors[1].1, bars),
        at_least(
            case,
            format!("its order ({})", all.join(", ")),
            convergence_order(errors),
            order[0],
            order[1],
        ),
    ]
}

fn distance() -> Vec<Check> {
    checks("mesh-distance", "mean error of the distance", &worst(0), bars(1e-3, 5e-4), [1.0, 2.0])
}

fn length() -> Vec<Check> {
    checks("contour-length", "relative error of the length", &worst(1), bars(2e-3, 1e-3), [1.8, 2.0])
}
