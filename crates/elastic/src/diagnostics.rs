//! Energies, momenta and measures of deformation.

use crate::linalg::svd;
use crate::term::energy_density::{cofactor, determinant};
use crate::term::inversion_barrier::CRUSHED_VOLUME_RATIO;
use crate::{Elastic, ElasticState};
use meniscus_numerics::mesh::Simplex;
use meniscus_numerics::{Matrix, Vector, par, rotation_planes};

impl<const D: usize> Elastic<D> {
    /// Elastic energy at positions, J (2D: J/m).
    pub fn elastic_energy(&self, positions: &[Vector<D>]) -> f64 {
        self.terms.iter().map(|t| t.energy(positions)).sum()
    }

    /// Kinetic energy, J (2D: J/m).
    pub fn kinetic_energy(&self, velocities: &[Vector<D>]) -> f64 {
        0.5 * par::sum(velocities.len(), |v| self.masses[v] * velocities[v].norm_squared())
    }

    /// Elastic and kinetic energy at the time of the velocities, J (2D: J/m).
    ///
    /// Velocities lead positions by half a step, so the elastic energy is taken at `x + ½ dt v`. In steps of
    /// equal length, without damping, loads, moved anchors and crushed elements the sum is constant at any
    /// strain, to the tolerance of Newton's method.
    pub fn energy(&self, state: &ElasticState<D>, dt: f64) -> f64 {
        let ahead = state.positions.iter().zip(&state.velocities).map(|(x, v)| x + v * (0.5 * dt));
        self.elastic_energy(&ahead.collect::<Vec<_>>()) + self.kinetic_energy(&state.velocities)
    }

    /// Momentum, kg m/s (2D: per metre).
    pub fn momentum(&self, state: &ElasticState<D>) -> Vector<D> {
        Vector::from(par::sums(self.masses.len(), |v| (state.velocities[v] * self.masses[v]).into()))
    }

    /// Angular momentum about the origin, kg m²/s (2D: the last entry, per metre).
    pub fn angular_momentum(&self, state: &ElasticState<D>) -> [f64; 3] {
        par::sums(self.masses.len(), |k| {
            let (x, p) = (state.positions[k], state.velocities[k] * self.masses[k]);
            let mut moment = [0.0; 3];
            rotation_planes::<D>().iter().for_each(|(a, b, at)| moment[*at] = x[*a] * p[*b] - x[*b] * p[*a]);
            moment
        })
    }

    /// Smallest volume of an element (2D: area) over its rest volume; zero or negative where an element is inverted.
    pub fn min_volume_ratio(&self, positions: &[Vector<D>]) -> f64 {
        let ratio = |simplex: &Simplex<D>| {
            determinant(&simplex.edges(positions)) / determinant(&simplex.edges(&self.rest_mesh.positions))
        };
        let simplices = &self.rest_mesh.simplices;
        par::reduce(simplices.len(), 1024, f64::INFINITY, |i| ratio(&simplices[i]), f64::min)
    }

    /// Number of elements below [`crate::CRUSHED_VOLUME_RATIO`] of their rest volume, where the inversion barrier acts.
    pub fn crushed_elements(&self, positions: &[Vector<D>]) -> usize {
        let crushed = |simplex: &Simplex<D>| {
            let rest = determinant(&simplex.edges(&self.rest_mesh.positions));
            determinant(&simplex.edges(positions)) < CRUSHED_VOLUME_RATIO * rest
        };
        let crushed = par::map_slice(&self.rest_mesh.simplices, 1024, crushed);
        crushed.into_iter().filter(|crushed| *crushed).count()
    }

    /// Strain at each vertex: the largest |λ − 1| of the principal stretches λ, averaged over the adjacent elements with their rest
    /// volumes as weights.
    pub fn strains(&self, positions: &[Vector<D>]) -> Vec<f64> {
        let of = |simplex: &Simplex<D>| {
            let edges = simplex.edges(&self.rest_mesh.positions);
            let across = cofactor(&edges) / determinant(&edges);
            let stretches = svd(&(simplex.edges(positions) * across.transpose())).values;
            (simplex.volume(&self.rest_mesh.positions), stretches.map(|s| (s - 1.0).abs()).max())
        };
        let all = par::map_slice(&self.rest_mesh.simplices, 1024, of);
        let mut sums = vec![(0.0, 0.0); positions.len()];
        for (simplex, (volume, strain)) in self.rest_mesh.simplices.iter().zip(all) {
            for v in simplex.vertices() {
                let sum = &mut sums[v as usize];
                *sum = (sum.0 + volume, sum.1 + volume * strain);
            }
        }
        sums.into_iter().map(|(volume, sum)| if volume > 0.0 { sum / volume } else { 0.0 }).collect()
    }

    /// Cauchy stress at each vertex, Pa: that of the adjacent elements, with their rest volumes as weights; in 2D the stress in the
    /// plane, under plane strain. `None` for solids that are no continuum, such as springs. Viscous stresses are not in it.
    pub fn cauchy_stresses(&self, positions: &[Vector<D>]) -> Option<Vec<Matrix<D>>> {
        let mut sums = vec![(0.0, Matrix::zeros()); positions.len()];
        self.terms.iter().for_each(|term| term.add_stress_sums(positions, &mut sums));
        let any = sums.iter().any(|(volume, _)| *volume > 0.0);
        let mean = |(volume, sum): (f64, Matrix<D>)| if volume > 0.0 { sum / volume } else { sum };
        any.then(|| sums.into_iter().map(mean).collect())
    }

    /// Green strain `(Fᵀ F − 1)/2` of each element of the mesh, with the deformation gradient `F` of the element as a linear one. A
    /// quadratic element consists of `2^D` of the mesh's elements.
    pub fn green_strains(&self, positions: &[Vector<D>]) -> Vec<Matrix<D>> {
        let of = |simplex: &Simplex<D>| {
            let edges = simplex.edges(&self.rest_mesh.positions);
            let across = cofactor(&edges) / determinant(&edges);
            let f = simplex.edges(positions) * across.transpose();
            (f.transpose() * f - Matrix::identity()) * 0.5
        };
        par::map_slice(&self.rest_mesh.simplices, 1024, of)
    }

    /// Largest Frobenius norm of the rate `Ḟ` of the deformation gradient in an element, 1/s.
    ///
    /// Vertices advance along straight lines, so that rotation stretches elements, but hardly if `dt` is below 0.3 of the reciprocal of
    /// this rate. The stiffness sets no limit.
    pub fn max_deformation_rate(&self, velocities: &[Vector<D>]) -> f64 {
        let rate = |simplex: &Simplex<D>| {
            let edges = simplex.edges(&self.rest_mesh.positions);
            let across = cofactor(&edges) / determinant(&edges);
            (simplex.edges(velocities) * across.transpose()).norm()
        };
        let simplices = &self.rest_mesh.simplices;
        par::reduce(simplices.len(), 1024, 0.0, |i| rate(&simplices[i]), f64::max)
    }
}
