//! The tension of a solid's own surface.

use super::{ForceTerm, Weights};
use crate::linalg::{BlockMatrix, Cliques};
use meniscus_numerics::mesh::surface::area_vector;
use meniscus_numerics::mesh::{SurfaceMesh, VolumeMesh};
use meniscus_numerics::{Vector, par};

/// The same energy for every part of a mesh's surface, however stretched: a tension (no Shuttleworth effect).
#[derive(Clone, Debug)]
pub struct SurfaceTension {
    facets: Cliques,
    /// N/m (2D: N).
    tension: f64,
}

impl SurfaceTension {
    /// On the surface of a mesh; the tension is in N/m.
    pub fn new<const D: usize>(mesh: &VolumeMesh<D>, tension: f64) -> Self {
        let (SurfaceMesh { facets, .. }, vertices) = mesh.surface();
        let mut cliques = Cliques::default();
        facets.iter().for_each(|facet| cliques.push(facet.map(|v| vertices[v as usize])));
        Self { facets: cliques, tension }
    }

    /// Vertices of a facet, the directions from each out of the facet along it times half the size of the side across (2D:
    /// one), which are the slopes of its size, and its size.
    fn facet<const D: usize>(&self, k: usize, x: &[Vector<D>]) -> ([u32; D], [Vector<D>; D], f64) {
        let vertices: [u32; D] = std::array::from_fn(|i| self.facets.get(k)[i]);
        let at = vertices.map(|v| x[v as usize]);
        if D == 2 {
            let along = at[1] - at[0];
            let (length, unit) = (along.norm(), along.try_normalize(0.0).unwrap_or(Vector::zeros()));
            return (vertices, std::array::from_fn(|i| if i == 0 { -unit } else { unit }), length);
        }
        let normal = area_vector(&at);
        let (size, unit) = (normal.norm(), normal.try_normalize(0.0).unwrap_or(Vector::zeros()));
        let slopes = std::array::from_fn(|i| {
            let edge = at[(i + 2) % D] - at[(i + 1) % D];
            Vector::from_fn(|a, _| {
                let (b, c) = ((a + 1) % D, (a + 2) % D);
                0.5 * (unit[b] * edge[c] - unit[c] * edge[b])
            })
        });
        (vertices, slopes, size)
    }
}

impl<const D: usize> ForceTerm<D> for SurfaceTension {
    fn couplings(&self) -> &Cliques {
        &self.facets
    }

    fn energy(&self, x: &[Vector<D>]) -> f64 {
        self.tension * par::sum(self.facets.len(), |k| self.facet(k, x).2)
    }

    fn add_forces(&self, x: &[Vector<D>], forces: &mut [Vector<D>]) {
        for k in 0..self.facets.len() {
            let (vertices, slopes, _) = self.facet(k, x);
            (0..D).for_each(|i| forces[vertices[i] as usize] -= slopes[i] * self.tension);
        }
    }

    fn add_viscous_forces(&self, _: &[Vector<D>], _: &[Vector<D>], _: f64, _: &mut [Vector<D>]) {}

    /// A facet's size changes with heights `u` over it by `½ ∫ |∇u|²`; along itself it has no stiffness that is positive.
    fn add_tangent(&self, x: &[Vector<D>], weights: Weights, matrix: &mut BlockMatrix<D>) {
        for k in 0..self.facets.len() {
            let (vertices, slopes, size) = self.facet(k, x);
            if size == 0.0 {
                continue;
            }
            let normal = area_vector(&vertices.map(|v| x[v as usize])) / size;
            let outer = normal * normal.transpose() * (self.tension * weights.stiffness / size);
            for i in 0..D {
                for j in i..D {
                    let there = matrix.add(vertices[i], vertices[j], &(outer * slopes[i].dot(&slopes[j])));
                    debug_assert!(there, "a facet without a block");
                }
            }
        }
    }
}
