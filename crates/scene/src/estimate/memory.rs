//! Estimated memory of a run, and the memory of this machine.

use super::scales::liquid_volume;
use crate::build::{AnySetup, Setup};
use crate::error::SceneError;
use crate::file::Scene;
use meniscus_elastic::Elastic;

/// Bytes per cell of the domain: 25 fields of 8 bytes.
const BYTES_PER_CELL: f64 = 200.0;
/// Further bytes per liquid cell: 30 fields of 8 bytes.
const BYTES_PER_LIQUID_CELL: f64 = 240.0;
/// Bytes per vertex of a deformable solid without its linear solver, measured.
const BYTES_PER_VERTEX: f64 = 8e3;
/// Peak memory of a factorisation over that of the factors. Compact bodies have the largest fronts: `fig02-soft-cow`, with factors of 736
/// MB, takes at most 2.1 GB, 0.5 GB of it for the grid and the vertices.
const FACTORISATION_OVERHEAD: f64 = 2.2;

/// Memory of the grid and the liquid, bytes, from the numbers of all cells and of liquid cells.
pub fn liquid_memory(cells: f64, liquid_cells: f64) -> f64 {
    BYTES_PER_CELL * cells + BYTES_PER_LIQUID_CELL * liquid_cells
}

/// Memory of a deformable solid, bytes.
pub fn solid_memory<const D: usize>(body: &Elastic<D>) -> f64 {
    FACTORISATION_OVERHEAD * solver_bytes(body) + BYTES_PER_VERTEX * body.rest_mesh().positions.len() as f64
}

/// Memory of the solver of a solid's linear systems, bytes.
pub fn solver_bytes<const D: usize>(body: &Elastic<D>) -> f64 {
    8.0 * body.solver_entries() as f64
}

/// Memory of this machine or the limit of its container, bytes; none if it is unknown.
pub fn machine_memory() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find(|l| l.starts_with("MemTotal:"))?;
    let total = line.split_whitespace().nth(1)?.parse::<u64>().ok()?.checked_mul(1024)?;
    let allowed = std::fs::read_to_string("/sys/fs/cgroup/memory.max").ok();
    let allowed = allowed.and_then(|t| t.trim().parse::<u64>().ok());
    Some(allowed.map_or(total, |a| a.min(total)))
}

/// Refuses a scene whose grid and liquid need more than `limit` bytes (see [`machine_memory`]).
///
/// # Errors
/// [`SceneError`] that points at the resolution.
pub fn check_liquid_memory(scene: &Scene, limit: Option<u64>) -> Result<(), SceneError> {
    let Some(limit) = limit else { return Ok(()) };
    let limit = limit as f64;
    let cells = scene.grid_cells();
    let least = liquid_memory(cells, 0.0);
    let need = if least > limit { least } else { grid_and_liquid_memory(scene) };
    if need <= limit {
        return Ok(());
    }
    let longest = scene.domain.cells.iter().copied().max().unwrap_or(1) as f64;
    let fit = (longest * (0.9 * limit / need).powf(1.0 / scene.domain.dimension as f64)).floor();
    let error = insufficient_memory(need, limit).with_help(format!(
        "reduce the resolution: about `resolution = {fit}` is the most that fits into this memory"
    ));
    let path = if scene.source.has("domain.dx") { "domain.dx" } else { "domain.resolution" };
    Err(scene.source.at_value(error, path))
}

/// Refuses a scene that needs more than `limit` bytes (see [`machine_memory`]) with its deformable solids.
///
/// # Errors
/// [`SceneError`] that points at the solid with the largest need.
pub fn check_solid_memory(scene: &Scene, setup: &AnySetup, limit: Option<u64>) -> Result<(), SceneError> {
    let Some(limit) = limit else { return Ok(()) };
    let soft = match setup {
        AnySetup::D2(setup) => memory_by_solid(setup),
        AnySetup::D3(setup) => memory_by_solid(setup),
    };
    let Some(most) = soft.iter().max_by(|a, b| a.1.total_cmp(&b.1)) else { return Ok(()) };
    let need = grid_and_liquid_memory(scene) + soft.iter().map(|s| s.1).sum::<f64>();
    if need <= limit as f64 {
        return Ok(());
    }
    let (number, bytes, vertices) = most;
    let name = scene.solids.get(*number).map_or("", |s| s.name.as_str());
    let error = insufficient_memory(need, limit as f64).with_help(format!(
        "{} of it are for the solid `{name}` with {vertices} vertices: use a coarser mesh (`mesh.edge`) or a coarser grid",
        format_bytes(*bytes)
    ));
    Err(scene.source.at_value(error, &scene.source.first_inside(&format!("solid.{number}.shape"))))
}

/// For each deformable solid its number, its memory in bytes, and its number of vertices.
fn memory_by_solid<const D: usize>(setup: &Setup<D>) -> Vec<(usize, f64, usize)> {
    let solids = setup.model.solids.iter().enumerate();
    solids
        .filter_map(|(k, s)| s.elastic().map(|e| (k, solid_memory(e), e.rest_mesh().positions.len())))
        .collect()
}

fn grid_and_liquid_memory(scene: &Scene) -> f64 {
    let cells = scene.grid_cells();
    let cell = scene.domain.dx.powi(scene.domain.dimension as i32);
    liquid_memory(cells, liquid_volume(scene).map_or(cells, |v| v / cell))
}

fn insufficient_memory(need: f64, limit: f64) -> SceneError {
    SceneError::new(format!(
        "the scene needs about {} of memory, this machine has {}",
        format_bytes(need),
        format_bytes(limit)
    ))
}

/// Formats a number of bytes.
pub(crate) fn format_bytes(bytes: f64) -> String {
    match bytes {
        n if n < 1e6 => format!("{:.0} kB", n / 1e3),
        n if n < 1e9 => format!("{:.0} MB", n / 1e6),
        n => format!("{:.1} GB", n / 1e9),
    }
}
