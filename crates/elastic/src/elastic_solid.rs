//! Data of a deformable solid that do not change in time, and its forces and tangents.

use crate::linalg::{BlockMatrix, LinearSolver, SparsityPattern};
use crate::term::TangentWeights;
use crate::term::continuum::Continuum;
use crate::term::inversion_barrier::InversionBarrier;
use crate::{Anchor, DiscreteGradientTerm, ElasticState, ForceTerm};
use meniscus_numerics::Vector;
use meniscus_numerics::mesh::VolumeMesh;
use meniscus_numerics::mesh::volume::ElementOrder;
use std::sync::Arc;

/// A deformable solid without its state.
///
/// Masses are lumped: each simplex distributes its mass equally to its vertices. This preserves momentum, the centre of mass and
/// the order of accuracy, and `M⁻¹`, which preconditioners of the liquid's pressure need, is a division. The consistent mass matrix
/// has smaller errors of the same order but raises the highest frequencies of an element.
#[derive(Debug)]
pub struct Elastic<const D: usize> {
    pub(crate) rest_mesh: VolumeMesh<D>,
    pub(crate) masses: Vec<f64>,
    pub(crate) terms: Vec<Box<dyn DiscreteGradientTerm<D>>>,
    pub(crate) anchors: Vec<Anchor<D>>,
    pub(crate) anchored: Vec<bool>,
    pub(crate) damping_time: f64,
    pub(crate) young_modulus: f64,
    pub(crate) order: ElementOrder,
    pub(crate) solver: LinearSolver,
    pub(crate) pattern: Arc<SparsityPattern>,
    /// Barriers against the inversion of elements.
    pub(crate) inversion_barriers: Vec<Continuum<InversionBarrier, D>>,
}

impl<const D: usize> Elastic<D> {
    /// The mesh at rest.
    pub fn rest_mesh(&self) -> &VolumeMesh<D> {
        &self.rest_mesh
    }

    /// Masses of the vertices, kg (2D: kg/m).
    pub fn masses(&self) -> &[f64] {
        &self.masses
    }

    /// Whether each vertex is anchored.
    pub fn anchored(&self) -> &[bool] {
        &self.anchored
    }

    /// Damping time `τ`, s, of `D = τ K̂`, with the stiffness `K̂` against rates of strain.
    pub fn damping_time(&self) -> f64 {
        self.damping_time
    }

    /// Young's modulus, Pa. For springs: their stiffness over the longest edge (2D: their stiffness).
    pub fn young_modulus(&self) -> f64 {
        self.young_modulus
    }

    /// Order of the elements.
    pub fn order(&self) -> ElementOrder {
        self.order
    }

    /// Entries of the Cholesky factor of the solid's matrix; a solve takes two multiplications for each. Without a factor: the
    /// entries that one iteration reads.
    pub fn solver_entries(&self) -> usize {
        self.solver.entries()
    }

    /// Whether the matrix is factorised. If the factor is too large, conjugate gradients solve systems with it.
    pub fn is_factorised(&self) -> bool {
        matches!(self.solver, LinearSolver::Direct(_))
    }

    /// The rest state at time 0. Anchored vertices have their prescribed positions and their velocities over a step of `dt` s.
    ///
    /// Velocities lead positions by half a step: the caller adds half a step of impulses of forces that act from the start.
    pub fn rest_state(&self, dt: f64) -> ElasticState<D> {
        let positions = self.rest_mesh.positions.clone();
        let velocities = vec![Vector::zeros(); positions.len()];
        let mut state = ElasticState { positions, velocities, time: 0.0 };
        self.place_anchored(&mut state);
        for (v, velocity) in self.anchored_velocities(state.time, dt) {
            state.velocities[v] = velocity;
        }
        state
    }

    /// Elastic forces at positions, N (2D: N/m).
    pub fn forces(&self, positions: &[Vector<D>]) -> Vec<Vector<D>> {
        let mut forces = vec![Vector::zeros(); positions.len()];
        self.terms.iter().for_each(|t| t.add_forces(positions, &mut forces));
        forces
    }

    /// Discrete-gradient forces between two configurations, N (2D: N/m): their work equals the decrease of the elastic energy.
    pub fn forces_between(&self, ends: [&[Vector<D>]; 2]) -> Vec<Vector<D>> {
        let mut forces = vec![Vector::zeros(); ends[0].len()];
        self.terms.iter().for_each(|t| t.add_forces_between(ends, &mut forces));
        forces
    }

    /// Viscous forces, N (2D: N/m): the stiffness against rates of strain, times `time`, s.
    pub fn viscous_forces(
        &self,
        positions: &[Vector<D>],
        velocities: &[Vector<D>],
        time: f64,
    ) -> Vec<Vector<D>> {
        let mut forces = vec![Vector::zeros(); positions.len()];
        if time > 0.0 {
            self.terms.iter().for_each(|t| t.add_viscous_forces(positions, velocities, time, &mut forces));
        }
        forces
    }

    /// Weighted sum of the tangents of all terms at positions.
    pub fn tangent(&self, positions: &[Vector<D>], weights: TangentWeights) -> BlockMatrix<D> {
        let mut matrix = BlockMatrix::new(self.pattern.clone());
        if weights.stiffness != 0.0 || weights.viscosity != 0.0 {
            self.terms.iter().for_each(|t| t.add_tangent(positions, weights, &mut matrix));
        }
        matrix
    }

    /// Energy of the inversion barriers at positions, J (2D: J/m).
    pub fn inversion_barrier_energy(&self, positions: &[Vector<D>]) -> f64 {
        self.inversion_barriers.iter().map(|u| u.energy(positions)).sum()
    }

    /// Sets anchored vertices to their prescribed positions at the state's time.
    pub(crate) fn place_anchored(&self, state: &mut ElasticState<D>) {
        for anchor in &self.anchors {
            let displacement = anchor.motion.displacement(state.time);
            for v in &anchor.vertices {
                state.positions[*v as usize] = self.rest_mesh.positions[*v as usize] + displacement;
            }
        }
    }

    /// Anchored vertices and the velocities that take them to their prescribed positions in a step of `dt` s from `time`.
    pub fn anchored_velocities(&self, time: f64, dt: f64) -> impl Iterator<Item = (usize, Vector<D>)> {
        self.anchors.iter().flat_map(move |anchor| {
            let ahead = anchor.motion.displacement(time + dt) - anchor.motion.displacement(time);
            anchor.vertices.iter().map(move |v| (*v as usize, ahead / dt))
        })
    }
}
