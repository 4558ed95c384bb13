//! The tensions of the surface of a deformable solid, wetted and dry (erratum E12).
//!
//! ```text
//! f_k = −Σ (w Υ_ls + (1 − w) Υ_sa) ∂A/∂x_k   over the facets at vertex k, each with its wetted part w
//! ```
//!
//! The forces of a facet add up to nothing, and so do their moments: the surface of a solid pulls at no solid as a whole. Rigid solids do
//! not feel it.
//!
//! Limit: within a facet the tension is the mean of both.

use crate::paper::Tensions;
use meniscus_numerics::Vector;
use meniscus_numerics::mesh::SurfaceMesh;

/// Forces on the vertices of a surface, N (2D: N/m), with the level set of its contact line, m.
pub fn tension_forces<const D: usize>(
    mesh: &SurfaceMesh<D>,
    phi_c: &[f64],
    tensions: &(dyn Fn(&Vector<D>) -> Tensions + Sync),
) -> Vec<Vector<D>> {
    let mut forces = vec![Vector::zeros(); mesh.positions.len()];
    for (f, facet) in mesh.facets.iter().enumerate() {
        let corners = mesh.corners(f);
        let wetted = wetted_part(&facet.map(|v| phi_c[v as usize]));
        let own = tensions(&(corners.iter().sum::<Vector<D>>() / D as f64));
        let tension = wetted * own.liquid_solid + (1.0 - wetted) * own.solid_air;
        let area = mesh.area_vector(f).norm();
        for (k, v) in facet.iter().enumerate() {
            let height = height(&corners, k);
            let square = height.norm_squared();
            if square > 0.0 {
                forces[*v as usize] -= height * (tension * area / square);
            }
        }
    }
    forces
}

/// The vector from the opposite edge (2D: vertex) of a facet to a vertex, normal to that edge.
fn height<const D: usize>(corners: &[Vector<D>; D], k: usize) -> Vector<D> {
    let [a, b] = [corners[(k + 1) % D], corners[(k + D - 1) % D]];
    let way = corners[k] - a;
    let along = (b - a).try_normalize(0.0).unwrap_or(Vector::zeros());
    way - along * way.dot(&along)
}

/// The part of a facet in which the linear interpolant of values at its vertices is negative.
fn wetted_part<const D: usize>(values: &[f64; D]) -> f64 {
    let is_wet = values.map(|value| value < 0.0);
    let count = is_wet.iter().filter(|wet| **wet).count();
    if count == 0 || count == D {
        return if count == 0 { 0.0 } else { 1.0 };
    }
    // The vertex that is alone on its side: in 2D either.
    let alone = (0..D).find(|k| (0..D).filter(|j| is_wet[*j] == is_wet[*k]).count() == 1).unwrap_or(0);
    let others = (0..D).filter(|j| *j != alone);
    let part: f64 = others.map(|j| values[alone] / (values[alone] - values[j])).product();
    if is_wet[alone] { part } else { 1.0 - part }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TENSIONS: Tensions = Tensions { liquid_air: 1.0, liquid_solid: 0.3, solid_air: 0.7 };

    fn energy<const D: usize>(mesh: &SurfaceMesh<D>, phi_c: &[f64]) -> f64 {
        let of = |f: usize| {
            let wetted = wetted_part(&mesh.facets[f].map(|v| phi_c[v as usize]));
            (0.7 - 0.4 * wetted) * mesh.area_vector(f).norm()
        };
        (0..mesh.facets.len()).map(of).sum()
    }

    fn forces_are_slopes<const D: usize>() {
        let place = |i: usize| Vector::<D>::from_fn(|a, _| ((i * 7 + a * 3) as f64 * 1.3).sin());
        let facets = vec![std::array::from_fn(|k| k as u32), std::array::from_fn(|k| (k + 1) as u32)];
        let mesh = SurfaceMesh { positions: (0..D + 1).map(place).collect(), facets };
        let phi_c: Vec<f64> = (0..D + 1).map(|i| [-0.4, 0.3, -0.7, 0.2][i]).collect();
        let forces = tension_forces(&mesh, &phi_c, &|_| TENSIONS);
        assert!(forces.iter().sum::<Vector<D>>().norm() < 1e-14);
        for (v, a) in (0..D + 1).flat_map(|v| (0..D).map(move |a| (v, a))) {
            let moved = |by: f64| {
                let mut mesh = mesh.clone();
                mesh.positions[v][a] += by;
                energy(&mesh, &phi_c)
            };
            let slope = (moved(1e-6) - moved(-1e-6)) / 2e-6;
            assert!((slope + forces[v][a]).abs() < 1e-8, "{v} {a}: {slope} {}", forces[v][a]);
        }
    }

    #[test]
    fn the_forces_are_the_slopes_of_the_energy_of_the_surface() {
        forces_are_slopes::<2>();
        forces_are_slopes::<3>();
        assert_eq!(wetted_part(&[-1.0, 1.0]), 0.5);
        assert_eq!(wetted_part(&[-1.0, 1.0, 1.0]), 0.25);
        assert_eq!(wetted_part(&[1.0, -1.0, -1.0]), 0.75);
    }
}
