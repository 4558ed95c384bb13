//! The tension of a solid's own surface.

use super::{ForceTerm, Weights};
use crate::linalg::{BlockMatrix, Cliques};
use meniscus_numerics::mesh::surface::{area_curvature, area_slopes, area_stiffness, area_vector};
use meniscus_numerics::mesh::{SurfaceMesh, VolumeMesh};
use meniscus_numerics::{Vector, par};

/// The same energy `γ_s` for every part of a mesh's surface, however stretched: a tension (design, validation §4, 9, `Υs`; a
/// tension that strain changes, Shuttleworth's, is left out).
#[derive(Clone, Debug)]
pub struct SurfaceTension {
    facets: Cliques,
    /// `γ_s`, N/m.
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

    /// A facet's vertices, and where they are.
    fn facet<const D: usize>(&self, k: usize, x: &[Vector<D>]) -> ([u32; D], [Vector<D>; D]) {
        let vertices: [u32; D] = std::array::from_fn(|i| self.facets.get(k)[i]);
        (vertices, vertices.map(|v| x[v as usize]))
    }
}

impl<const D: usize> ForceTerm<D> for SurfaceTension {
    fn couplings(&self) -> &Cliques {
        &self.facets
    }

    fn energy(&self, x: &[Vector<D>]) -> f64 {
        self.tension * par::sum(self.facets.len(), |k| area_vector(&self.facet(k, x).1).norm())
    }

    fn add_forces(&self, x: &[Vector<D>], forces: &mut [Vector<D>]) {
        for k in 0..self.facets.len() {
            let (vertices, corners) = self.facet(k, x);
            let slopes = area_slopes(&corners);
            (0..D).for_each(|i| forces[vertices[i] as usize] -= slopes[i] * self.tension);
        }
    }

    fn add_viscous_forces(&self, _: &[Vector<D>], _: &[Vector<D>], _: f64, _: &mut [Vector<D>]) {}

    fn add_tangent(&self, x: &[Vector<D>], weights: Weights, matrix: &mut BlockMatrix<D>) {
        for k in 0..self.facets.len() {
            let (vertices, corners) = self.facet(k, x);
            let of = if weights.positive { area_stiffness } else { area_curvature };
            let stiffness = of(&corners);
            for i in 0..D {
                for j in i..D {
                    let block = stiffness[i][j] * (self.tension * weights.stiffness);
                    let there = matrix.add(vertices[i], vertices[j], &block);
                    debug_assert!(there, "a facet without a block");
                }
            }
        }
    }
}
