//! Newton's method for the velocities of solids in contact, coupled to the liquid's pressure.
//!
//! These velocities minimise an incremental potential ([`super::potential`]; M. Li et al., "Incremental Potential Contact", 2020). The
//! pressure solve contains the response `A⁻¹` of the solids to impulses ([`SolidResponse`]), where `A` is the Hessian at the current
//! velocities. The line search prevents collisions and inversion up to the end of the coming step, and makes the potential decrease.

use super::points::BARRIER_REACH_CELLS;
use super::solid_response::BaseLoads;
pub use super::solid_response::SolidResponse;

pub use super::points::CollisionPoints;
use super::potential::time_levels::{EarlyPairs, OldTimeLevels};

pub use super::potential::slips::Slips;
use super::tied_face::{TiedFace, TiedSolid};

use super::broad_phase::CandidatePairs;
use super::potential::incremental_potential::{EliminationOrder, Potential, SolidTerm};
use super::potential::solid_terms::{DeformableLoads, solid_terms};
use crate::contact_line::friction::DraggedFace;
use crate::flow::pressure::ProjectionOptions;
use crate::model::Model;
use crate::model::time_step::{MAX_FORCED_DEFORMATION_INCREMENT, StepTimes};
use crate::solid::{SolidState, SolidView, Solids, angular_to_node};
use meniscus_contact::Barrier;
use meniscus_elastic::{KEPT_FRACTION, MAX_LINE_SEARCH_HALVINGS, MAX_NEWTON_ITERATIONS};
use meniscus_numerics::Vector;
use meniscus_numerics::grid::FaceField;
use meniscus_numerics::linalg::SolveError;

/// Fraction of a pair's distance and of an element's volume that remains on the straight path to the end of the coming step.
const MIN_CLEARANCE_FRACTION: f64 = 0.01;
/// Tolerance of the positions at the end of the coming step, in activation distances of the barrier.
const CONVERGENCE_TOLERANCE: f64 = 1e-3;
/// Tolerance after an update of the lagged friction, relative to [`CONVERGENCE_TOLERANCE`]. It is tighter because the error of a lag that
/// is updated only [`MAX_FRICTION_UPDATES`] times accumulates from step to step.
const FRICTION_LAG_TOLERANCE: f64 = 0.01;
/// Relative residual of the pressure solve far from convergence (inexact Newton: S. Eisenstat, H. Walker 1996); changes only the cost.
const LOOSE_SOLVE_TOLERANCE: f64 = 1e-3;
/// Predicted change, over [`CONVERGENCE_TOLERANCE`], that one Newton iteration does not bring below 1.
const FAR_FROM_CONVERGENCE: f64 = 100.0;
/// Maximum number of updates of the lagged friction in a step.
const MAX_FRICTION_UPDATES: usize = 2;

/// The solids at the time when the forces of a step act.
#[derive(Clone, Copy)]
pub struct OldSolids<'a, const D: usize> {
    /// The solids, with the velocities before the forces act.
    pub solids: Solids<'a, D>,
    /// These velocities, by node.
    pub velocities: &'a [Vector<D>],
    /// The elastic slips of friction.
    pub elastic_slips: &'a Slips<D>,
}

/// Newton's method for one step.
pub struct NewtonSolver<'a, const D: usize> {
    potential: Potential<'a, D>,
    /// The solids before the forces act.
    solids: Solids<'a, D>,
    /// Velocities of the prescribed nodes, and the old ones of the others.
    prescribed: Vec<Vector<D>>,
    elimination: EliminationOrder<D>,
    /// Current velocities.
    velocities: Vec<Vector<D>>,
    /// Gradients of the solids' own terms at these velocities.
    own_gradients: Vec<Vec<Vector<D>>>,
    /// Pairs that may touch with these velocities.
    candidates: CandidatePairs,
    iteration: usize,
    /// Whether [`LOOSE_SOLVE_TOLERANCE`] applies to the pressure solve.
    is_loose: bool,
    /// Response of the last iteration, if the next iteration keeps its Hessian.
    response: Option<SolidResponse<D>>,
    friction_updates: usize,
    /// Iterations whose Hessian was not positive definite.
    pub indefinite_iterations: u64,
}

impl<'a, const D: usize> NewtonSolver<'a, D> {
    /// Starts the method. `forced` holds the velocities of rigid solids after all forces but pressure and contacts.
    pub fn new(
        points: &'a CollisionPoints<D>,
        before: OldSolids<'a, D>,
        forced: &[SolidState<D>],
        loads: &'a [Option<DeformableLoads<D>>],
        times: StepTimes,
    ) -> Self {
        let OldSolids { solids, velocities: old, elastic_slips } = before;
        let (model, before) = (solids.model, solids.states);
        let mut potential = Potential {
            model,
            solids: before,
            points,
            parts: solid_terms(model, before, forced, loads, times),
            barrier: Barrier { activation_distance: BARRIER_REACH_CELLS * model.grid.dx },
            impulse_time: times.impulse_time,
            velocity_lead: times.velocity_lead,
            lookahead: times.lookahead,
            settling_time: times.lookahead,
            old_levels: OldTimeLevels::new(
                model,
                before,
                points,
                old,
                times.impulse_time - times.velocity_lead,
            ),
            elastic_slips,
            early_pairs: EarlyPairs::default(),
            friction_contacts: Vec::new(),
            pressure_impulses: vec![Vector::zeros(); points.node_count()],
        };
        potential.settling_time = potential.settling_time();
        let mut newton = Self {
            potential,
            solids,
            prescribed: prescribed_velocities(model, points, before, times.impulse_time),
            elimination: EliminationOrder {
                structure: None,
                positions: before.iter().flat_map(SolidState::node_positions).collect(),
            },
            velocities: vec![Vector::zeros(); points.node_count()],
            own_gradients: Vec::new(),
            candidates: CandidatePairs::default(),
            iteration: 0,
            is_loose: false,
            response: None,
            friction_updates: 0,
            indefinite_iterations: 0,
        };
        newton.move_to_initial_guess();
        newton
    }

    /// Moves to the initial guess that the velocities do not change, and finds there the lagged friction contacts and early pairs.
    fn move_to_initial_guess(&mut self) {
        let guess = self.prescribed.clone();
        let on_the_way = self.potential.candidates(&self.velocities, &guess);
        self.potential.friction_contacts = self.potential.friction_contacts(&self.velocities, &on_the_way);
        self.move_to(&guess, on_the_way, false);
        self.update_lagged();
        self.potential.early_pairs = self.potential.find_early_pairs(&self.velocities, &self.candidates);
    }

    /// Response of the solids about the current velocities. The `solids` get these velocities; `dragged` faces are tied to them.
    /// `phi` is the signed distance to the interface in each cell (m), and `open` holds the open fractions of the faces.
    ///
    /// # Errors
    /// [`SolveError::NotPositiveDefinite`], and [`SolveError::OutOfMemory`] where the matrix cannot be assembled.
    pub fn linearise(
        &mut self,
        solids: &mut [SolidState<D>],
        dragged: &mut [DraggedFace],
        phi: &[f64],
        open: &FaceField<D>,
    ) -> Result<SolidResponse<D>, SolveError> {
        let failed = SolveError::NotPositiveDefinite { step: self.potential.impulse_time };
        self.potential.pressure_impulses.fill(Vector::zeros());
        let ties = self.ties(dragged, phi, open);
        let Potential { model, points, solids: before, .. } = self.potential;
        points.set_node_velocities(model, solids, &self.velocities);
        let gradient = self.gradient();
        let mut base: Vec<Vector<D>> = gradient.iter().map(|g| -g).collect();
        if let Some(response) = self.response.take() {
            return Ok(response.about(base, ties));
        }
        let (potential, candidates, elimination) = (&self.potential, &self.candidates, &mut self.elimination);
        let mut inverse = |positive| {
            let matrix = potential.hessian(&self.velocities, candidates, &ties, elimination, positive);
            let found = (matrix, points.assembly.as_ref(), elimination.structure.as_ref());
            let (Some(matrix), Some(assembly), Some(structure)) = found else {
                return Err(SolveError::OutOfMemory { unknowns: D * self.velocities.len() });
            };
            Ok(assembly.invert(&matrix, structure).map(|solution| (matrix, solution)))
        };
        // The projected Hessian is a fallback: it is too stiff and converges slowly (Longva et al., "Pitfalls of projection", 2023).
        let whole = inverse(false)?;
        let indefinite = whole.is_none();
        let (matrix, solution) = match whole {
            Some(whole) => whole,
            None => inverse(true)?.ok_or(failed)?,
        };
        self.indefinite_iterations += u64::from(indefinite);
        let prescribed_change = self.prescribed_change();
        if prescribed_change.iter().any(|t| t.norm_squared() > 0.0) {
            let mut pushed = vec![Vector::zeros(); self.velocities.len()];
            matrix.add_product(&prescribed_change, &mut pushed);
            base.iter_mut().zip(&pushed).for_each(|(r, p)| *r -= p);
        }
        let loads = BaseLoads { impulses: base, prescribed_change, ties };
        Ok(SolidResponse::new(model, before, points, solution, loads))
    }

    /// Options of the pressure solve in this iteration.
    pub fn projection_options(&self) -> ProjectionOptions {
        let tolerance = self.potential.model.numerics.tolerance;
        ProjectionOptions {
            warm_start: self.iteration > 0,
            tolerance: if self.is_loose { tolerance.max(LOOSE_SOLVE_TOLERANCE) } else { tolerance },
        }
    }

    /// Gradient of the potential at the current velocities, N s (2D: N s/m).
    fn gradient(&self) -> Vec<Vector<D>> {
        self.potential.gradient(&self.own_gradients, &self.velocities, &self.candidates)
    }

    /// Updates the lagged elastic forces and viscosities, and the gradients that they enter, to the current velocities.
    fn update_lagged(&mut self) {
        for (part, first) in self.potential.parts.iter_mut().zip(&self.potential.points.first_node) {
            if let SolidTerm::Deformable(body) = part {
                let count = body.impulses.len();
                body.update_lagged(&self.velocities[*first..first + count]);
            }
        }
        self.own_gradients = self.potential.own_gradients(&self.velocities);
    }

    /// Ties the dragged faces to the solids, which have the current velocities.
    fn ties(&self, dragged: &mut [DraggedFace], phi: &[f64], open: &FaceField<D>) -> Vec<TiedFace<D>> {
        let Potential { model, points, .. } = self.potential;
        let weight = model.density * model.grid.cell_volume();
        let mut ties = Vec::new();
        for (dragged_face, f) in dragged.iter_mut().enumerate() {
            let at = model.grid.face_lattice(f.axis).coordinates(f.face);
            let x = model.grid.face_center(f.axis, at);
            let axis = Vector::<D>::from_fn(|a, _| if a == f.axis { 1.0 } else { 0.0 });
            let mut ends = Vec::new();
            for (drag_index, of) in f.drags.iter_mut().enumerate() {
                let solid = of.solid as usize;
                if model.solids[solid].kind.is_prescribed() {
                    continue;
                }
                let end = TiedSolid {
                    drag_index,
                    drag: of.drag,
                    node_weights: node_weights(&self.solids.get(solid), points.first_node[solid], &x, &axis),
                };
                of.solid_velocity = end.velocity(&self.velocities);
                ends.push(end);
            }
            if ends.is_empty() {
                continue;
            }
            let upper = model.grid.lattice().index(at);
            let lower = upper - model.grid.lattice().stride[f.axis];
            let sides = [(lower, 1.0), (upper, -1.0)].into_iter().filter(|(c, _)| phi[*c] < 0.0);
            ties.push(TiedFace {
                dragged_face,
                cells: sides.map(|(c, sign)| (c as u32, sign)).collect(),
                open_fraction: open.axes[f.axis][f.face],
                mobility: f.mobility(),
                mass: weight * f.volume_cells,
                solids: ends,
            });
        }
        ties
    }

    /// Maximum length of the coming step, s: on the straight path of that time nothing collides and no element inverts.
    pub fn collision_free_dt(&self) -> f64 {
        let still = vec![Vector::zeros(); self.velocities.len()];
        let part = self.potential.max_step_fraction(
            &still,
            &self.velocities,
            &self.velocities,
            &self.candidates,
            MIN_CLEARANCE_FRACTION,
        );
        self.potential.lookahead * part
    }

    /// Elastic slips at the start of the next step.
    pub fn next_slips(&self) -> Slips<D> {
        self.potential.next_slips(&self.velocities)
    }

    /// Stores each solid's mean acceleration by contacts. Returns the work, J (2D: J/m), of prescribed solids through contacts.
    pub fn store_contact_accelerations(&self, solids: &mut [SolidState<D>]) -> f64 {
        let Potential { model, points, impulse_time, .. } = self.potential;
        let given = self.potential.contact_impulses(&self.velocities, &self.candidates);
        for (k, now) in solids.iter_mut().enumerate() {
            let (solid, own) = (&model.solids[k], &given[points.first_node[k]..]);
            now.contact_acceleration = Vector::zeros();
            if let Some(elastic) = solid.elastic() {
                let count = elastic.masses().len();
                now.contact_acceleration =
                    own[..count].iter().sum::<Vector<D>>() / (solid.mass_properties.mass * impulse_time);
            } else if solid.kind.is_free_rigid() {
                now.contact_acceleration = own[0] / (solid.mass_properties.mass * impulse_time);
            }
        }
        let prescribed = (0..given.len()).filter(|node| points.prescribed_nodes[*node]);
        -prescribed.map(|node| given[node].dot(&self.velocities[node])).sum::<f64>()
    }

    /// Prescribed minus current velocities of the prescribed nodes; zero for the others.
    fn prescribed_change(&self) -> Vec<Vector<D>> {
        let of = |k: usize| {
            if self.potential.points.prescribed_nodes[k] {
                self.prescribed[k] - self.velocities[k]
            } else {
                Vector::zeros()
            }
        };
        (0..self.velocities.len()).map(of).collect()
    }

    /// Adds `change`, the `response` to a pressure with the impulses `pressed` on the nodes, as far as the line search allows. Returns
    /// whether the method has converged; the solids then have the final velocities.
    ///
    /// # Errors
    /// [`SolveError::NewtonNotConverged`] after too many iterations, and [`SolveError::DeformationTooLarge`].
    pub fn take_step(
        &mut self,
        solids: &mut [SolidState<D>],
        response: SolidResponse<D>,
        change: &[Vector<D>],
        pressed: Vec<Vector<D>>,
    ) -> Result<bool, SolveError> {
        let Potential { model, points, .. } = self.potential;
        let mut to: Vec<Vector<D>> = self.velocities.iter().zip(change).map(|(v, c)| v + c).collect();
        let prescribed_change = self.prescribed_change();
        (0..to.len())
            .filter(|k| self.potential.points.prescribed_nodes[*k])
            .for_each(|k| to[k] = self.prescribed[k]);
        self.potential.pressure_impulses = pressed;
        let prescribed_moves = prescribed_change.iter().any(|l| l.norm_squared() > 0.0);
        let limit =
            CONVERGENCE_TOLERANCE * self.potential.barrier.activation_distance / self.potential.lookahead;
        let size = to.iter().zip(&self.velocities).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        let on_the_way = self.potential.candidates(&self.velocities, &to);
        let whole = self.move_to(&to, on_the_way, !prescribed_moves && size > limit);
        self.iteration += 1;
        self.check_deformation()?;
        self.update_lagged();
        let early = self.potential.find_early_pairs(&self.velocities, &self.candidates);
        self.potential.early_pairs.retain_common(&early);
        let (off, settled) = if whole { self.convergence(&response, limit) } else { (f64::INFINITY, false) };
        let exact = !std::mem::replace(&mut self.is_loose, off > FAR_FROM_CONVERGENCE * limit);
        if settled && exact && self.iteration > model.numerics.newton_iterations as usize {
            points.set_node_velocities(model, solids, &self.velocities);
            return Ok(true);
        }
        // The same Hessian serves where only the lagged forces and friction are left to change, and where linear convergence, by `off/size`
        // an iteration, suffices.
        self.response = (off < limit || off * off < size * limit).then_some(response);
        if self.iteration >= MAX_NEWTON_ITERATIONS {
            return Err(SolveError::NewtonNotConverged { iterations: self.iteration, off: off / limit });
        }
        Ok(false)
    }

    /// Fails where an element deforms more than a step of adaptive length may.
    fn check_deformation(&self) -> Result<(), SolveError> {
        let increment = self.potential.deformation_increment(&self.velocities);
        if increment > MAX_FORCED_DEFORMATION_INCREMENT && self.potential.model.numerics.fixed_step.is_none()
        {
            return Err(SolveError::DeformationTooLarge {
                increment,
                limit: MAX_FORCED_DEFORMATION_INCREMENT,
            });
        }
        Ok(())
    }

    /// Predicted size of the next iteration, m/s, after a full Newton step, and whether the method has converged. If that size is below
    /// `limit` (m/s), the lagged friction is updated and the size predicted again.
    fn convergence(&mut self, response: &SolidResponse<D>, limit: f64) -> (f64, bool) {
        let off = self.next_step_size(response);
        if off >= limit || self.friction_updates == MAX_FRICTION_UPDATES {
            return (off, off < limit);
        }
        let early_pairs = self.potential.find_early_pairs(&self.velocities, &self.candidates);
        let friction_contacts = self.potential.friction_contacts(&self.velocities, &self.candidates);
        let has_friction = !friction_contacts.is_empty() || !self.potential.friction_contacts.is_empty();
        let is_unchanged = !has_friction && early_pairs == self.potential.early_pairs;
        (self.potential.early_pairs, self.potential.friction_contacts) = (early_pairs, friction_contacts);
        self.friction_updates += 1;
        let off = if is_unchanged { off } else { self.next_step_size(response) };
        (off, off < FRICTION_LAG_TOLERANCE * limit)
    }

    /// The largest change of a velocity, m/s, in the next iteration with this response and pressure.
    fn next_step_size(&self, response: &SolidResponse<D>) -> f64 {
        let mut gradient = self.gradient();
        response.solve(&mut gradient);
        gradient.iter().map(Vector::norm).fold(0.0, f64::max)
    }

    /// Moves towards the velocities `to` as far as no `candidates` collide and, if `must_decrease`, the potential does not increase.
    /// Returns whether it made the full step.
    fn move_to(&mut self, to: &[Vector<D>], candidates: CandidatePairs, must_decrease: bool) -> bool {
        let (next, whole) = self.line_search(to, &candidates, must_decrease);
        // Points of rotating solids leave the straight path between its ends.
        self.candidates = if whole { candidates } else { self.potential.candidates(&next, &next) };
        self.velocities = next;
        whole
    }

    /// Line search: the new velocities, and whether they are the full step.
    fn line_search(
        &self,
        to: &[Vector<D>],
        candidates: &CandidatePairs,
        must_decrease: bool,
    ) -> (Vec<Vector<D>>, bool) {
        let change: Vec<Vector<D>> = to.iter().zip(&self.velocities).map(|(t, v)| t - v).collect();
        let along = |part: f64| -> Vec<Vector<D>> {
            if part == 1.0 {
                return to.to_vec();
            }
            self.velocities.iter().zip(&change).map(|(v, c)| v + c * part).collect()
        };
        let mut part =
            self.potential.max_step_fraction(&self.velocities, &change, to, candidates, KEPT_FRACTION);
        if !must_decrease {
            return (along(part), part == 1.0);
        }
        let from = self.potential.value(&self.velocities, candidates);
        let slack = 1e-12 * from.abs();
        for _ in 0..MAX_LINE_SEARCH_HALVINGS {
            let next = along(part);
            if self.potential.value(&next, candidates) <= from + slack {
                return (next, part == 1.0);
            }
            part *= 0.5;
        }
        (self.velocities.clone(), false)
    }
}

/// Velocities of all nodes: prescribed ones at the end of the step, and the old ones of the others.
fn prescribed_velocities<const D: usize>(
    model: &Model<D>,
    points: &CollisionPoints<D>,
    before: &[SolidState<D>],
    impulse_time: f64,
) -> Vec<Vector<D>> {
    let mut prescribed = points.node_velocities(before);
    for (k, solid) in model.solids.iter().enumerate() {
        let Some((elastic, body)) = solid.elastic().zip(before[k].as_deformable()) else { continue };
        for (v, velocity) in elastic.anchored_velocities(body.vertices.time, impulse_time) {
            prescribed[points.first_node[k] + v] = velocity;
        }
    }
    prescribed
}

/// Velocity along `axis` of the solid's point closest to `x`, as weights of its nodes; `first` is the solid's first node.
fn node_weights<const D: usize>(
    solid: &SolidView<'_, D>,
    first: usize,
    x: &Vector<D>,
    axis: &Vector<D>,
) -> Vec<(usize, Vector<D>)> {
    match solid.surface.closest_point(x) {
        Some(grip) => (0..D).map(|k| (first + grip.vertices[k] as usize, axis * grip.weights[k])).collect(),
        None => {
            let moment = crate::coupling::impulses::moment(&(x - solid.state.center_of_mass()), axis);
            vec![(first, *axis), (first + 1, angular_to_node(&moment.into()))]
        }
    }
}
