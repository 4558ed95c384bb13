//! The step of a solid by itself, and its linear statics.
//!
//! ```text
//! x ← x + h v,    v' makes the potential of the step least ([`Incremental`]),    K u = f
//! ```
//!
//! The first is the simulator's step without liquid and contacts: positions first, then velocities half a step ahead of them. Newton's
//! method, whose line search ends before an element is turned inside out at the end of the coming step (as in M. Li et al.,
//! "Incremental Potential Contact", 2020). The second is the limit of small forces at rest.

use crate::linalg::TOLERANCE;
use crate::term::Weights;
use crate::{BlockMatrix, Elastic, ElasticError, ElasticState, Incremental, StiffnessBlock};
use meniscus_numerics::Vector;

/// Most of Newton's iterations in a step.
pub const ITERATIONS: usize = 60;
/// Part of its distance that a pair keeps in an iteration, and of its volume an element: IPC's 0.2, its line search's safety.
pub const KEEP: f64 = 0.2;
/// Most halvings of an iteration's change in the line search.
pub const HALVINGS: usize = 30;
/// Fall of the potential that Newton's method predicts, over the size of its terms, below which it has converged: the change is then 1e-9
/// of the velocities.
const CONVERGED: f64 = 1e-18;
/// Way of a vertex in a step, over the size of the body, to which rounding in the elastic forces leaves its place open.
const ROUNDING: f64 = 1e-12;
/// Fall, over the size of the terms, that is lost in the rounding of the potential: from positions of 16 digits strains of 1e-6 have 8
/// digits, and their energy as many. Newton's method then changes the velocities by less than 1e-4 of them.
const VISIBLE: f64 = 1e-8;

impl<const D: usize> Elastic<D> {
    /// The first half of a step of `step` s: moves the vertices with their velocities, held ones exactly as told.
    pub fn advance_positions(&self, state: &mut ElasticState<D>, step: f64) {
        state.positions.iter_mut().zip(&state.velocities).for_each(|(x, v)| *x += v * step);
        state.time += step;
        self.place_held(state);
    }

    /// Displacements from rest, m, under small forces, N (2D: N/m), with the stiffness of other forces.
    ///
    /// # Errors
    /// [`ElasticError::NotNeighbours`]; [`ElasticError::NotDefinite`] where the body can move without strain.
    pub fn small_displacements(
        &self,
        forces: &[Vector<D>],
        extra: &[StiffnessBlock<D>],
    ) -> Result<Vec<Vector<D>>, ElasticError> {
        let mut stiffness =
            self.tangent(&self.rest.positions, Weights { stiffness: 1.0, positive: true, viscosity: 0.0 });
        for StiffnessBlock { first, second, block } in extra {
            if !stiffness.add(*first, *second, block) {
                return Err(ElasticError::NotNeighbours { first: *first, second: *second });
            }
        }
        let failed = ElasticError::NotDefinite { step: f64::INFINITY };
        self.solved(&stiffness, forces.to_vec()).ok_or(failed)
    }

    /// A step of `step` s under external forces, N (2D: N/m), one for each vertex. A step that fails leaves the state as
    /// it was.
    ///
    /// # Errors
    /// [`ElasticError::NotDefinite`], [`ElasticError::Unsettled`] and [`ElasticError::NotFinite`].
    pub fn step(
        &self,
        state: &mut ElasticState<D>,
        step: f64,
        external: &[Vector<D>],
    ) -> Result<(), ElasticError> {
        let mut next = state.clone();
        self.advance_positions(&mut next, step);
        let impulses: Vec<Vector<D>> = external.iter().map(|force| force * step).collect();
        let mut potential = Incremental {
            elastic: self,
            state: &next,
            viscous_at: next.positions.clone(),
            beyond: vec![Vector::zeros(); impulses.len()],
            extra: &[],
            impulses: &impulses,
            step,
            lead: 0.5 * step,
            ahead: step,
        };
        let velocities = self.minimiser(&mut potential)?;
        if let Some(vertex) = velocities.iter().position(|v| !v.iter().all(|c| c.is_finite())) {
            return Err(ElasticError::NotFinite { vertex, time: next.time });
        }
        next.velocities = velocities;
        *state = next;
        Ok(())
    }

    /// The velocities that make a step's potential least, m/s, by Newton's method.
    fn minimiser(&self, potential: &mut Incremental<'_, D>) -> Result<Vec<Vector<D>>, ElasticError> {
        let (time, step) = (potential.state.time, potential.step);
        let mut velocities = potential.state.velocities.clone();
        let positions = &self.rest.positions;
        let size = positions.iter().map(|x| (x - positions[0]).norm()).fold(0.0, f64::max);
        for _ in 0..ITERATIONS {
            let mut lead = vec![Vector::zeros(); velocities.len()];
            self.held_velocities(time, step).for_each(|(v, told)| lead[v] = told - velocities[v]);
            let led = lead.iter().any(|l| l.norm_squared() > 0.0);
            let (change, fall) = self.newton_change(potential, &velocities, &lead)?;
            let fall = fall / potential.size(&velocities).max(f64::MIN_POSITIVE);
            let falls = !led && fall > VISIBLE;
            let Some((next, whole)) = line_search(potential, &velocities, &change, falls) else { break };
            velocities = next;
            potential.recentre(&velocities);
            let way = step * change.iter().map(Vector::norm).fold(0.0, f64::max);
            if !led && whole && (fall <= CONVERGED || way <= ROUNDING * size) {
                return Ok(velocities);
            }
        }
        Err(ElasticError::Unsettled { iterations: ITERATIONS, step })
    }

    /// The change of the velocities in an iteration, m/s, with that of held vertices, `lead`, and by how much the potential falls along
    /// it to first order, J (2D: J/m).
    fn newton_change(
        &self,
        potential: &Incremental<'_, D>,
        velocities: &[Vector<D>],
        lead: &[Vector<D>],
    ) -> Result<(Vec<Vector<D>>, f64), ElasticError> {
        let gradient = potential.gradient(velocities);
        let solved = |positive| {
            let matrix = potential.matrix(velocities, positive)?;
            let mut right: Vec<Vector<D>> = gradient.iter().map(|g| -g).collect();
            let mut pushed = vec![Vector::zeros(); lead.len()];
            matrix.add_product(lead, &mut pushed);
            right.iter_mut().zip(&pushed).for_each(|(r, p)| *r -= p);
            self.solved(&matrix, right)
        };
        // Only where the second derivatives are not positive definite their positive part is taken: it is stiffer than need be.
        let change = solved(false).or_else(|| solved(true));
        let mut change = change.ok_or(ElasticError::NotDefinite { step: potential.step })?;
        change.iter_mut().zip(lead).for_each(|(c, l)| *c += l);
        let fall = gradient.iter().zip(&change).map(|(g, c)| -g.dot(c)).sum();
        Ok((change, fall))
    }

    /// `A⁻¹ b`, 0 at held vertices.
    fn solved(&self, matrix: &BlockMatrix<D>, right: Vec<Vector<D>>) -> Option<Vec<Vector<D>>> {
        let inverse = self.solver.invert(matrix, &self.held, TOLERANCE)?;
        let mut flat: Vec<f64> = right.iter().flat_map(|v| v.iter().copied()).collect();
        inverse.solve(None, &mut flat, 1);
        Some(flat.chunks_exact(D).map(Vector::from_column_slice).collect())
    }
}

/// Velocities on the way along a change as far as elements stay upright and, where that is asked for, as the potential falls, and whether
/// that is all the way; nothing where it does not fall.
fn line_search<const D: usize>(
    potential: &Incremental<'_, D>,
    velocities: &[Vector<D>],
    change: &[Vector<D>],
    falls: bool,
) -> Option<(Vec<Vector<D>>, bool)> {
    let along =
        |part: f64| -> Vec<Vector<D>> { velocities.iter().zip(change).map(|(v, c)| v + c * part).collect() };
    let upright = potential.upright_step(velocities, change, KEEP);
    if !falls {
        return Some((along(upright), upright == 1.0));
    }
    let from = potential.value(velocities);
    let mut parts =
        (0..HALVINGS).map(|k| upright * 0.5f64.powi(k as i32)).map(|part| (along(part), part == 1.0));
    parts.find(|(next, _)| potential.value(next) <= from)
}
