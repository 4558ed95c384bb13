//! Step of a solid without liquid and contacts, and its linear statics.
//!
//! ```text
//! x ← x + h v,    v' = argmin E(v'),    K u = f
//! ```
//!
//! The first two equations are the simulator's step without liquid and contacts, with the potential `E` of [`IncrementalPotential`];
//! velocities lead positions by half a step. Newton's method minimises the potential; its line search keeps elements from inverting by
//! the end of the coming step (as in M. Li et al., "Incremental Potential Contact", 2020). The third equation is the limit of small
//! forces at rest.

use crate::linalg::ITERATIVE_TOLERANCE;
use crate::term::TangentWeights;
use crate::{BlockMatrix, Elastic, ElasticError, ElasticState, IncrementalPotential, StiffnessBlock};
use meniscus_numerics::Vector;

/// Largest number of Newton iterations in a step.
pub const MAX_NEWTON_ITERATIONS: usize = 60;
/// Fraction of its distance that a pair, and of its volume that an element, keeps in a Newton iteration: 0.2 as in IPC.
pub const KEPT_FRACTION: f64 = 0.2;
/// Largest number of halvings in a line search.
pub const MAX_LINE_SEARCH_HALVINGS: usize = 30;
/// Newton decrement, over the magnitude of the energies, below which the method has converged: the relative change of the
/// velocities is then 1e-9.
const DECREMENT_TOLERANCE: f64 = 1e-18;
/// Change of a displacement in a step, over the size of the solid, that is below the rounding of the elastic forces.
const DISPLACEMENT_ROUNDING: f64 = 1e-12;
/// Decrease of the potential, over the magnitude of the energies, that is lost in rounding: with positions of 16 digits strains of
/// 1e-6 and their energy have 8. The relative change of the velocities is then below 1e-4.
const POTENTIAL_ROUNDING: f64 = 1e-8;

impl<const D: usize> Elastic<D> {
    /// First part of a step of `dt` s: advances the vertices with their velocities, anchored ones to their prescribed positions.
    pub fn advance_positions(&self, state: &mut ElasticState<D>, dt: f64) {
        state.positions.iter_mut().zip(&state.velocities).for_each(|(x, v)| *x += v * dt);
        state.time += dt;
        self.place_anchored(state);
    }

    /// Displacements from rest, m, under small forces, N (2D: N/m), with the stiffness of other forces.
    ///
    /// # Errors
    /// [`ElasticError::NotNeighbours`]; [`ElasticError::NotPositiveDefinite`] where the solid can move without strain.
    pub fn linear_static_displacements(
        &self,
        forces: &[Vector<D>],
        extra_stiffness: &[StiffnessBlock<D>],
    ) -> Result<Vec<Vector<D>>, ElasticError> {
        let mut stiffness = self.tangent(
            &self.rest_mesh.positions,
            TangentWeights { stiffness: 1.0, project_psd: true, viscosity: 0.0 },
        );
        for StiffnessBlock { first, second, block } in extra_stiffness {
            if !stiffness.add(*first, *second, block) {
                return Err(ElasticError::NotNeighbours { first: *first, second: *second });
            }
        }
        let failed = ElasticError::NotPositiveDefinite { step: f64::INFINITY };
        self.solve_linear(&stiffness, forces.to_vec()).ok_or(failed)
    }

    /// A step of `dt` s under an external force on each vertex, N (2D: N/m). A step that fails leaves the state unchanged.
    ///
    /// # Errors
    /// [`ElasticError::NotPositiveDefinite`], [`ElasticError::NotConverged`] and [`ElasticError::NotFinite`].
    pub fn step(
        &self,
        state: &mut ElasticState<D>,
        dt: f64,
        external: &[Vector<D>],
    ) -> Result<(), ElasticError> {
        let mut next = state.clone();
        self.advance_positions(&mut next, dt);
        let impulses: Vec<Vector<D>> = external.iter().map(|force| force * dt).collect();
        let mut potential = IncrementalPotential {
            elastic: self,
            state: &next,
            viscosity_positions: next.positions.clone(),
            discrete_gradient_correction: vec![Vector::zeros(); impulses.len()],
            extra_stiffness: &[],
            impulses: &impulses,
            impulse_time: dt,
            velocity_lead: 0.5 * dt,
            lookahead: dt,
        };
        let velocities = self.minimiser(&mut potential)?;
        if let Some(vertex) = velocities.iter().position(|v| !v.iter().all(|c| c.is_finite())) {
            return Err(ElasticError::NotFinite { vertex, time: next.time });
        }
        next.velocities = velocities;
        *state = next;
        Ok(())
    }

    /// Velocities that minimise the potential of a step, m/s, by Newton's method.
    fn minimiser(&self, potential: &mut IncrementalPotential<'_, D>) -> Result<Vec<Vector<D>>, ElasticError> {
        let (time, step) = (potential.state.time, potential.impulse_time);
        let mut velocities = potential.state.velocities.clone();
        let positions = &self.rest_mesh.positions;
        let size = positions.iter().map(|x| (x - positions[0]).norm()).fold(0.0, f64::max);
        for _ in 0..MAX_NEWTON_ITERATIONS {
            let mut prescribed_change = vec![Vector::zeros(); velocities.len()];
            self.anchored_velocities(time, step)
                .for_each(|(v, told)| prescribed_change[v] = told - velocities[v]);
            let prescribed_moves = prescribed_change.iter().any(|l| l.norm_squared() > 0.0);
            let (change, fall) = self.newton_direction(potential, &velocities, &prescribed_change)?;
            let fall = fall / potential.energy_scale(&velocities).max(f64::MIN_POSITIVE);
            let must_decrease = !prescribed_moves && fall > POTENTIAL_ROUNDING;
            let Some((next, whole)) = line_search(potential, &velocities, &change, must_decrease) else {
                break;
            };
            velocities = next;
            potential.update_lagged(&velocities);
            let way = step * change.iter().map(Vector::norm).fold(0.0, f64::max);
            if !prescribed_moves
                && whole
                && (fall <= DECREMENT_TOLERANCE || way <= DISPLACEMENT_ROUNDING * size)
            {
                return Ok(velocities);
            }
        }
        Err(ElasticError::NotConverged { iterations: MAX_NEWTON_ITERATIONS, step })
    }

    /// Newton direction, m/s, with the change `prescribed_change` of anchored vertices, and the Newton decrement: the first-order
    /// decrease of the potential along it, J (2D: J/m).
    fn newton_direction(
        &self,
        potential: &IncrementalPotential<'_, D>,
        velocities: &[Vector<D>],
        prescribed_change: &[Vector<D>],
    ) -> Result<(Vec<Vector<D>>, f64), ElasticError> {
        let gradient = potential.gradient(velocities);
        let solved = |positive| {
            let matrix = potential.hessian(velocities, positive)?;
            let mut right: Vec<Vector<D>> = gradient.iter().map(|g| -g).collect();
            let mut pushed = vec![Vector::zeros(); prescribed_change.len()];
            matrix.add_product(prescribed_change, &mut pushed);
            right.iter_mut().zip(&pushed).for_each(|(r, p)| *r -= p);
            self.solve_linear(&matrix, right)
        };
        // The projected Hessian is stiffer; it is used only where the exact one is not positive definite.
        let change = solved(false).or_else(|| solved(true));
        let mut change = change.ok_or(ElasticError::NotPositiveDefinite { step: potential.impulse_time })?;
        change.iter_mut().zip(prescribed_change).for_each(|(c, l)| *c += l);
        let fall = gradient.iter().zip(&change).map(|(g, c)| -g.dot(c)).sum();
        Ok((change, fall))
    }

    /// `A⁻¹ b`, zero at anchored vertices. `None` where the matrix is not positive definite.
    fn solve_linear(&self, matrix: &BlockMatrix<D>, right: Vec<Vector<D>>) -> Option<Vec<Vector<D>>> {
        let inverse = self.solver.invert(matrix, &self.anchored, ITERATIVE_TOLERANCE)?;
        let mut flat: Vec<f64> = right.iter().flat_map(|v| v.iter().copied()).collect();
        inverse.solve(None, &mut flat, 1);
        Some(flat.chunks_exact(D).map(Vector::from_column_slice).collect())
    }
}

/// Line search: velocities along a change for which no element inverts and, if `must_decrease`, the potential does not increase,
/// and whether the full change was taken. `None` where every tried fraction increases the potential.
fn line_search<const D: usize>(
    potential: &IncrementalPotential<'_, D>,
    velocities: &[Vector<D>],
    change: &[Vector<D>],
    must_decrease: bool,
) -> Option<(Vec<Vector<D>>, bool)> {
    let along =
        |part: f64| -> Vec<Vector<D>> { velocities.iter().zip(change).map(|(v, c)| v + c * part).collect() };
    let upright = potential.inversion_free_fraction(velocities, change, KEPT_FRACTION);
    if !must_decrease {
        return Some((along(upright), upright == 1.0));
    }
    let from = potential.value(velocities);
    let mut parts = (0..MAX_LINE_SEARCH_HALVINGS)
        .map(|k| upright * 0.5f64.powi(k as i32))
        .map(|part| (along(part), part == 1.0));
    parts.find(|(next, _)| potential.value(next) <= from)
}
