//! The simulation of a scene in two or three dimensions, for callers that do not choose the dimension.

use super::setup::{AnySetup, names_and_mesh_edges};
use crate::error::SceneError;
use crate::file::Scene;
use crate::job::padded_to_3d;
use crate::output::frame::{Frame, FrameExtractor, FrameParts, NotFinite};
use meniscus_numerics::Vector;
use meniscus_sim::{Diagnostics, PhaseEnd, Simulation, StepError, StepReport};

/// Relative difference of two times that counts as rounding: that of a sum of 10⁴ steps, each with the error 1e-16.
const TIME_TOLERANCE: f64 = 1e-12;

/// A simulation in two or three dimensions. Vectors of results have three entries; in 2D the third one is 0.
pub enum AnySimulation {
    /// Two dimensions.
    D2(Box<SceneSimulation<2>>),
    /// Three dimensions.
    D3(Box<SceneSimulation<3>>),
}

/// A simulation, and what frames of it are extracted with.
pub struct SceneSimulation<const D: usize> {
    /// The simulation.
    pub simulation: Simulation<D>,
    /// Extracts its frames.
    pub extractor: FrameExtractor<D>,
}

/// Values of a field on the points of a grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridValues<'a> {
    /// The values; the first axis varies fastest.
    pub values: &'a [f64],
    /// Number of points along each axis; 1 along the third one in 2D.
    pub extent: [usize; 3],
    /// Position of the first point, m.
    pub first: [f64; 3],
    /// Distance between neighbours, m.
    pub dx: f64,
}

/// Numbers of cells and vertices of a simulation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SimulationSize {
    /// Cells in the liquid.
    pub liquid_cells: usize,
    /// Cells of the narrow band.
    pub band_cells: usize,
    /// Those of them next to the interface.
    pub interface_cells: usize,
    /// Vertices of the deformable solids.
    pub vertices: usize,
    /// Their simplices.
    pub simplices: usize,
}

/// An expression with the [`SceneSimulation`] of either dimension.
macro_rules! with_either {
    ($any:expr, $scene:ident => $value:expr) => {
        match $any {
            AnySimulation::D2($scene) => $value,
            AnySimulation::D3($scene) => $value,
        }
    };
}

impl AnySimulation {
    /// The simulation of a scene in its initial state.
    ///
    /// # Errors
    /// [`SceneError`] for a shape that cannot be made.
    pub fn of(scene: &Scene) -> Result<Self, SceneError> {
        let (solids, interval) = (names_and_mesh_edges(scene), scene.output.frame_interval());
        Ok(match AnySetup::of(scene)? {
            AnySetup::D2(setup) => {
                Self::D2(Box::new(SceneSimulation::new(setup.simulation(), &solids, interval)))
            }
            AnySetup::D3(setup) => {
                Self::D3(Box::new(SceneSimulation::new(setup.simulation(), &solids, interval)))
            }
        })
    }

    /// 2 or 3.
    pub fn dimension(&self) -> usize {
        match self {
            Self::D2(_) => 2,
            Self::D3(_) => 3,
        }
    }

    /// Time, s.
    pub fn time(&self) -> f64 {
        with_either!(self, scene => scene.simulation.state.time)
    }

    /// Number of steps done.
    pub fn steps(&self) -> u64 {
        with_either!(self, scene => scene.simulation.state.step)
    }

    /// Advances by one time step of at most `max_dt` s; see [`Simulation::step`].
    ///
    /// # Errors
    /// [`StepError`], which tells how the state is then.
    pub fn step(&mut self, max_dt: f64) -> Result<StepReport<3>, StepError> {
        self.step_by_phases(max_dt, &mut |_| ())
    }

    /// The same; `phase_end` is called at the end of each phase of the step.
    ///
    /// # Errors
    /// [`StepError`], which tells how the state is then.
    pub fn step_by_phases(
        &mut self,
        max_dt: f64,
        phase_end: PhaseEnd<'_>,
    ) -> Result<StepReport<3>, StepError> {
        with_either!(self, scene => Ok(report(scene.simulation.step(max_dt, phase_end)?)))
    }

    /// Numbers of cells and vertices now.
    pub fn size(&self) -> SimulationSize {
        with_either!(self, scene => scene.size())
    }

    /// Steps until `end`, s.
    ///
    /// # Errors
    /// [`StepError`], which tells how the state is then.
    pub fn run_to(&mut self, end: f64) -> Result<(), StepError> {
        while self.time() < end * (1.0 - TIME_TOLERANCE) {
            self.step(end - self.time())?;
        }
        Ok(())
    }

    /// Volume, momentum and energy of the current state.
    pub fn diagnostics(&self) -> Diagnostics<3> {
        with_either!(self, scene => diagnostics(scene.simulation.diagnostics()))
    }

    /// The frame of the current state: surfaces and contact line.
    ///
    /// # Errors
    /// [`NotFinite`] if a field or the liquid's surface is not finite.
    pub fn frame(&self) -> Result<Frame, NotFinite> {
        with_either!(self, scene => {
            let line = scene.extractor.contact_line(&scene.simulation);
            scene.extractor.frame(&scene.simulation, &line, FrameParts::default())
        })
    }

    /// Signed distance to the liquid's surface at the cells' centres, m, negative in the liquid; a distance within five cells of the
    /// surface only.
    pub fn phi(&self) -> GridValues<'_> {
        with_either!(self, scene => scene.phi())
    }

    /// Velocity component along an axis at the faces normal to it, m/s; `None` if there is no such axis. It is valid in the liquid
    /// and a few cells around it, and half a step ahead of the positions.
    pub fn velocity(&self, axis: usize) -> Option<GridValues<'_>> {
        with_either!(self, scene => scene.velocity(axis))
    }
}

impl<const D: usize> SceneSimulation<D> {
    fn new(simulation: Simulation<D>, solids: &[(String, f64)], interval: f64) -> Self {
        Self { extractor: FrameExtractor::new(&simulation.model, solids, interval), simulation }
    }

    fn size(&self) -> SimulationSize {
        let Self { simulation, .. } = self;
        let solids = simulation.model.solids.iter();
        let meshes: Vec<_> = solids.filter_map(|s| Some(s.elastic()?.rest_mesh())).collect();
        SimulationSize {
            liquid_cells: simulation.liquid_cells().cell_count(),
            band_cells: simulation.band().cells.len(),
            interface_cells: simulation.band().first_layers(1).len(),
            vertices: meshes.iter().map(|m| m.positions.len()).sum(),
            simplices: meshes.iter().map(|m| m.simplices.len()).sum(),
        }
    }

    fn phi(&self) -> GridValues<'_> {
        let phi = &self.simulation.state.phi;
        let first = padded_to_3d(&phi.grid.center([0; D]));
        GridValues {
            values: &phi.data,
            extent: padded_extent(phi.grid.lattice().extent),
            first,
            dx: phi.grid.dx,
        }
    }

    fn velocity(&self, axis: usize) -> Option<GridValues<'_>> {
        let velocity = &self.simulation.state.velocity;
        let grid = velocity.grid;
        let values = velocity.axes.get(axis)?;
        let first = padded_to_3d(&grid.face_center(axis, [0; D]));
        Some(GridValues { values, extent: padded_extent(grid.face_lattice(axis).extent), first, dx: grid.dx })
    }
}

fn padded_extent<const D: usize>(extent: [usize; D]) -> [usize; 3] {
    std::array::from_fn(|a| extent.get(a).copied().unwrap_or(1))
}

/// A report with vectors of three entries.
fn report<const D: usize>(report: StepReport<D>) -> StepReport<3> {
    StepReport {
        dt: report.dt,
        cfl: report.cfl,
        solves: report.solves,
        newton_iterations: report.newton_iterations,
        repairs: report.repairs,
        diagnostics: diagnostics(report.diagnostics),
    }
}

/// Diagnostics with vectors of three entries.
fn diagnostics<const D: usize>(of: Diagnostics<D>) -> Diagnostics<3> {
    Diagnostics {
        volume: of.volume,
        target_volume: of.target_volume,
        volume_error: of.volume_error,
        centroid: Vector::from(padded_to_3d(&of.centroid)),
        momentum: Vector::from(padded_to_3d(&of.momentum)),
        angular_momentum: of.angular_momentum,
        kinetic_energy: of.kinetic_energy,
        surface_energy: of.surface_energy,
        elastic_energy: of.elastic_energy,
        least_element: of.least_element,
        potential_energy: of.potential_energy,
        max_speed: of.max_speed,
        divergence_max: of.divergence_max,
    }
}
