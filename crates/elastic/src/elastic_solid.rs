//! What a deformable solid is while it moves.

use crate::linalg::{BlockMatrix, LinearSolver, SparsityPattern};
use crate::term::TangentWeights;
use crate::term::continuum::Continuum;
use crate::term::inversion_barrier::InversionBarrier;
use crate::{Anchor, DiscreteGradientTerm, ElasticState, ForceTerm};
use meniscus_numerics::Vector;
use meniscus_numerics::mesh::VolumeMesh;
use std::sync::Arc;

/// A deformable solid: all that does not change while it moves.
///
/// Masses are lumped: each simplex of the mesh gives equal parts to its vertices. That keeps momentum, the centre of mass and the order
/// of accuracy, and leaves `M⁻¹` a division, which preconditioners of the liquid's pressure need. The consistent matrix would
/// have smaller errors of the same order, but makes the fastest modes of an element, which no one wants to see, faster.
#[derive(Debug)]
pub struct Elastic<const D: usize> {
    pub(crate) rest_mesh: VolumeMesh<D>,
    pub(crate) masses: Vec<f64>,
    pub(crate) terms: Vec<Box<dyn DiscreteGradientTerm<D>>>,
    pub(crate) anchors: Vec<Anchor<D>>,
    pub(crate) anchored: Vec<bool>,
    pub(crate) damping_time: f64,
    pub(crate) young_modulus: f64,
    pub(crate) solver: LinearSolver,
    pub(crate) pattern: Arc<SparsityPattern>,
    /// What keeps its elements upright.
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

    /// Which vertices are held.
    pub fn anchored(&self) -> &[bool] {
        &self.anchored
    }

    /// `D = τ K`: the time `τ`, s, of the damping that is proportional to the stiffness against rates of strain.
    pub fn damping_time(&self) -> f64 {
        self.damping_time
    }

    /// Young's modulus, Pa; of springs their stiffness over the longest edge (in 2D their stiffness).
    pub fn young_modulus(&self) -> f64 {
        self.young_modulus
    }

    /// Entries of a factor of the solid's matrix: twice as many multiplications make a solve. Without factors the entries that
    /// iterations go through.
    pub fn solver_entries(&self) -> usize {
        self.solver.entries()
    }

    /// Whether its matrix is factorised; else the factor would be too large, and systems with it are solved by iterations.
    pub fn is_factorised(&self) -> bool {
        matches!(self.solver, LinearSolver::Direct(_))
    }

    /// At rest at time 0; held vertices where their motion has them, with its velocity over a step of `dt` s.
    ///
    /// Velocities are half a step ahead of positions: where forces act from the start, those of half a step are to be added.
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

    /// The elastic forces at positions, N (2D: N/m).
    pub fn forces(&self, positions: &[Vector<D>]) -> Vec<Vector<D>> {
        let mut forces = vec![Vector::zeros(); positions.len()];
        self.terms.iter().for_each(|t| t.add_forces(positions, &mut forces));
        forces
    }

    /// Elastic forces between two configurations, N (2D: N/m), whose work from one to the other is the change of the elastic energy.
    pub fn forces_between(&self, ends: [&[Vector<D>]; 2]) -> Vec<Vector<D>> {
        let mut forces = vec![Vector::zeros(); ends[0].len()];
        self.terms.iter().for_each(|t| t.add_forces_between(ends, &mut forces));
        forces
    }

    /// Forces that resist rates of strain, N (2D: N/m), proportional to the stiffness times `time`, s.
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

    /// Tangents of all terms at positions.
    pub fn tangent(&self, positions: &[Vector<D>], weights: TangentWeights) -> BlockMatrix<D> {
        let mut matrix = BlockMatrix::new(self.pattern.clone());
        self.terms.iter().for_each(|t| t.add_tangent(positions, weights, &mut matrix));
        matrix
    }

    /// Energy, J (2D: J/m), of what keeps elements upright, at positions.
    pub fn inversion_barrier_energy(&self, positions: &[Vector<D>]) -> f64 {
        self.inversion_barriers.iter().map(|u| u.energy(positions)).sum()
    }

    /// Puts held vertices where they belong at the state's time.
    pub(crate) fn place_anchored(&self, state: &mut ElasticState<D>) {
        for anchor in &self.anchors {
            let displacement = anchor.motion.displacement(state.time);
            for v in &anchor.vertices {
                state.positions[*v as usize] = self.rest_mesh.positions[*v as usize] + displacement;
            }
        }
    }

    /// Held vertices and the velocities that take them where they belong after a step of `dt` s from `time`.
    pub fn anchored_velocities(&self, time: f64, dt: f64) -> impl Iterator<Item = (usize, Vector<D>)> {
        self.anchors.iter().flat_map(move |anchor| {
            let ahead = anchor.motion.displacement(time + dt) - anchor.motion.displacement(time);
            anchor.vertices.iter().map(move |v| (*v as usize, ahead / dt))
        })
    }
}
