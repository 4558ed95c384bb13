//! A step with the scheme of the paper ([`crate::paper`]), on the state and the workspace of a simulation.
//!
//! Level set, velocity and solids are those of the state. Positions and velocities are of the same time: the velocity lead is zero.
//! The volumes are measured as in the other scheme, and the scheme corrects the sum of all components: their targets are their volumes
//! times one factor. Liquid cells, band and cut cells are found anew after the step, for measurements and output.
//!
//! Limit: the volumes of components are not kept one by one.

use super::diagnostics::update_diagnostics;
use super::step::StepResult;
use super::workspace::Workspace;
use crate::flow::outflow::remove_outflow;
use crate::flow::pressure::FlowSolves;
use crate::model::time_step::PhaseEnd;
use crate::model::{Model, Scheme};
use crate::paper::time::scheme::PaperScheme;
use crate::paper::time::state::PaperState;
use crate::state::State;
use meniscus_numerics::linalg::SolveError;

/// Longest step over the explicit capillary limit: the forces of lines are explicit.
const MAX_CAPILLARY_STEP: f64 = 1.0;
/// Longest step over the limit of the explicit viscosity, `Δ²/(2 D ν)`; the rest is a margin.
const MAX_VISCOUS_STEP: f64 = 0.8;

/// Longest step that the explicit terms of the scheme of the paper allow, s; no bound for the other scheme.
pub fn stable_paper_dt<const D: usize>(model: &Model<D>) -> f64 {
    if model.numerics.scheme == Scheme::Meniscus {
        return f64::INFINITY;
    }
    let viscous = model.grid.dx.powi(2) / (2.0 * D as f64 * model.kinematic_viscosity);
    (MAX_CAPILLARY_STEP * model.capillary_dt_limit()).min(MAX_VISCOUS_STEP * viscous)
}

/// Advances the state by `dt` seconds.
///
/// # Errors
/// Those of the solves. The state is then as before.
pub fn paper_step<const D: usize>(
    model: &Model<D>,
    state: &mut State<D>,
    work: &mut Workspace<D>,
    dt: f64,
    phase_end: PhaseEnd<'_>,
) -> Result<StepResult, SolveError> {
    let scheme = match &work.paper {
        Some(scheme) => scheme.clone(),
        None => std::sync::Arc::new(PaperScheme::of_model(model.clone())),
    };
    let mut now = PaperState {
        time: state.time,
        phi: state.phi.clone(),
        velocity: state.velocity.clone(),
        solids: state.solids.clone(),
        line: Vec::new(),
        pressure_impulse: state.pressure_impulse.clone(),
        target_volume: 0.0,
    };
    if state.step == 0 {
        now.phi = scheme.restored_surface(&now.solids, now.phi);
    }
    let [target, volume] = volumes(state);
    if volume > 0.0 {
        now.target_volume = scheme.liquid_volume(&now) * target / volume;
    }
    let report = scheme.step(&mut now, dt)?;
    phase_end("paper");

    (state.phi, state.velocity, state.solids) = (now.phi, now.velocity, now.solids);
    state.pressure_impulse = now.pressure_impulse;
    (state.velocity_lead, state.impulse_time, state.last_dt) = (0.0, dt, dt);
    state.collision_free_dt = f64::INFINITY;
    state.time += dt;
    state.step += 1;
    work.update_solids(model, state);
    work.find_liquid(model, state);
    work.rebuild_velocity_extension(model, state);
    update_diagnostics(model, state, work);
    let [measured, _] = volumes(state);
    if measured > 0.0 {
        state.components.iter_mut().for_each(|c| c.target_volume *= target / measured);
    }
    remove_outflow(model, state, work);
    let solves = FlowSolves { pressure: [report.solves[2], report.solves[1]], ..FlowSolves::default() };
    Ok(StepResult { solves, newton_iterations: 0, prescribed_work: 0.0, volume_error_cells: 0.0 })
}

/// Sums of the target volumes and of the measured volumes of all components, m³ (2D: m²).
fn volumes<const D: usize>(state: &State<D>) -> [f64; 2] {
    let sum = |of: fn(&crate::state::Component<D>) -> f64| state.components.iter().map(of).sum();
    [sum(|c| c.target_volume), sum(|c| c.volume)]
}
