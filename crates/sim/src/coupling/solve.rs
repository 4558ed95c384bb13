//! The pressure solve of a step, and the impulses of pressure, contact lines and friction on the solids.
//!
//! Movable solids respond jointly to pressure and contacts, linearised about the current velocities of Newton's method
//! ([`crate::collision`]).

use super::impulses::CouplingImpulses;
use super::pressure::{WettedSurface, apply_impulses_to_rigid, wetted_surfaces};
use crate::collision::impact::resolve_impacts;
use crate::collision::newton::{NewtonSolver, OldSolids};
use crate::collision::potential::solid_terms::DeformableLoads;
use crate::components::restoration::{ComponentLabels, component_faces};
use crate::components::tracking::{ComponentChange, band_component, min_resolved_volume};
use crate::contact_line::force::{ContactLineForces, LineImpulses};
use crate::contact_line::friction::{DraggedFace, line_friction_impulses};
use crate::contact_line::solid_tension::{wetted_tension_forces, wetted_tension_stiffness};
use crate::flow::pressure::{FlowSolves, Projection, ProjectionOptions, ProjectionResult};
use crate::free_surface::interface_faces::InterfaceFace;
use crate::model::Model;
use crate::model::time_step::{PhaseEnd, StepTimes};
use crate::simulation::workspace::Workspace;
use crate::solid::{SolidState, Solids};
use crate::state::State;
use meniscus_numerics::Vector;
use meniscus_numerics::grid::{
    Band, CutCells, FaceField, Runs, Sampler, Segment, gather_segments, scatter_segments,
};
use meniscus_numerics::linalg::SolveError;

/// Results of the pressure solve.
pub struct PressureSolution<const D: usize> {
    /// The solves of the last Newton iteration, if there are several.
    pub solves: FlowSolves,
    /// Impulses of contact lines, pressure and friction on the solids.
    pub solid_impulses: [CouplingImpulses<D>; 3],
    /// Work, J (2D: J/m), of solids with prescribed motion through contacts.
    pub contact_work: f64,
    /// Number of Newton iterations for solids and pressure.
    pub newton_iterations: u64,
}

/// Inputs of the pressure solve beside model, state and workspace.
pub struct PressureStep<'a, const D: usize> {
    /// The solids before the forces of this step.
    pub solids_before: &'a [SolidState<D>],
    /// The faces at the interface.
    pub interface_faces: &'a [InterfaceFace],
    /// The faces that contact lines drag.
    pub dragged_faces: &'a mut [DraggedFace],
    /// Times of the step.
    pub times: StepTimes,
}

/// Makes the velocity divergence-free and applies the impulses to the solids.
///
/// # Errors
/// A solve does not converge, or a matrix is not positive definite.
pub fn solve_pressure<const D: usize>(
    model: &Model<D>,
    state: &mut State<D>,
    work: &mut Workspace<D>,
    change: &ComponentChange<D>,
    step: PressureStep<'_, D>,
    phase_end: PhaseEnd<'_>,
) -> Result<PressureSolution<D>, SolveError> {
    let impulse_time = step.times.impulse_time;
    let line = apply_contact_line_forces(model, state, work, change, step.interface_faces, impulse_time);
    let SolidImpulses { solves, impulses: [pressure, friction], contact_work, newton_iterations } =
        match model.has_dynamic_solids() {
            true => solve_with_dynamic_solids(model, state, work, step, &line, phase_end)?,
            false => solve_with_prescribed_solids(model, state, work, step, phase_end)?,
        };
    let solid_impulses = [line, pressure, friction];
    store_solid_forces(&mut state.solids, &solid_impulses, impulse_time);
    Ok(PressureSolution { solves, solid_impulses, contact_work, newton_iterations })
}

/// Impulses of the contact lines on the solids. The remainder along plane walls accelerates each liquid
/// component as a whole; for components below [`min_resolved_volume`] it is dropped.
fn apply_contact_line_forces<const D: usize>(
    model: &Model<D>,
    state: &mut State<D>,
    work: &mut Workspace<D>,
    change: &ComponentChange<D>,
    interface_faces: &[InterfaceFace],
    impulse_time: f64,
) -> CouplingImpulses<D> {
    let touches_no_side: Vec<bool> = work.component_contacts(model).iter().map(|t| !t.domain_side).collect();
    let label = work.liquid.component_lookup(&model.grid);
    let near = band_component(&work.band, &change.band_labels);
    let phi = Sampler::cells(&model.grid, &state.phi.data, model.scalar_boundary());
    let solids = Solids { model, states: &state.solids, surfaces: &work.surfaces };
    let dual_cells = &change.dual_cells;
    let LineImpulses { on_solids: line, on_liquid: along, moment_lost } = if model.numerics.contact_line {
        let tensions = &wetted_tension_forces(solids, &phi, &label);
        let (phi, wet, centers) = (&state.phi.data, &work.cut_cells.cells, &change.centers);
        let (label, touches_no_side) = (&near, &touches_no_side);
        ContactLineForces {
            solids,
            phi,
            dual_cells,
            interface_faces,
            wet,
            centers,
            label,
            touches_no_side,
            wetted_tensions: tensions,
        }
        .impulses(impulse_time)
    } else {
        let on_liquid = vec![Vector::zeros(); touches_no_side.len()];
        LineImpulses { on_solids: CouplingImpulses::new(), on_liquid, moment_lost: 0.0 }
    };
    work.repairs.line_moment_lost += moment_lost;
    // For an unresolved drop the force along the walls is discretisation noise.
    let least = min_resolved_volume(model);
    let speed = |(j, volume): (&Vector<D>, &f64)| {
        if *volume > least { j / (model.density * volume) } else { Vector::zeros() }
    };
    let along: Vec<Vector<D>> = along.iter().zip(&change.target_volumes).map(speed).collect();
    let labels = ComponentLabels::new(&label);
    let of = |cell: usize| labels.of(cell);
    component_faces(model, &state.phi, work, interface_faces, &of)
        .add_velocities(&mut state.velocity, &along);
    work.repairs.unlabelled += labels.missing();
    line
}

/// Results of one of the two solves below.
struct SolidImpulses<const D: usize> {
    solves: FlowSolves,
    /// Impulses of pressure and friction.
    impulses: [CouplingImpulses<D>; 2],
    contact_work: f64,
    newton_iterations: u64,
}

/// Pressure solve if all solids have prescribed motion.
fn solve_with_prescribed_solids<const D: usize>(
    model: &Model<D>,
    state: &mut State<D>,
    work: &mut Workspace<D>,
    mut step: PressureStep<'_, D>,
    phase_end: PhaseEnd<'_>,
) -> Result<SolidImpulses<D>, SolveError> {
    let label = work.liquid.component_lookup(&model.grid);
    let solids = Solids { model, states: step.solids_before, surfaces: &work.surfaces };
    let wet = wetted_surfaces(solids, &work.cut_cells, &state.phi.data);
    let domain = ProjectionDomain {
        band: &work.band,
        liquid: &work.liquid,
        liquid_faces: work.known_faces.liquid_faces(),
        cut_cells: &mut work.cut_cells,
        wetted_surfaces: &wet,
        label: &label,
    };
    let mut projection = build_projection(model, state, domain, &mut step);
    let pass = ProjectionOptions { warm_start: false, tolerance: model.numerics.tolerance };
    let ProjectionResult { solves, pressure_impulses, .. } =
        work.pressure.project(model, &mut projection, None, pass, phase_end)?;
    let friction = line_friction_impulses(solids, &state.velocity, step.dragged_faces, &label);
    Ok(SolidImpulses {
        solves,
        impulses: [pressure_impulses, friction],
        contact_work: 0.0,
        newton_iterations: 0,
    })
}

/// Joint solve of pressure, movable solids and contacts by Newton's method.
fn solve_with_dynamic_solids<const D: usize>(
    model: &Model<D>,
    state: &mut State<D>,
    work: &mut Workspace<D>,
    mut step: PressureStep<'_, D>,
    line: &CouplingImpulses<D>,
    phase_end: PhaseEnd<'_>,
) -> Result<SolidImpulses<D>, SolveError> {
    let (before, times) = (step.solids_before, step.times);
    let solids = Solids { model, states: before, surfaces: &work.surfaces };
    let stiffness = wetted_tension_stiffness(solids, &state.phi);
    let loads = DeformableLoads::of_solids(model, line, stiffness, times.impulse_time);
    apply_impulses_to_rigid(model, &mut state.solids, line);
    let points = work.collision_points.clone();
    let start = LiquidVelocity::of(&state.velocity, work.known_faces.liquid_faces());
    let impact_work = resolve_impacts(model, &points, &mut state.solids, before, times, &mut work.repairs);
    let slips = std::mem::take(&mut state.elastic_slips);
    let from = OldSolids { solids, velocities: &points.node_velocities(before), elastic_slips: &slips };
    let mut newton = NewtonSolver::new(&points, from, &state.solids, &loads, times);
    let label = work.liquid.component_lookup(&model.grid);
    let wet = wetted_surfaces(solids, &work.cut_cells, &state.phi.data);
    let mut iteration = 0;
    loop {
        iteration += 1;
        let response = newton.linearise(
            &mut state.solids,
            step.dragged_faces,
            &state.phi.data,
            &work.cut_cells.open_fraction,
        )?;
        let domain = ProjectionDomain {
            band: &work.band,
            liquid: &work.liquid,
            liquid_faces: work.known_faces.liquid_faces(),
            cut_cells: &mut work.cut_cells,
            wetted_surfaces: &wet,
            label: &label,
        };
        let mut projection = build_projection(model, state, domain, &mut step);
        let ProjectionResult { solves, pressure_impulses: pressure, node_velocity_change } = work
            .pressure
            .project(model, &mut projection, Some(&response), newton.projection_options(), phase_end)?;
        let friction = line_friction_impulses(solids, &state.velocity, step.dragged_faces, &label);
        let mut node_impulses = pressure.clone();
        node_impulses.extend(&friction);
        let node_impulses = response.node_impulses(model, before, &node_impulses);
        if newton.take_step(&mut state.solids, response, &node_velocity_change, node_impulses)? {
            (state.collision_free_dt, state.elastic_slips) =
                (newton.collision_free_dt(), newton.next_slips());
            work.repairs.indefinite_iterations += newton.indefinite_iterations;
            let contact_work = newton.store_contact_accelerations(&mut state.solids);
            return Ok(SolidImpulses {
                solves,
                impulses: [pressure, friction],
                contact_work: contact_work + impact_work,
                newton_iterations: iteration,
            });
        }
        start.restore(&mut state.velocity, work.known_faces.liquid_faces());
    }
}

/// The velocity on the liquid's faces, the only one that a projection changes.
struct LiquidVelocity<const D: usize>([Vec<f64>; D]);

impl<const D: usize> LiquidVelocity<D> {
    fn of(velocity: &FaceField<D>, faces: &[Vec<Segment>; D]) -> Self {
        let row = |a: usize| velocity.grid.face_lattice(a).extent[0];
        Self(std::array::from_fn(|a| gather_segments(&velocity.axes[a], row(a), &faces[a])))
    }

    fn restore(&self, velocity: &mut FaceField<D>, faces: &[Vec<Segment>; D]) {
        for (a, values) in self.0.iter().enumerate() {
            let row = velocity.grid.face_lattice(a).extent[0];
            scatter_segments(&mut velocity.axes[a], row, &faces[a], values);
        }
    }
}

/// Where a projection makes the velocity divergence-free.
struct ProjectionDomain<'a, const D: usize> {
    band: &'a Band<D>,
    liquid: &'a Runs,
    liquid_faces: &'a [Vec<Segment>; D],
    cut_cells: &'a mut CutCells<D>,
    wetted_surfaces: &'a [WettedSurface<D>],
    /// Component of a liquid cell.
    label: &'a (dyn Fn(usize) -> Option<u32> + Sync),
}

/// The projection of the velocity in `state`.
fn build_projection<'a, const D: usize>(
    model: &Model<D>,
    state: &'a mut State<D>,
    domain: ProjectionDomain<'a, D>,
    step: &'a mut PressureStep<'_, D>,
) -> Projection<'a, D> {
    let impulse_time = step.times.impulse_time;
    Projection {
        velocity: &mut state.velocity,
        pressure_impulse: &mut state.pressure_impulse,
        phi: &state.phi,
        band: domain.band,
        liquid: domain.liquid,
        liquid_faces: domain.liquid_faces,
        interface_faces: step.interface_faces,
        dragged_faces: step.dragged_faces,
        cut_cells: domain.cut_cells,
        solids: &state.solids,
        wetted_surfaces: domain.wetted_surfaces,
        label: domain.label,
        tension_impulse: model.surface_tension * impulse_time / (model.density * model.grid.dx),
        impulse_time,
    }
}

/// Stores in the solids the mean forces of contact lines, pressure and friction over the time `impulse_time`.
fn store_solid_forces<const D: usize>(
    solids: &mut [SolidState<D>],
    given: &[CouplingImpulses<D>; 3],
    impulse_time: f64,
) {
    let [line, pressure, friction] = given.each_ref().map(|exchange| exchange.by_solid(solids.len()));
    let pulls = line.into_iter().zip(friction);
    for ((now, (line, friction)), pressure) in solids.iter_mut().zip(pulls).zip(pressure) {
        now.contact_line_force = (line.linear + friction.linear) / impulse_time;
        now.pressure_force = pressure.linear / impulse_time;
    }
}

/// Work, J (2D: J/m), of solids with prescribed motion on the liquid.
pub fn prescribed_solid_work<const D: usize>(
    model: &Model<D>,
    state: &State<D>,
    given: &[CouplingImpulses<D>; 3],
) -> f64 {
    let mut work = 0.0;
    for (pair, impulse) in given.iter().flat_map(|g| &g.pairs) {
        if model.solids[pair.solid as usize].kind.is_prescribed() {
            let rigid = state.solids[pair.solid as usize].as_rigid();
            let turning = impulse.moment_about(&rigid.center).dot(&Vector::<3>::from(rigid.angular_velocity));
            work -= impulse.linear.dot(&rigid.velocity) + turning;
        }
    }
    work
}
