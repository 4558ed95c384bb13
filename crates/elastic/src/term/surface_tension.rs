//! Surface tension of a solid.

use super::{DiscreteGradientTerm, ForceTerm, TangentWeights};
use crate::linalg::{BlockMatrix, Cliques};
use meniscus_numerics::mesh::surface::{area_gradients, area_hessian, area_hessian_psd, area_vector};
use meniscus_numerics::mesh::{SurfaceMesh, VolumeMesh};
use meniscus_numerics::{Matrix, Vector, par};

/// Energy `γ_s` per area of the current surface of a mesh. Limit: the tension does not depend on strain (no Shuttleworth effect).
#[derive(Clone, Debug)]
pub struct SurfaceTension {
    facets: Cliques,
    /// `γ_s`, N/m.
    tension: f64,
}

impl SurfaceTension {
    /// Term on the surface of a mesh; `tension` in N/m.
    pub fn new<const D: usize>(mesh: &VolumeMesh<D>, tension: f64) -> Self {
        let (SurfaceMesh { facets, .. }, vertices) = mesh.surface();
        let mut cliques = Cliques::default();
        facets.iter().for_each(|facet| cliques.push(facet.map(|v| vertices[v as usize])));
        Self { facets: cliques, tension }
    }

    /// Vertices of a facet and their positions.
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
            let slopes = area_gradients(&corners);
            (0..D).for_each(|i| forces[vertices[i] as usize] -= slopes[i] * self.tension);
        }
    }

    fn add_viscous_forces(&self, _: &[Vector<D>], _: &[Vector<D>], _: f64, _: &mut [Vector<D>]) {}

    fn add_tangent(&self, x: &[Vector<D>], weights: TangentWeights, matrix: &mut BlockMatrix<D>) {
        for k in 0..self.facets.len() {
            let (vertices, corners) = self.facet(k, x);
            let of = if weights.project_psd { area_hessian_psd } else { area_hessian };
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

/// With the edges `e_i` from a facet's first corner and their products `C_ij = e_i · e_j` the area is `√(det C)/(D − 1)!`. As
/// `det C₁ − det C₀ = cof C̄ : ΔC`, the discrete gradient is `γ_s Ē S` with `S = 2 cof C̄/((D − 1)!² (A₀ + A₁))`.
impl<const D: usize> DiscreteGradientTerm<D> for SurfaceTension {
    fn add_forces_between(&self, ends: [&[Vector<D>]; 2], forces: &mut [Vector<D>]) {
        for k in 0..self.facets.len() {
            let (vertices, _) = self.facet(k, ends[0]);
            let both = ends.map(|x| self.facet(k, x).1);
            let edge = |corners: &[Vector<D>; D], i: usize| corners[i] - corners[0];
            let mean: [Vector<D>; D] = std::array::from_fn(|i| (edge(&both[0], i) + edge(&both[1], i)) * 0.5);
            let product =
                |i: usize, j: usize| both.iter().map(|c| edge(c, i).dot(&edge(c, j))).sum::<f64>() * 0.5;
            let areas: f64 = both.iter().map(|corners| area_vector(corners).norm()).sum();
            let scale = 2.0 * self.tension / (areas * ((D - 1) * (D - 1)) as f64);
            // The cofactor of a 1×1 matrix is 1.
            let cofactors = if D == 2 {
                Matrix::<2>::identity()
            } else {
                Matrix::<2>::new(product(2, 2), -product(1, 2), -product(1, 2), product(1, 1))
            };
            for i in 1..D {
                let pull: Vector<D> = (1..D).map(|j| mean[j] * (cofactors[(i - 1, j - 1)] * scale)).sum();
                forces[vertices[i] as usize] -= pull;
                forces[vertices[0] as usize] += pull;
            }
        }
    }
}
