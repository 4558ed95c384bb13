//! Models and drops shared by the cases, in any consistent units.

use crate::measure::{Roundness, fit_mode, surface_points};
use meniscus_numerics::grid::Grid;
use meniscus_numerics::shape::Shape;
use meniscus_numerics::{Matrix, Vector};
use meniscus_sim::{
    Compiled, LiquidRegion, Model, Numerics, Scheme, Simulation, Solid, SolidKind, StepError, StepReport,
    Wall,
};
use serde::{Deserialize, Serialize};
use std::sync::OnceLock;

/// Radius of the drops.
pub const RADIUS: f64 = 0.5;
/// Surface tension.
pub const TENSION: f64 = 100.0;

/// The scheme of all simulations that cases start.
static SCHEME: OnceLock<Scheme> = OnceLock::new();

/// Chooses the scheme of all simulations that cases start in this process; the first choice holds. Without one it is that of Meniscus.
pub fn choose_scheme(scheme: Scheme) {
    let _ = SCHEME.set(scheme);
}

/// A simulation of a model with the chosen scheme and bodies of liquid.
pub fn started<const D: usize>(mut model: Model<D>, regions: &[LiquidRegion<'_, D>]) -> Simulation<D>
where
    Simulation<D>: Compiled<D>,
{
    if let Some(scheme) = SCHEME.get() {
        model.numerics.scheme = *scheme;
    }
    Simulation::new(model, regions)
}

/// A liquid without viscosity and gravity: density 1, tension 100.
pub fn model<const D: usize>(grid: Grid<D>, walls: [[Wall; 2]; D]) -> Model<D> {
    Model { surface_tension: TENSION, ..unit_model(grid, walls) }
}

/// A liquid without viscosity and gravity: density 1, tension 1.
pub fn unit_model<const D: usize>(grid: Grid<D>, walls: [[Wall; 2]; D]) -> Model<D> {
    Model {
        grid,
        walls,
        density: 1.0,
        kinematic_viscosity: 0.0,
        surface_tension: 1.0,
        gravity: Vector::zeros(),
        solids: Vec::new(),
        numerics: Numerics::default(),
    }
}

/// Bounds of the step length.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StepBounds {
    /// Longest step over the explicit capillary limit.
    pub capillary_step: f64,
    /// Longest path in a step, cells.
    pub cfl: f64,
}

impl Default for StepBounds {
    fn default() -> Self {
        let Numerics { capillary_step, cfl, .. } = Numerics::default();
        Self { capillary_step, cfl }
    }
}

impl From<StepBounds> for Numerics {
    fn from(StepBounds { capillary_step, cfl }: StepBounds) -> Self {
        Self { capillary_step, cfl, ..Self::default() }
    }
}

/// A shift by irrational fractions of a cell, which avoids symmetries of the grid.
pub fn grid_offset<const D: usize>(dx: f64) -> Vector<D> {
    Vector::from_fn(|a, _| dx * [0.141_421_356, 0.273_205_081, 0.367_879_441][a])
}

/// A vector with a component along the last axis, and the same one along each of the others.
pub fn across_and_up<const D: usize>(across: f64, up: f64) -> Vector<D> {
    Vector::from_fn(|a, _| if a + 1 == D { up } else { across })
}

/// A vector along the last axis.
pub fn up<const D: usize>(height: f64) -> Vector<D> {
    across_and_up(0.0, height)
}

/// A box along the axes.
pub fn block<const D: usize>(center: Vector<D>, half_size: Vector<D>) -> Shape<D> {
    Shape::Box { center, half_size, rotation: Matrix::identity() }
}

/// A fixed solid on which the liquid has a contact angle, degrees.
pub fn wetted<const D: usize>(shape: Shape<D>, angle: f64) -> Solid<D> {
    let mut solid = Solid::new(shape, SolidKind::Fixed, 1.0);
    solid.young_cosine = angle.to_radians().cos();
    solid
}

/// A simulation with one body of liquid at rest, given by its signed distance.
pub fn at_rest<const D: usize>(
    model: Model<D>,
    signed_distance: &(dyn Fn(&Vector<D>) -> f64 + Sync),
) -> Simulation<D>
where
    Simulation<D>: Compiled<D>,
{
    in_flight(model, signed_distance, Vector::zeros())
}

/// A simulation with one body of liquid that moves with a velocity.
pub fn in_flight<const D: usize>(
    model: Model<D>,
    signed_distance: &(dyn Fn(&Vector<D>) -> f64 + Sync),
    velocity: Vector<D>,
) -> Simulation<D>
where
    Simulation<D>: Compiled<D>,
{
    started(model, &[LiquidRegion { signed_distance, velocity }])
}

/// A simulation with bodies of liquid of given shapes and velocities.
pub fn with_bodies<const D: usize>(model: Model<D>, bodies: &[(Shape<D>, Vector<D>)]) -> Simulation<D>
where
    Simulation<D>: Compiled<D>,
{
    let distances: Vec<_> =
        bodies.iter().map(|(shape, _)| |x: &Vector<D>| shape.signed_distance(x)).collect();
    let velocities = bodies.iter().map(|(_, velocity)| *velocity);
    let regions: Vec<LiquidRegion<'_, D>> = distances
        .iter()
        .zip(velocities)
        .map(|(signed_distance, velocity)| LiquidRegion { signed_distance, velocity })
        .collect();
    started(model, &regions)
}

/// Steps to a time; `each` is called after every step.
///
/// # Errors
/// The step's.
pub fn run_to<const D: usize>(
    sim: &mut Simulation<D>,
    end: f64,
    mut each: impl FnMut(&Simulation<D>, &StepReport<D>),
) -> Result<(), StepError> {
    while sim.state.time < end * (1.0 - 1e-12) {
        let report = sim.step(end - sim.state.time, &mut |_| ())?;
        each(sim, &report);
    }
    Ok(())
}

/// An oscillating or resting drop in free space.
#[derive(Clone, Copy, Debug)]
pub struct DropRun {
    /// Cells per radius.
    pub cells: usize,
    /// Mode of the perturbation.
    pub mode: u32,
    /// Relative amplitude of the perturbation.
    pub amplitude: f64,
    /// Kinematic viscosity.
    pub viscosity: f64,
    /// Step length as a multiple of the explicit capillary limit.
    pub step: f64,
    /// Duration.
    pub time: f64,
}

/// Recorded history of a run.
#[derive(Clone, Debug, Default)]
pub struct DropHistory {
    /// Times, from zero.
    pub times: Vec<f64>,
    /// Relative amplitude of the mode.
    pub amplitudes: Vec<f64>,
    /// Largest deviation of the surface from radius, shift and mode, over the radius.
    pub deviations: Vec<f64>,
    /// Largest speed.
    pub speeds: Vec<f64>,
    /// Pressure at the centre of mass.
    pub pressures: Vec<f64>,
    /// Largest relative error of the volume.
    pub volume_error: f64,
    /// Solver iterations.
    pub iterations: usize,
}

/// Rayleigh's frequency of a mode of an inviscid drop (Lord Rayleigh 1879), rad/s.
pub fn rayleigh_frequency<const D: usize>(mode: u32) -> f64 {
    let n = f64::from(mode);
    let number = if D == 2 { n * (n * n - 1.0) } else { n * (n - 1.0) * (n + 2.0) };
    (number * TENSION / RADIUS.powi(3)).sqrt()
}

/// Runs a drop in the middle of a box 3.4 radii wide, off the grid points, released at rest.
///
/// # Errors
/// The step's.
pub fn run_drop<const D: usize>(run: &DropRun) -> Result<DropHistory, StepError>
where
    Simulation<D>: Compiled<D>,
{
    let dx = RADIUS / run.cells as f64;
    let cells = (3.4 * run.cells as f64).ceil() as usize;
    let mut model = model(Grid::<D>::new([cells; D], dx), [[Wall::Open; 2]; D]);
    model.kinematic_viscosity = run.viscosity;
    model.numerics.tolerance = 1e-8;
    model.numerics.fixed_step = Some(run.step * model.capillary_dt_limit());
    let center = model.grid.domain_upper() * 0.5 + grid_offset(dx);
    let shape = Shape::PerturbedBall { center, radius: RADIUS, mode: run.mode, amplitude: run.amplitude };
    let mut sim = with_bodies(model, &[(shape, Vector::zeros())]);
    let mut history = DropHistory::default();
    history.record(&sim, run.mode);
    run_to(&mut sim, run.time, |sim, report| {
        history.record(sim, run.mode);
        history.speeds.push(report.diagnostics.max_speed);
        history.volume_error = history.volume_error.max(report.diagnostics.volume_error.abs());
        history.iterations += report.iterations();
        let center = sim.state.components.first().map_or(center, |d| d.centroid);
        let cell = center.map(|x| (x / dx) as usize);
        let index = sim.model.grid.lattice().index(std::array::from_fn(|a| cell[a]));
        history.pressures.push(sim.state.pressure(sim.model.density, index));
    })?;
    Ok(history)
}

impl DropHistory {
    fn record<const D: usize>(&mut self, sim: &Simulation<D>, mode: u32) {
        let fit = roundness(sim, mode).unwrap_or(Roundness { radius: 0.0, amplitude: 0.0, deviation: 0.0 });
        self.times.push(sim.state.time);
        self.amplitudes.push(fit.amplitude / RADIUS);
        self.deviations.push(fit.deviation / RADIUS);
    }
}

/// The shape of the only drop of a simulation.
pub fn roundness<const D: usize>(sim: &Simulation<D>, mode: u32) -> Option<Roundness> {
    let center = sim.state.components.first()?.centroid;
    fit_mode(&surface_points(&sim.model, &sim.state.phi), &center, mode)
}
