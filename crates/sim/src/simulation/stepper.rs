//! A simulation in memory: the model, the state, and the choice of steps.

use super::diagnostics::{
    Diagnostics, StepReport, diagnostics, energy_without_gravity, max_velocity_component, potential_energy,
    update_diagnostics,
};
use super::paper_step::{paper_step, stable_paper_dt};
use super::repairs::Repairs;
use super::step::{StepResult, step as meniscus_step};
use super::transport::restore_signed_distance;
use super::workspace::{Snapshot, Workspace};
use crate::contact_line::sampling::phi_at_solid;
use crate::model::resolution::BAND_WIDTH_CELLS;
use crate::model::time_step::{PhaseEnd, deformation_dt, next_dt, stable_dt, uniform_dt};
use crate::model::{Model, Scheme};
use crate::solid::{SolidView, Solids};
use crate::state::State;
use meniscus_numerics::grid::{Band, Runs, Sampler};
use meniscus_numerics::linalg::SolveError;
use meniscus_numerics::mesh::SurfaceMesh;
use meniscus_numerics::{Vector, par};
use thiserror::Error;

/// A region of liquid at the start.
pub struct LiquidRegion<'a, const D: usize> {
    /// Signed distance to its surface, m, negative inside.
    pub signed_distance: &'a (dyn Fn(&Vector<D>) -> f64 + Sync),
    /// Initial velocity, m/s.
    pub velocity: Vector<D>,
}

/// Reason why a step failed. The state is as it was before the step, except that the initial guess of the
/// pressure is zero, and that φ at its bound within solids may have the sign of the failed step.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum StepError {
    /// The solve failed even with the shortest step tried.
    #[error("at time {time:.6e} s, in a time step of {dt:.3e} s: {source}")]
    SolveFailed {
        /// Time of the last good state, s.
        time: f64,
        /// Step length tried last, s.
        dt: f64,
        /// Error of the solver.
        source: SolveError,
    },
    /// A value is not finite.
    #[error("the {what} is not finite after the step from time {time:.6e} s")]
    NotFinite {
        /// Time of the last good state, s.
        time: f64,
        /// The field.
        what: &'static str,
    },
    /// The step was halved too often.
    #[error("at time {time:.6e} s even a time step of {dt:.3e} s fails: {reason}")]
    TooShort {
        /// Time of the last good state, s.
        time: f64,
        /// Step length tried last, s.
        dt: f64,
        /// Reason of the failure.
        reason: String,
    },
}

/// Largest number of halvings of a failed step.
const MAX_RETRIES: u64 = 6;
/// Largest number of halvings for accuracy, counted from the longest step allowed; a shorter step is accepted.
const MAX_ACCURACY_HALVINGS: u32 = 2;
/// Volume error of a component in one step, as a layer in cells, above which the step is doubtful.
const MAX_VOLUME_ERROR_CELLS: f64 = 0.1;
/// Shortest step over the longest that surface tension, gravity and the user allow. It is far below what any splash or impact
/// needs: a shorter one means a diverging liquid, or solids without room between them.
const MIN_DT_RATIO: f64 = 1e-5;
/// Energy gain in one step, over the energy without gravity, above which the step is doubtful.
const MAX_ENERGY_GROWTH: f64 = 0.05;
/// Displacement of the liquid in a step, in cells, above which the step has failed.
const MAX_DISPLACEMENT_CELLS: f64 = 30.0;
/// Displacement in a step and height of fall, in cells, whose energy is treated as rounding.
const NEGLIGIBLE_DISPLACEMENT_CELLS: f64 = 1e-6;

/// Quantities of the state before a step, with which the state after it is compared.
struct StepStart {
    /// Time, s.
    time: f64,
    /// Largest speed of liquid and solids, m/s.
    speed: f64,
    /// Energy without gravity, J (2D: J/m).
    energy: f64,
    /// All energy, with what has left, J (2D: J/m).
    total_energy: f64,
    /// Longest stable step, s.
    max_stable_dt: f64,
    /// Shortest step tried, s.
    min_dt: f64,
}

/// Decision on a step that has been taken.
enum Verdict {
    /// It is accepted. A doubtful one is not tried again: it is too short, of fixed length, or of the paper's scheme.
    Accepted { doubtful: bool },
    /// It is tried once more with half its length.
    Doubtful,
    /// It is tried once more with half its length, or ends the run.
    Failed(StepError),
}

/// A model, its state, and the workspace of a step.
pub struct Simulation<const D: usize> {
    /// The fixed parameters.
    pub model: Model<D>,
    /// The evolving state.
    pub state: State<D>,
    pub(crate) workspace: Workspace<D>,
    functions: Functions<D>,
}

impl<const D: usize> Simulation<D> {
    /// A simulation that starts from regions of liquid. Where regions overlap, the first one's velocity applies. Liquid that
    /// may reach an open side needs a model [with open sides](Model::with_open_sides).
    pub fn new(model: Model<D>, regions: &[LiquidRegion<'_, D>]) -> Self
    where
        Self: Compiled<D>,
    {
        (Self::functions().start)(model, regions)
    }

    /// Resumes a simulation from a state (a checkpoint), with the same bits as without an interruption.
    pub fn resume(model: Model<D>, state: State<D>) -> Self
    where
        Self: Compiled<D>,
    {
        (Self::functions().resume)(model, state)
    }

    fn start(model: Model<D>, regions: &[LiquidRegion<'_, D>]) -> Self
    where
        Self: Compiled<D>,
    {
        let grid = model.grid;
        let mut state = State::empty(grid);
        state.solids = model.initial_solids();
        let limit = BAND_WIDTH_CELLS * grid.dx;
        let lattice = grid.lattice();
        par::for_each_mut(&mut state.phi.data, 1, |i, value| {
            let x = model.mirrored(&grid.center(lattice.coordinates(i)));
            let distance = regions.iter().map(|b| (b.signed_distance)(&x)).fold(f64::INFINITY, f64::min);
            *value = distance.max(model.open_side_distance(&x)).clamp(-limit, limit);
        });
        let mut simulation = Self::of_state(model, state);
        simulation.clamp_phi_beyond_band();
        simulation.redistance_at_wetting_walls();
        simulation.initialise_velocity(regions);
        simulation.workspace.rebuild_velocity_extension(&simulation.model, &mut simulation.state);
        update_diagnostics(&simulation.model, &mut simulation.state, &simulation.workspace);
        simulation
    }

    fn of_state(model: Model<D>, mut state: State<D>) -> Self
    where
        Self: Compiled<D>,
    {
        let workspace = Workspace::new(&model, &mut state);
        Self { model, state, workspace, functions: Self::functions() }
    }

    /// Clamps φ beyond the band, as every step does.
    fn clamp_phi_beyond_band(&mut self) {
        let (work, limit) = (&self.workspace, BAND_WIDTH_CELLS * self.model.grid.dx);
        par::for_each_mut(&mut self.state.phi.data, 256, |cell, value| {
            if work.band.slot(cell).is_none() {
                *value = limit.copysign(*value);
            }
        });
    }

    /// Redistances φ where sides wet: liquid may end at a side, where there is no interface.
    fn redistance_at_wetting_walls(&mut self) {
        if self.model.wetting_wall_solid().is_none() {
            return;
        }
        self.state.displacement_since_redistancing = f64::INFINITY;
        restore_signed_distance(&self.model, &mut self.state, &self.workspace);
    }

    fn initialise_velocity(&mut self, regions: &[LiquidRegion<'_, D>]) {
        let grid = self.model.grid;
        for a in 0..D {
            let faces = grid.face_lattice(a);
            let row = faces.extent[0];
            let model = &self.model;
            par::for_each_segment(
                &mut self.state.velocity.axes[a],
                row,
                &self.workspace.known_faces.liquid_faces()[a],
                |s, part| {
                    for (i, u) in part.iter_mut().enumerate() {
                        let at = faces.coordinates(s.row * row + s.start + i);
                        let x = grid.face_center(a, at);
                        let nearest = regions
                            .iter()
                            .map(|b| ((b.signed_distance)(&x), b.velocity[a]))
                            .reduce(|best, b| if best.0 < 0.0 || best.0 <= b.0 { best } else { b });
                        *u = if model.on_closed_side(a, at[a]) { 0.0 } else { nearest.map_or(0.0, |b| b.1) };
                    }
                },
            );
        }
    }

    /// Takes a step and undoes it like a failed one; for tests of that.
    ///
    /// # Errors
    /// Those of [`Simulation::step`].
    pub fn step_and_undo(&mut self, max_dt: f64) -> Result<StepReport<D>, StepError> {
        let snapshot = Snapshot::take(&self.model, &mut self.state, &mut self.workspace);
        let report = self.step(max_dt, &mut |_| {});
        snapshot.restore(&self.model, &mut self.state, &mut self.workspace);
        report
    }

    /// Advances by one time step of at most `max_dt` (s). Stability or accuracy may shorten it, and its length is chosen so
    /// that steps of equal length end at `max_dt`.
    ///
    /// # Errors
    /// [`StepError`], which tells how the state is then.
    pub fn step(&mut self, max_dt: f64, phase_end: PhaseEnd<'_>) -> Result<StepReport<D>, StepError> {
        (self.functions.step)(self, max_dt, phase_end)
    }

    /// Sets the acceleration of gravity, m/s², from the next step on. No checkpoint has it: it belongs to the model.
    pub fn set_gravity(&mut self, gravity: Vector<D>) {
        self.model.gravity = gravity;
        self.workspace.dual_grid.set_bond_vector(self.model.cell_bond_vector());
    }

    fn advance(&mut self, max_dt: f64, phase_end: PhaseEnd<'_>) -> Result<StepReport<D>, StepError> {
        let start = self.step_start()?;
        let mut dt = self.choose_dt(start.max_stable_dt, max_dt);
        let (mut redone, mut failed_tries) = (0, 0);
        // Ends after [`MAX_RETRIES`] and [`MAX_ACCURACY_HALVINGS`].
        loop {
            self.workspace.repairs = Repairs::default();
            let snapshot = Snapshot::take(&self.model, &mut self.state, &mut self.workspace);
            let step = match self.model.numerics.scheme {
                Scheme::Meniscus => meniscus_step,
                Scheme::Paper | Scheme::PaperAsPrinted => paper_step,
            };
            let result = step(&self.model, &mut self.state, &mut self.workspace, dt, phase_end);
            let failure = match result.map(|result| (self.judge(&start, &result, dt), result)) {
                Ok((Verdict::Accepted { doubtful }, result)) => {
                    let doubtful_steps = u64::from(doubtful);
                    let own = std::mem::take(&mut self.workspace.repairs);
                    let repairs = Repairs { redone, failed_tries, doubtful_steps, ..own };
                    let (solves, newton_iterations) = (result.solves, result.newton_iterations);
                    let (cfl, diagnostics) = (start.speed * dt / self.model.grid.dx, self.diagnostics());
                    return Ok(StepReport { dt, cfl, solves, newton_iterations, repairs, diagnostics });
                }
                Ok((Verdict::Doubtful, _)) => None,
                Ok((Verdict::Failed(error), _)) => Some(error),
                Err(source) => Some(StepError::SolveFailed { time: start.time, dt, source }),
            };
            snapshot.restore(&self.model, &mut self.state, &mut self.workspace);
            redone += 1;
            failed_tries += u64::from(failure.is_some());
            let is_last =
                redone > MAX_RETRIES || 0.5 * dt < start.min_dt && self.model.numerics.fixed_step.is_none();
            if let Some(failure) = failure.filter(|_| is_last) {
                return Err(failure);
            }
            dt *= 0.5;
        }
    }

    /// Measures the state before a step.
    fn step_start(&self) -> Result<StepStart, StepError> {
        let solids = self.model.solids.iter().zip(&self.state.solids).map(|(s, now)| s.max_speed(now));
        let liquid = max_velocity_component(&self.model, &self.state, &self.workspace);
        let solids = solids.fold(0.0, f64::max);
        let speed = liquid.max(solids);
        let max_stable_dt =
            self.max_stable_dt(speed, if solids > liquid { "a solid" } else { "the liquid" })?;
        let dt_at_rest = stable_dt(&self.model, 0.0);
        let energy = energy_without_gravity(&self.model, &self.state);
        Ok(StepStart {
            time: self.state.time,
            speed,
            energy,
            total_energy: energy + potential_energy(&self.model, &self.state) + self.state.outflow_energy(),
            max_stable_dt,
            min_dt: if dt_at_rest.is_finite() { MIN_DT_RATIO * dt_at_rest } else { 0.0 },
        })
    }

    /// Judges a step of `dt` (s) from the state after it: it fails where the liquid moves too far, and is doubtful where energy is gained
    /// or a volume has changed, until it is short enough.
    fn judge(&self, start: &StepStart, result: &StepResult, dt: f64) -> Verdict {
        let (model, state) = (&self.model, &self.state);
        let displacement_cells = max_velocity_component(model, state, &self.workspace) * dt / model.grid.dx;
        if !displacement_cells.is_finite() {
            return Verdict::Failed(StepError::NotFinite { time: start.time, what: "velocity" });
        }
        if !state.kinetic_energy.is_finite() || displacement_cells >= MAX_DISPLACEMENT_CELLS {
            let reason = format!("the liquid would move by {displacement_cells:.1e} cells in one step");
            return Verdict::Failed(StepError::TooShort { time: start.time, dt, reason });
        }
        let own = energy_without_gravity(model, state) + state.outflow_energy();
        let energy_gain = own + potential_energy(model, state) - start.total_energy - result.prescribed_work;
        let doubtful = result.volume_error_cells > MAX_VOLUME_ERROR_CELLS
            || energy_gain > MAX_ENERGY_GROWTH * start.energy.abs() + self.negligible_energy(dt);
        let accept_below_dt = 1.5 * 0.5f64.powi(MAX_ACCURACY_HALVINGS as i32) * start.max_stable_dt;
        let is_redone = model.numerics.fixed_step.is_none() && model.numerics.scheme == Scheme::Meniscus;
        match doubtful && dt >= accept_below_dt && is_redone {
            true => Verdict::Doubtful,
            false => Verdict::Accepted { doubtful },
        }
    }

    /// Length of the next step, s, at most `wanted` and `max_dt`. No step, not even a constant one after a halved one, is longer
    /// than the time over which contacts and elements were looked ahead.
    fn choose_dt(&self, mut wanted: f64, max_dt: f64) -> f64 {
        if self.state.last_dt > 0.0 {
            wanted = wanted.min(self.state.collision_free_dt);
        }
        if self.model.numerics.fixed_step.is_some() || self.state.last_dt == 0.0 {
            return uniform_dt(max_dt, wanted);
        }
        next_dt(self.state.velocity_lead, wanted, max_dt)
    }

    /// Longest step that surface tension, the largest speed and the deformation of solids allow; `fastest` names what has that speed.
    fn max_stable_dt(&self, speed: f64, fastest: &str) -> Result<f64, StepError> {
        if let Some(dt) = self.model.numerics.fixed_step {
            return Ok(dt);
        }
        let dt_at_rest = stable_dt(&self.model, 0.0);
        let deformation_dt = deformation_dt(&self.model, &self.state.solids);
        let dt = stable_dt(&self.model, speed).min(deformation_dt).min(stable_paper_dt(&self.model));
        if dt_at_rest.is_finite() && dt < MIN_DT_RATIO * dt_at_rest {
            let reason = if dt == deformation_dt {
                "a deformable solid deforms too fast for longer steps".to_string()
            } else {
                format!("the speed of {fastest} has diverged to {speed:.3e} m/s")
            };
            return Err(StepError::TooShort { time: self.state.time, dt, reason });
        }
        Ok(dt)
    }

    /// Energy of negligible motions: without it rounding alone would be doubtful in a liquid at rest.
    fn negligible_energy(&self, dt: f64) -> f64 {
        let mass = self.model.density * self.state.components.iter().map(|d| d.target_volume).sum::<f64>();
        let displacement = NEGLIGIBLE_DISPLACEMENT_CELLS * self.model.grid.dx;
        mass * ((displacement / dt).powi(2) + displacement * self.model.gravity.norm())
    }

    /// The liquid cells (centre in the liquid) as runs labelled with their component.
    pub fn liquid_cells(&self) -> &Runs {
        &self.workspace.liquid
    }

    /// The cells of the narrow band.
    pub fn band(&self) -> &Band<D> {
        &self.workspace.band
    }

    /// The solids in their current states.
    pub fn solids(&self) -> Solids<'_, D> {
        Solids { model: &self.model, states: &self.state.solids, surfaces: &self.workspace.surfaces }
    }

    /// A solid in its current state.
    pub fn solid(&self, number: usize) -> SolidView<'_, D> {
        self.solids().get(number)
    }

    /// Signed distance of a point to the nearest solid in its current position, m, negative inside.
    pub fn distance_to_solids(&self, x: &Vector<D>) -> f64 {
        self.solids().iter().map(|solid| solid.distance(x)).fold(f64::INFINITY, f64::min)
    }

    /// Wetted fraction of a solid's surface, 0 to 1.
    pub fn wetted_fraction(&self, number: usize) -> f64 {
        (self.functions.wetted_fraction)(self, number)
    }

    fn wetted_fraction_of(&self, number: usize) -> f64 {
        let solid = self.solid(number);
        if solid.state.as_deformable().is_some() {
            return self.wetted_fraction_of_surface(&solid.surface.mesh, solid.padding);
        }
        let own = self.workspace.cut_cells.cells.iter().filter(|w| w.solid as usize == number);
        let wet = own.filter(|w| self.state.phi.data[w.cell as usize] < 0.0);
        let wet = wet.map(|w| w.area_vector.norm()).sum::<f64>() * self.model.grid.face_area();
        let all = self.workspace.initial_solid_areas[number];
        if all > 0.0 { (wet / all).min(1.0) } else { 0.0 }
    }

    /// Wetted fraction of a surface: a facet is wet if there is liquid `padding` (m) above its centre.
    fn wetted_fraction_of_surface(&self, surface: &SurfaceMesh<D>, padding: f64) -> f64 {
        let grid = &self.model.grid;
        let phi = Sampler::cells(grid, &self.state.phi.data, self.model.scalar_boundary());
        let (mut wet, mut all) = (0.0, 0.0);
        for (f, facet) in surface.facets.iter().enumerate() {
            let middle = facet.iter().map(|v| surface.positions[*v as usize]).sum::<Vector<D>>() / D as f64;
            let area = surface.area_vector(f);
            let size = area.norm();
            all += size;
            let normal = area / size;
            if size > 0.0 && phi_at_solid(&phi, &(middle + normal * padding), &normal, grid.dx) < 0.0 {
                wet += size;
            }
        }
        if all > 0.0 { wet / all } else { 0.0 }
    }

    /// Diagnostics of the current state.
    pub fn diagnostics(&self) -> Diagnostics<D> {
        (self.functions.diagnostics)(&self.model, &self.state, &self.workspace)
    }
}

/// The functions of a simulation that this crate compiles. Generic code is compiled again in every crate that uses it, with
/// everything it calls, here the whole step: a simulation holds pointers to them instead.
#[derive(Clone, Copy)]
pub struct Functions<const D: usize> {
    start: fn(Model<D>, &[LiquidRegion<'_, D>]) -> Simulation<D>,
    resume: fn(Model<D>, State<D>) -> Simulation<D>,
    step: fn(&mut Simulation<D>, f64, PhaseEnd<'_>) -> Result<StepReport<D>, StepError>,
    diagnostics: fn(&Model<D>, &State<D>, &Workspace<D>) -> Diagnostics<D>,
    wetted_fraction: fn(&Simulation<D>, usize) -> f64,
}

impl<const D: usize> Functions<D>
where
    Simulation<D>: Compiled<D>,
{
    fn all() -> Self {
        Self {
            start: Simulation::start,
            resume: Simulation::of_state,
            step: Simulation::advance,
            diagnostics,
            wetted_fraction: Simulation::wetted_fraction_of,
        }
    }
}

/// A simulation in two or three dimensions. Generic code that starts one has the bound `Simulation<D>: Compiled<D>`.
pub trait Compiled<const D: usize> {
    /// The functions that are compiled for this dimension.
    fn functions() -> Functions<D>;
}

impl Compiled<2> for Simulation<2> {
    // Inlined, or as a constant, it would have the functions compiled where it is used.
    #[inline(never)]
    fn functions() -> Functions<2> {
        Functions::all()
    }
}

impl Compiled<3> for Simulation<3> {
    #[inline(never)]
    fn functions() -> Functions<3> {
        Functions::all()
    }
}
