//! A step: positions first, then velocities from the forces at the new positions, with a matrix.
//!
//! ```text
//! x ← x + h v
//! A (v' − v) = h (f(x) + g − D v − θ h K̂ u),    A = M + h D + h²/4 K + (θ/2 + θ²/4) h² K̂,    u = v − A⁻¹ M v
//! ```
//!
//! `K` is the positive part of the stiffness, `K̂` that against rates of strain only, which a rigid motion does not feel
//! ([`Weights`]), `D = τ K̂` the damping, and `u` the fast part of the motion. About rest `K = K̂`, and a mode of
//! frequency `ω` without damping has, for `z = h² ω²`, `c = (1 + θ)²/4` and `s = c z/(1 + c z)`, the amplification's
//! determinant `1 − θ s z/(1 + c z)` and trace `2 − (1 + θ s) z/(1 + c z)`. That is stable for every `h` and `θ ≤ 1`.
//!
//! With `θ = 0` it is neutral: symplectic Euler of the frequency `ω̃² = ω²/(1 + z/4)`, the implicit midpoint rule in other
//! variables, of which a step is one Newton iteration. Otherwise modes that the step does not resolve are damped, both
//! eigenvalues tending to `−(1 − θ)/(1 + θ)` for `h ω → ∞` as in the generalised-α method (Chung & Hulbert 1993), while slow
//! ones lose but the fraction `θ c (h ω)³/2` of the critical damping. It takes another solve. Because the dissipation is in
//! rates of strain, bodies that nothing holds keep their angular momentum.

use crate::linalg::{Inverse, Reach, TOLERANCE};
use crate::term::Weights;
use crate::{BlockMatrix, Elastic, ElasticError, ElasticState};
use meniscus_numerics::{Matrix, Vector};

/// Change of the velocities, relative to the first, below which Newton's iterations end.
const CONVERGED: f64 = 1e-10;

/// How velocities follow forces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Integrator {
    /// How strongly modes are damped that the step does not resolve, `θ`: 0 not at all, 1 at once.
    pub dissipation: f64,
    /// Newton iterations of [`Elastic::step`] after the linear step; 0 for none. Three or four keep the angular momentum to
    /// rounding; they let no longer steps be taken.
    pub iterations: u32,
}

/// Little dissipation that is enough for violent swings of thin beams with `h ω ≤ 100` (`tests/energy.rs`).
impl Default for Integrator {
    fn default() -> Self {
        Self { dissipation: 0.3, iterations: 0 }
    }
}

impl Integrator {
    /// The weights of a step's matrix, for a damping time, s.
    pub(crate) fn weights(&self, step: f64, damping_time: f64) -> Weights {
        let theta = self.dissipation;
        let viscosity = step * damping_time + (0.5 + 0.25 * theta) * theta * step * step;
        Weights { stiffness: 0.25 * step * step, positive: true, viscosity }
    }
}

/// Stiffness that other forces add, N/m (2D: N/m²): minus the derivative of the force on `first` by the position of
/// `second`. For two different vertices the transpose counts for the exchanged pair by itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StiffnessBlock<const D: usize> {
    /// A vertex.
    pub first: u32,
    /// The same, or one that shares an element with it.
    pub second: u32,
    /// The block; symmetric if the vertices are the same. All blocks together must be positive semidefinite.
    pub block: Matrix<D>,
}

/// What a step of a solid starts from.
#[derive(Clone, Copy, Debug)]
pub struct Linearisation<'a, const D: usize> {
    /// Positions that have advanced, and velocities that have not.
    pub state: &'a ElasticState<D>,
    /// The part of these that the step does not resolve ([`Elastic::fast`]), m/s.
    pub fast: &'a [Vector<D>],
    /// Stiffness of other forces.
    pub extra: &'a [StiffnessBlock<D>],
    /// Length of the step, s.
    pub step: f64,
}

/// The matrix `A` of a step, and its inverse.
#[derive(Clone, Debug)]
pub struct System<const D: usize> {
    matrix: BlockMatrix<D>,
    inverse: Inverse<D>,
    step: f64,
}

impl<const D: usize> System<D> {
    /// `b ← A⁻¹ b`, where `b` has the components of all vertices in turn. What belongs to held vertices becomes 0, as
    /// nothing that pulls at them moves them.
    ///
    /// Costs two multiplications for every entry of the factor, if it has one ([`Elastic::is_factorised`]).
    pub fn solve(&self, b: &mut [f64]) {
        self.inverse.solve(None, b, 1);
    }

    /// The same for `count` right-hand sides one after another, which costs less than so many solves.
    pub fn solve_many(&self, b: &mut [f64], count: usize) {
        self.inverse.solve(None, b, count);
    }

    /// What right-hand sides that act on some vertices only need for the solution at these: less the fewer and the nearer to each
    /// other they are.
    pub fn reach(&self, vertices: impl Iterator<Item = u32>) -> Reach {
        self.inverse.reach(vertices)
    }

    /// `b ← A⁻¹ b` at the vertices of a reach, for `count` right-hand sides one after another that are 0 at all others; what they
    /// become there is not told.
    pub fn solve_within(&self, reach: &Reach, b: &mut [f64], count: usize) {
        self.inverse.solve(Some(reach), b, count);
    }

    /// The same of vectors.
    pub fn solve_vectors(&self, b: &mut [Vector<D>]) {
        let mut flat: Vec<f64> = b.iter().flat_map(|v| v.iter().copied()).collect();
        self.solve(&mut flat);
        b.iter_mut().zip(flat.chunks_exact(D)).for_each(|(b, x)| b.copy_from_slice(x));
    }

    /// The matrix `A`, rows and columns of held vertices included.
    pub fn matrix(&self) -> &BlockMatrix<D> {
        &self.matrix
    }

    /// The length `h` of the step, s.
    pub fn step(&self) -> f64 {
        self.step
    }
}

/// Adds the impulses, N s, of other forces' stiffness in a step of `h` s that changes the velocities by `w`.
pub(crate) fn add_extra<const D: usize>(
    extra: &[StiffnessBlock<D>],
    h: f64,
    w: &[Vector<D>],
    impulses: &mut [Vector<D>],
) {
    for StiffnessBlock { first, second, block } in extra {
        let (i, j, block) = (*first as usize, *second as usize, block * (0.25 * h * h));
        impulses[i] -= block * w[j];
        if i != j {
            impulses[j] -= block.tr_mul(&w[i]);
        }
    }
}

impl<const D: usize> Elastic<D> {
    /// The first half of a step of `step` s: moves the vertices with their velocities, held ones exactly as told.
    pub fn advance_positions(&self, state: &mut ElasticState<D>, step: f64) {
        state.positions.iter_mut().zip(&state.velocities).for_each(|(x, v)| *x += v * step);
        state.time += step;
        self.place_held(state);
    }

    /// The matrix of a step of `step` s at a state's positions, with extra stiffness.
    ///
    /// # Errors
    /// [`ElasticError::NotNeighbours`] and [`ElasticError::NotDefinite`].
    pub fn system(
        &self,
        positions: &[Vector<D>],
        step: f64,
        extra: &[StiffnessBlock<D>],
    ) -> Result<System<D>, ElasticError> {
        let strange = |block: &&StiffnessBlock<D>| {
            let (i, j) = (block.first.max(block.second), block.first.min(block.second));
            self.pattern.slot(i, j).is_none()
        };
        if let Some(StiffnessBlock { first, second, .. }) = extra.iter().find(strange) {
            return Err(ElasticError::NotNeighbours { first: *first, second: *second });
        }
        let Some(matrix) = self.matrix(positions, step, extra) else {
            return Err(ElasticError::NotDefinite { step });
        };
        let inverse = self.solver.invert(&matrix, &self.held, TOLERANCE);
        inverse.map(|inverse| System { matrix, inverse, step }).ok_or(ElasticError::NotDefinite { step })
    }

    /// The matrix `A` itself; nothing where the extra stiffness is between vertices that share no element.
    pub(crate) fn matrix(
        &self,
        positions: &[Vector<D>],
        step: f64,
        extra: &[StiffnessBlock<D>],
    ) -> Option<BlockMatrix<D>> {
        let weights = self.integrator.weights(step, self.damping_time);
        let mut matrix = self.tangent(positions, weights);
        self.masses.iter().enumerate().for_each(|(v, m)| matrix.add_diagonal(v, *m));
        let mut put = |e: &StiffnessBlock<D>| matrix.add(e.first, e.second, &(e.block * weights.stiffness));
        extra.iter().all(&mut put).then_some(matrix)
    }

    /// The right-hand side of `A (v' − v) = b` at a state whose positions have advanced, N s (2D: N s/m), with external
    /// forces, N (2D: N/m). The change that the held vertices' motion asks for is in it.
    pub fn right_side(
        &self,
        system: &System<D>,
        state: &ElasticState<D>,
        external: &[Vector<D>],
    ) -> Vec<Vector<D>> {
        let h = system.step;
        let (x, v) = (&state.positions, &state.velocities);
        let elastic = self.forces(x);
        let damping = self.viscous_forces(x, v, self.damping_time);
        let numerical = self.viscous_forces(x, &self.fast(system, state), self.integrator.dissipation * h);
        let pull = |k: usize| elastic[k] + damping[k] + numerical[k] + external[k];
        let mut b: Vec<Vector<D>> = (0..x.len()).map(|k| pull(k) * h).collect();
        let mut change = vec![Vector::<D>::zeros(); x.len()];
        for (k, velocity) in self.held_velocities(state.time, h) {
            change[k] = v[k] - velocity;
        }
        if change.iter().any(|c| c.norm_squared() > 0.0) {
            system.matrix.add_product(&change, &mut b);
        }
        b
    }

    /// The part of the velocities that a step does not resolve, `v − A⁻¹ M v`, m/s; zero where nothing is to be dissipated.
    pub fn fast(&self, system: &System<D>, state: &ElasticState<D>) -> Vec<Vector<D>> {
        let v = &state.velocities;
        if self.integrator.dissipation == 0.0 {
            return vec![Vector::zeros(); v.len()];
        }
        let led: Vec<Vector<D>> =
            (0..v.len()).map(|k| if self.held[k] { -v[k] } else { Vector::zeros() }).collect();
        let mut slow: Vec<Vector<D>> = v.iter().zip(&self.masses).map(|(v, m)| v * *m).collect();
        system.matrix.add_product(&led, &mut slow);
        system.solve_vectors(&mut slow);
        (0..v.len()).map(|k| if self.held[k] { Vector::zeros() } else { v[k] - slow[k] }).collect()
    }

    /// The velocities after a step in which nothing but the solid and the external forces acts, m/s: `v + A⁻¹ b`, and
    /// those told of held vertices. Impulses `j` of others change them by `A⁻¹ j` more.
    pub fn free_velocities(
        &self,
        system: &System<D>,
        state: &ElasticState<D>,
        external: &[Vector<D>],
    ) -> Vec<Vector<D>> {
        let mut velocities = self.right_side(system, state, external);
        system.solve_vectors(&mut velocities);
        velocities.iter_mut().zip(&state.velocities).for_each(|(change, v)| *change += v);
        for (k, velocity) in self.held_velocities(state.time, system.step) {
            velocities[k] = velocity;
        }
        velocities
    }

    /// A step of `step` s under external forces, N (2D: N/m), one for each vertex. A step that fails leaves the state as
    /// it was.
    ///
    /// # Errors
    /// [`ElasticError::NotDefinite`] and [`ElasticError::NotFinite`].
    pub fn step(
        &self,
        state: &mut ElasticState<D>,
        step: f64,
        external: &[Vector<D>],
    ) -> Result<(), ElasticError> {
        let mut next = state.clone();
        self.advance_positions(&mut next, step);
        let system = self.system(&next.positions, step, &[])?;
        let mut velocities = self.free_velocities(&system, &next, external);
        self.iterate(&system, &next, external, &mut velocities)?;
        if let Some(vertex) = velocities.iter().position(|v| !v.iter().all(|c| c.is_finite())) {
            return Err(ElasticError::NotFinite { vertex, time: next.time });
        }
        next.velocities = velocities;
        *state = next;
        Ok(())
    }

    /// Newton's iterations from the linear step's velocities.
    fn iterate(
        &self,
        system: &System<D>,
        state: &ElasticState<D>,
        external: &[Vector<D>],
        velocities: &mut [Vector<D>],
    ) -> Result<(), ElasticError> {
        if self.integrator.iterations == 0 {
            return Ok(());
        }
        let step = system.step;
        let start = Linearisation { state, fast: &self.fast(system, state), extra: &[], step };
        let impulses: Vec<Vector<D>> = external.iter().map(|force| force * step).collect();
        let mut first = 0.0;
        for k in 0..self.integrator.iterations {
            let (system, mut change) = self.relinearised(&start, &impulses, velocities)?;
            system.solve_vectors(&mut change);
            velocities.iter_mut().zip(&change).for_each(|(v, c)| *v += c);
            let size = self.kinetic_energy(&change).sqrt();
            if k == 0 {
                first = size;
            }
            if size <= CONVERGED * first || size <= CONVERGED * self.kinetic_energy(velocities).sqrt() {
                break;
            }
        }
        Ok(())
    }

    /// A step's system about the velocities `v + w` that it has come to, and what is wrong there, `r`, N s (2D: N s/m): they
    /// change by `A⁻¹ r` in Newton's iteration for
    /// `M w = h (f(y) − D (v + w) − θ h K̂ (u + w/2 + θ w/4)) − h²/4 K' w + j`, with `y = x + h w/4`, tangents at `y`, the
    /// `impulses` `j` of all other forces, and their stiffness `K'`.
    ///
    /// # Errors
    /// Those of [`Self::system`].
    pub fn relinearised(
        &self,
        start: &Linearisation<'_, D>,
        impulses: &[Vector<D>],
        velocities: &[Vector<D>],
    ) -> Result<(System<D>, Vec<Vector<D>>), ElasticError> {
        let (x, v, h) = (&start.state.positions, &start.state.velocities, start.step);
        let theta = self.integrator.dissipation;
        let w: Vec<Vector<D>> = (0..x.len()).map(|k| velocities[k] - v[k]).collect();
        let y: Vec<Vector<D>> = (0..x.len()).map(|k| x[k] + w[k] * (0.25 * h)).collect();
        let between: Vec<Vector<D>> =
            (0..x.len()).map(|k| start.fast[k] + w[k] * (0.5 + 0.25 * theta)).collect();
        let elastic = self.forces(&y);
        let damping = self.viscous_forces(&y, velocities, self.damping_time);
        let numerical = self.viscous_forces(&y, &between, theta * h);
        let wrong =
            |k: usize| (elastic[k] + damping[k] + numerical[k]) * h + impulses[k] - w[k] * self.masses[k];
        let mut wrong: Vec<Vector<D>> = (0..x.len()).map(wrong).collect();
        add_extra(start.extra, h, &w, &mut wrong);
        Ok((self.system(&y, h, start.extra)?, wrong))
    }
}
