//! What pulls at the vertices: one file a term.

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
use meniscus_numerics::Vector;
use std::fmt::Debug;

/// How much of a term's tangents a matrix takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TangentWeights {
    /// Of the stiffness `K`, the Hessian of the energy.
    pub stiffness: f64,
    /// Whether that is without its negative part, so that the matrix is positive.
    pub project_psd: bool,
    /// Of the stiffness against rates of strain only, which a rigid motion does not feel whatever the stress: what damping
    /// is proportional to.
    pub viscosity: f64,
}

/// A term of the elastic energy.
pub trait ForceTerm<const D: usize>: Debug + Send + Sync {
    /// The groups of vertices that pull at each other: where its tangents have blocks.
    fn couplings(&self) -> &Cliques;

    /// Energy, J (2D: J/m), at positions, m.
    fn energy(&self, x: &[Vector<D>]) -> f64;

    /// Adds the forces, N (2D: N/m): minus the gradient of the energy. Their sum and their torque vanish to rounding.
    fn add_forces(&self, x: &[Vector<D>], forces: &mut [Vector<D>]);

    /// Adds the forces with which strains resist their rates, proportionally to the stiffness; `time`, s, over the
    /// duration of a change is the share of the elastic force. They dissipate, and keep both momenta.
    fn add_viscous_forces(&self, x: &[Vector<D>], v: &[Vector<D>], time: f64, forces: &mut [Vector<D>]);

    /// Adds the tangents, N/m (2D: N/m²); the matrix has a block for every pair of a group in [`Self::couplings`].
    fn add_tangent(&self, x: &[Vector<D>], weights: TangentWeights, matrix: &mut BlockMatrix<D>);
}

/// A term with forces between two configurations, `x₀` and `x₁`, whose work from one to the other is the change of its energy
/// (`conserving.rs`).
pub trait DiscreteGradientTerm<const D: usize>: ForceTerm<D> {
    /// Adds these forces, N (2D: N/m). Their sum vanishes, and their torque about places half-way.
    fn add_forces_between(&self, ends: [&[Vector<D>]; 2], forces: &mut [Vector<D>]);
}
