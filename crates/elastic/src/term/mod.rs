//! Force terms of deformable solids.

pub mod continuum;
pub mod corotated;
pub mod discrete_gradient;
pub mod energy_density;
pub mod extra_stiffness;
pub mod inversion_barrier;
mod logarithm;
pub mod neo_hookean;
pub mod quadrature;
pub mod springs;
pub mod surface_tension;

use crate::linalg::{BlockMatrix, Cliques};
use meniscus_numerics::{Matrix, Vector};
use std::fmt::Debug;

/// Weights of the tangents that a term adds to a matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TangentWeights {
    /// Weight of the stiffness `K`, the Hessian of the energy.
    pub stiffness: f64,
    /// Whether the stiffness is projected to its positive semidefinite part.
    pub project_psd: bool,
    /// Weight of the stiffness `K̂` against rates of strain, to which damping is proportional; it vanishes for rigid motions at any
    /// stress.
    pub viscosity: f64,
}

/// A term of the elastic energy, or of the energy of a load that has a potential.
pub trait ForceTerm<const D: usize>: Debug + Send + Sync {
    /// Groups of coupled vertices, which determine the blocks of the tangents.
    fn couplings(&self) -> &Cliques;

    /// Energy, J (2D: J/m), at positions, m.
    fn energy(&self, x: &[Vector<D>]) -> f64;

    /// Adds the forces, N (2D: N/m): minus the gradient of the energy. Their sum and their torque vanish to rounding, except those of
    /// a load from outside.
    fn add_forces(&self, x: &[Vector<D>], forces: &mut [Vector<D>]);

    /// Adds the viscous forces `−time K̂ v`, N (2D: N/m), with `time` in s. They dissipate energy and conserve both momenta.
    fn add_viscous_forces(&self, x: &[Vector<D>], v: &[Vector<D>], time: f64, forces: &mut [Vector<D>]);

    /// Adds to the sums of each vertex the volumes at rest, m³ (2D: m²), of the elements around it, and the products of these and
    /// of their Cauchy stress, Pa. Nothing for terms that are no continuum.
    fn add_stress_sums(&self, _: &[Vector<D>], _: &mut [(f64, Matrix<D>)]) {}

    /// Adds the tangents, N/m (2D: N/m²); the matrix must have a block for every pair of a group in [`Self::couplings`].
    fn add_tangent(&self, x: &[Vector<D>], weights: TangentWeights, matrix: &mut BlockMatrix<D>);
}

/// A term with discrete-gradient forces between two configurations `x₀` and `x₁`: their work is the decrease of its energy
/// (`discrete_gradient.rs`).
pub trait DiscreteGradientTerm<const D: usize>: ForceTerm<D> {
    /// Adds these forces, N (2D: N/m). Their sum and their torque about the midpoint configuration vanish, except
    /// those of a load from outside.
    fn add_forces_between(&self, ends: [&[Vector<D>]; 2], forces: &mut [Vector<D>]);
}
