//! Wall time of a scene's steps by phase.

use crate::failure::{Failure, Result};
use meniscus_scene::build::AnySimulation;
use meniscus_scene::file::Scene;
use meniscus_scene::output::summary::peak_memory;
use serde::Serialize;
use std::time::Instant;

/// Warm-up steps before the measurement.
const WARM_UP_STEPS: usize = 2;

/// Time per phase of whole steps.
#[derive(Default, Serialize)]
pub struct StepBench {
    pub name: String,
    pub cells: usize,
    /// Liquid cells at the end.
    pub liquid_cells: usize,
    /// Cells of the narrow band at the end, and those of them next to the interface.
    pub band_cells: usize,
    pub surface_cells: usize,
    /// Number of dimensions.
    pub dimension: i32,
    /// Vertices of the deformable solids.
    pub vertices: usize,
    /// Their elements.
    pub elements: usize,
    /// Timed steps.
    pub steps: usize,
    /// Mean length of a step, s.
    pub time_step: f64,
    /// Wall time of a step, s.
    pub seconds_per_step: f64,
    /// Iterations of the pressure solve in a step.
    pub iterations_per_step: f64,
    /// Iterations of the solve for viscosity in a step.
    pub viscosity_iterations_per_step: f64,
    /// Seconds per step in each phase.
    pub phases: Vec<(String, f64)>,
    /// Peak memory of this process so far, bytes.
    pub peak_memory_bytes: Option<u64>,
}

/// Times `count` steps of a scene.
pub fn step(name: String, scene: &Scene, count: usize) -> Result<StepBench> {
    let mut simulation = AnySimulation::of(scene)?;
    let mut phases: Vec<(String, f64)> = Vec::new();
    let (mut seconds, mut iterations, mut viscosity_iterations, mut time) = (0.0, 0, 0, 0.0);
    for i in 0..WARM_UP_STEPS + count {
        let start = Instant::now();
        let mut last = start;
        let mut phase_end = |phase: &'static str| {
            let now = Instant::now();
            let spent = if i < WARM_UP_STEPS { 0.0 } else { (now - last).as_secs_f64() / count as f64 };
            match phases.iter_mut().find(|(known, _)| known == phase) {
                Some((_, sum)) => *sum += spent,
                None => phases.push((phase.to_string(), spent)),
            }
            last = now;
        };
        let report = simulation
            .step_by_phases(scene.output.frame_interval(), &mut phase_end)
            .map_err(|e| Failure::new(5, format!("{name}: {e}")))?;
        if i >= WARM_UP_STEPS {
            seconds += start.elapsed().as_secs_f64();
            iterations += report.iterations();
            viscosity_iterations += report.solves.viscosity.iterations;
            time += report.dt;
        }
    }
    let size = simulation.size();
    Ok(StepBench {
        name,
        cells: scene.domain.cells.iter().product(),
        liquid_cells: size.liquid_cells,
        band_cells: size.band_cells,
        surface_cells: size.interface_cells,
        dimension: simulation.dimension() as i32,
        vertices: size.vertices,
        elements: size.simplices,
        steps: count,
        time_step: time / count as f64,
        seconds_per_step: seconds / count as f64,
        iterations_per_step: iterations as f64 / count as f64,
        viscosity_iterations_per_step: viscosity_iterations as f64 / count as f64,
        phases,
        peak_memory_bytes: peak_memory(),
    })
}
