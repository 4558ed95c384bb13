//! Springs along the edges of a mesh.

use super::{DiscreteGradientTerm, ForceTerm, TangentWeights};
use crate::linalg::{BlockMatrix, Cliques};
use meniscus_numerics::mesh::VolumeMesh;
use meniscus_numerics::{Matrix, Vector, par};

/// A Hooke spring along every edge of a mesh: energy `k/2 (|x_a − x_b| − l)²`.
#[derive(Clone, Debug)]
pub struct Springs {
    edges: Cliques,
    /// Rest lengths, m.
    rest_lengths: Vec<f64>,
    /// Stiffness of each spring, N/m (2D: N/m²).
    stiffness: f64,
}

impl Springs {
    /// Springs on a mesh at rest; `stiffness` of each edge in N/m (2D: N/m²).
    pub fn new<const D: usize>(mesh: &VolumeMesh<D>, stiffness: f64) -> Self {
        let mut pairs: Vec<[u32; 2]> = Vec::new();
        for simplex in &mesh.simplices {
            let vertices: Vec<u32> = simplex.vertices().collect();
            for (k, a) in vertices.iter().enumerate() {
                pairs.extend(vertices[k + 1..].iter().map(|b| [*a.min(b), *a.max(b)]));
            }
        }
        pairs.sort_unstable();
        pairs.dedup();
        let mut edges = Cliques::default();
        let x = &mesh.positions;
        let rest_lengths = pairs.iter().map(|[a, b]| (x[*b as usize] - x[*a as usize]).norm()).collect();
        pairs.into_iter().for_each(|pair| edges.push(pair));
        Self { edges, rest_lengths, stiffness }
    }

    /// Vertices of an edge, its direction from the first to the second, and its length.
    fn edge<const D: usize>(&self, k: usize, x: &[Vector<D>]) -> (usize, usize, Vector<D>, f64) {
        let [a, b] = [0, 1].map(|end| self.edges.get(k)[end] as usize);
        let along = x[b] - x[a];
        let length = along.norm();
        // A spring of zero length exerts no force.
        (a, b, if length > 0.0 { along / length } else { along }, length)
    }
}

impl<const D: usize> ForceTerm<D> for Springs {
    fn couplings(&self) -> &Cliques {
        &self.edges
    }

    fn energy(&self, x: &[Vector<D>]) -> f64 {
        let stretched = |k| (self.edge(k, x).3 - self.rest_lengths[k]).powi(2);
        0.5 * self.stiffness * par::sum(self.rest_lengths.len(), stretched)
    }

    fn add_forces(&self, x: &[Vector<D>], forces: &mut [Vector<D>]) {
        for k in 0..self.rest_lengths.len() {
            let (a, b, along, length) = self.edge(k, x);
            let pull = along * (self.stiffness * (length - self.rest_lengths[k]));
            forces[a] += pull;
            forces[b] -= pull;
        }
    }

    fn add_viscous_forces(&self, x: &[Vector<D>], v: &[Vector<D>], time: f64, forces: &mut [Vector<D>]) {
        for k in 0..self.rest_lengths.len() {
            let (a, b, along, _) = self.edge(k, x);
            let pull = along * (self.stiffness * time * along.dot(&(v[b] - v[a])));
            forces[a] += pull;
            forces[b] -= pull;
        }
    }

    fn add_tangent(&self, x: &[Vector<D>], weights: TangentWeights, matrix: &mut BlockMatrix<D>) {
        for k in 0..self.rest_lengths.len() {
            let (a, b, along, length) = self.edge(k, x);
            // The transverse stiffness of a compressed spring is negative.
            let across = 1.0 - self.rest_lengths[k] / length;
            let across = if weights.project_psd { across.max(0.0) } else { across };
            let outer = along * along.transpose();
            let block = (outer * (weights.stiffness + weights.viscosity)
                + (Matrix::identity() - outer) * (weights.stiffness * across))
                * self.stiffness;
            let [a, b] = [a as u32, b as u32];
            let there = matrix.add(a, a, &block) & matrix.add(b, b, &block) & matrix.add(a, b, &-block);
            debug_assert!(there, "an edge without a block");
        }
    }
}

/// Follows from `Δ(|d|²) = 2 d̄ · Δd` and `ΔΨ = k/2 (|d₀| + |d₁| − 2 l) (|d₁| − |d₀|)`.
impl<const D: usize> DiscreteGradientTerm<D> for Springs {
    fn add_forces_between(&self, ends: [&[Vector<D>]; 2], forces: &mut [Vector<D>]) {
        for k in 0..self.rest_lengths.len() {
            let [(a, b, _, first), (_, _, _, last)] = ends.map(|x| self.edge(k, x));
            let mean = ends.iter().map(|x| x[b] - x[a]).sum::<Vector<D>>() * 0.5;
            let both = first + last;
            // A spring of zero length exerts no force.
            let pull = if both > 0.0 {
                mean * (self.stiffness * (both - 2.0 * self.rest_lengths[k]) / both)
            } else {
                mean
            };
            forces[a] += pull;
            forces[b] -= pull;
        }
    }
}
