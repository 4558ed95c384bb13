//! `summary.json`: the state of a run or its end.

use super::atomic_file::{self, FileError};
use crate::estimate::parameters::Parameter;
use crate::job::{Job, RunStatistics, ThinLiquidStatistics, padded_to_3d};
use meniscus_numerics::Vector;
use meniscus_numerics::fit::RigidTransform;
use meniscus_sim::{Component, ContactLine, Quantity, Repairs, Simulation, SolidView};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;

/// The `exit_reason` of a complete run.
pub const FINISHED: &str = "finished";
/// Name, among the repairs, of the sum of all iterations that did not converge.
pub const UNCONVERGED: &str = "unconverged";

/// The content of `summary.json`; SI units.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Name of the scene.
    pub scene: String,
    /// The scene's `description`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub description: Option<String>,
    /// The parameters of the scene as numbers.
    #[serde(default)]
    pub parameters: Vec<Parameter>,
    /// Version of Meniscus.
    pub version: String,
    /// Why the run ended: `finished`, `stopped: …`, `failed: …`; `running` until then.
    pub exit_reason: String,
    /// 2 or 3.
    pub dimension: usize,
    /// Cells along the longest side of the domain.
    pub resolution: usize,
    /// Cells of the domain along each axis.
    pub cells: Vec<usize>,
    /// Cell size, m.
    pub dx: f64,
    /// Lengths of the domain, m.
    pub domain: Vec<f64>,
    /// Number of threads.
    pub threads: usize,
    /// Number of steps.
    pub steps: u64,
    /// Number of frames.
    pub frames: u64,
    /// Time between frames, s.
    pub frame_interval: f64,
    /// Simulated time, s.
    pub simulated_seconds: f64,
    /// Wall time, s.
    pub wall_seconds: f64,
    /// Worst relative volume error of the run, signed.
    pub volume_error: f64,
    /// Worst relative momentum error of the run: momentum that does not come from gravity, over that of all liquid at its largest root
    /// mean square speed. Walls that the liquid touches contribute. Null where solids are anchored or have prescribed motion.
    pub momentum_error: Option<f64>,
    /// Why there is no momentum error.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub momentum_error_reason: Option<String>,
    /// Largest divergence in a liquid cell of the run, 1/s. Multiplied by the time step it is the relative volume imbalance of a single
    /// cell at a surface or solid; the volume of drops is conserved separately.
    pub max_divergence: f64,
    /// Largest speed of the run, m/s.
    pub max_speed: f64,
    /// Smallest volume (2D: area) of an element of a deformable solid, over its rest volume; not positive if one was inverted. Null
    /// without such solids.
    #[serde(default)]
    pub least_element: Option<f64>,
    /// Deepest overlap of a deformable solid with a side, another solid or itself in any frame, m. Null without such solids.
    #[serde(default)]
    pub deepest_overlap: Option<f64>,
    /// Liquid thinner than two cells, which the grid does not resolve.
    #[serde(default)]
    pub thin_liquid: ThinLiquidStatistics,
    /// Volume that was lost as the last of the liquid vanished, m³ (2D: m²).
    pub lost_volume: f64,
    /// Volume that left through open sides, m³ (2D: m²).
    #[serde(default)]
    pub outflow_volume: f64,
    /// Steps repeated with half the length.
    pub redone: u64,
    /// The repairs of the run by name: counts, and sums in SI units ([`meniscus_sim::Repairs`]); `unconverged` counts all iterations that
    /// ended before they converged.
    #[serde(default)]
    pub repairs: BTreeMap<String, f64>,
    /// Volume of the liquid at the start, m³ (2D: m²); it scales repaired volumes.
    #[serde(default)]
    pub start_volume: f64,
    /// Momentum of all the liquid at its largest root mean square speed of the run, kg m/s (2D: kg/s); it scales repaired momenta.
    #[serde(default)]
    pub momentum_scale: f64,
    /// Seconds per phase of a step.
    pub phases: BTreeMap<String, f64>,
    /// Iterations per solver.
    pub solves: BTreeMap<String, SolveStatistics>,
    /// Peak memory, bytes (0 where the system does not report it).
    pub peak_memory_bytes: u64,
    /// The connected components of the liquid.
    pub drops: Vec<ComponentSummary>,
    /// The solids.
    pub solids: Vec<SolidSummary>,
    /// Mean contact angle on the closed sides, degrees; null without a line on them, and on mirrors.
    #[serde(default)]
    pub wall_contact_angle: Option<f64>,
    /// The `[expect]` section of the scene, evaluated; empty before the end.
    #[serde(default)]
    pub expect: Vec<Verdict>,
}

/// An expectation of a scene and its result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// The quantity.
    pub quantity: String,
    /// The bound, as text.
    pub bar: String,
    /// The measured value; none if it could not be measured.
    pub value: Option<f64>,
    /// Unit of the value, empty if it has none.
    pub unit: String,
    /// Whether the bound is met.
    pub pass: bool,
}

/// Number of solves of a solver and their iterations.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SolveStatistics {
    /// Number of solves.
    pub count: u64,
    /// Mean number of iterations.
    pub mean: f64,
    /// Largest number of iterations.
    pub max: u64,
}

/// A connected component of the liquid at the end.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ComponentSummary {
    /// Volume, m³ (2D: m²).
    pub volume: f64,
    /// Volume that it must conserve, m³ (2D: m²).
    pub target_volume: f64,
    /// Centre of mass, m.
    pub centroid: Vec<f64>,
    /// Mean velocity, m/s.
    pub velocity: Vec<f64>,
    /// Lower corner of its bounding box, m.
    pub lower: Vec<f64>,
    /// Upper corner of its bounding box, m.
    pub upper: Vec<f64>,
}

/// A solid at the end.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SolidSummary {
    /// Its name.
    pub name: String,
    /// Centre of mass, m.
    pub centroid: Vec<f64>,
    /// Its velocity, m/s.
    pub velocity: Vec<f64>,
    /// Lower corner of its bounding box, m; null where it is unbounded.
    pub lower: Vec<Option<f64>>,
    /// Upper corner of its bounding box, m; null where it is unbounded.
    pub upper: Vec<Option<f64>>,
    /// Force of the liquid, N (2D: N/m).
    pub net_force: Vec<f64>,
    /// The pressure part of it.
    pub pressure_force: Vec<f64>,
    /// The part of surface tension, along the contact line.
    pub line_force: Vec<f64>,
    /// Mean contact angle, degrees; null without a contact line on it.
    #[serde(default)]
    pub contact_angle: Option<f64>,
    /// Contact force of the solids and sides on it, N (2D: N/m).
    #[serde(default)]
    pub contact_force: Vec<f64>,
    /// Wetted share of its surface.
    #[serde(default)]
    pub wetted: f64,
    /// Largest displacement from the rest shape, m, without rigid motion: that of the anchored parts where they move, or the best fit to
    /// the whole solid if none is anchored. Null for a rigid solid.
    #[serde(default)]
    pub deflection: Option<f64>,
}

impl SolidSummary {
    fn of<const D: usize>(name: &str, simulation: &Simulation<D>, number: usize, angle: Option<f64>) -> Self {
        let solid = simulation.solid(number);
        let now = solid.state;
        let list = |v: &Vector<D>| v.iter().copied().collect::<Vec<f64>>();
        let bounds = solid.bounds().map(|b| b.iter().map(|x| x.is_finite().then_some(*x)).collect());
        let [lower, upper] = bounds;
        Self {
            name: name.to_string(),
            centroid: list(&now.center_of_mass()),
            velocity: list(&now.velocity()),
            lower,
            upper,
            net_force: list(&(now.pressure_force + now.contact_line_force)),
            pressure_force: list(&now.pressure_force),
            line_force: list(&now.contact_line_force),
            contact_angle: angle,
            contact_force: match (solid.kind.is_free_rigid(), solid.elastic()) {
                (true, _) => list(&(now.contact_acceleration * solid.mass_properties.mass)),
                (_, Some(elastic)) => {
                    list(&(now.contact_acceleration * elastic.masses().iter().sum::<f64>()))
                }
                _ => list(&Vector::zeros()),
            },
            wetted: simulation.wetted_fraction(number),
            deflection: deflection(&solid),
        }
    }
}

/// Deflection of a deformable solid, m.
pub fn deflection<const D: usize>(solid: &SolidView<'_, D>) -> Option<f64> {
    let (elastic, body) = (solid.elastic()?, solid.state.as_deformable()?);
    let points =
        |all: &[Vector<D>]| all.iter().map(|x| Vector::<3>::from(padded_to_3d(x))).collect::<Vec<_>>();
    let (start, end) = (points(&elastic.rest_mesh().positions), points(&body.vertices.positions));
    let motion = rigid_motion_of_anchors(elastic.anchored(), &start, &end);
    let bent = |x: &Vector<3>| motion.map_or(*x, |motion| motion.inverse_transformed(x));
    Some(start.iter().zip(&end).map(|(a, b)| (bent(b) - a).norm()).fold(0.0, f64::max))
}

/// The rigid motion of a solid: the best fit to that of its anchored parts, or of the whole solid if none is anchored; none if the
/// anchored parts are at rest.
fn rigid_motion_of_anchors(held: &[bool], start: &[Vector<3>], end: &[Vector<3>]) -> Option<RigidTransform> {
    if !held.contains(&true) {
        return Some(RigidTransform::fit(start, end));
    }
    let of = |all: &[Vector<3>]| -> Vec<Vector<3>> {
        all.iter().zip(held).filter(|(_, held)| **held).map(|(x, _)| *x).collect()
    };
    let (start, end) = (of(start), of(end));
    (start != end).then(|| RigidTransform::fit(&start, &end))
}

impl Summary {
    /// The summary of a simulation in its present state.
    pub fn of<const D: usize>(
        job: &Job,
        simulation: &Simulation<D>,
        line: &ContactLine<D>,
        tally: &RunStatistics,
        exit_reason: &str,
    ) -> Self {
        let (grid, state) = (simulation.model.grid, &simulation.state);
        let angle = |i: usize| line.angle_statistics(Some(i as u32)).map(|a| a.0);
        let solids = job.solids.iter().enumerate();
        let solids = solids.map(|(i, (name, _))| SolidSummary::of(name, simulation, i, angle(i))).collect();
        let constrained = simulation.model.solids.iter().any(|s| !s.is_unconstrained());
        let mean = tally.iterations as f64 / tally.solves.max(1) as f64;
        let solves = SolveStatistics { count: tally.solves, mean, max: tally.most_iterations };
        Self {
            scene: job.name.clone(),
            description: job.description.clone(),
            parameters: job.parameters.clone(),
            version: env!("CARGO_PKG_VERSION").to_string(),
            exit_reason: exit_reason.to_string(),
            dimension: D,
            resolution: grid.domain_cells().into_iter().max().unwrap_or(0),
            cells: grid.domain_cells().to_vec(),
            dx: grid.dx,
            domain: padded_to_3d(&grid.domain_upper())[..D].to_vec(),
            threads: rayon::current_num_threads(),
            steps: state.step,
            frames: tally.next_frame,
            frame_interval: job.frame_interval,
            simulated_seconds: state.time,
            wall_seconds: tally.wall_seconds,
            volume_error: tally.volume_error,
            momentum_error: (!constrained).then_some(tally.momentum_error),
            momentum_error_reason: constrained
                .then(|| "fixed, held or moved solids exchange momentum with their supports".to_string()),
            max_divergence: tally.max_divergence,
            max_speed: tally.max_speed,
            least_element: tally.least_element,
            deepest_overlap: tally.deepest_overlap,
            thin_liquid: tally.thin,
            lost_volume: state.lost_volume,
            outflow_volume: state.outflow_volume,
            redone: tally.repairs.redone,
            repairs: repairs_by_name(&tally.repairs),
            start_volume: tally.mass / simulation.model.density,
            momentum_scale: tally.momentum_scale(),
            phases: tally.phases.iter().cloned().collect(),
            solves: BTreeMap::from([("pressure".to_string(), solves)]),
            peak_memory_bytes: peak_memory().unwrap_or(0),
            drops: state.components.iter().map(ComponentSummary::of).collect(),
            solids,
            wall_contact_angle: simulation.model.wetting_wall_solid().and_then(angle),
            expect: Vec::new(),
        }
    }

    /// The repairs by name, scaled as their bounds are: volumes by the start volume, momenta by the momentum scale, angular momenta by
    /// that times the size of a cube of the start volume, lengths by the cell size.
    pub fn relative_repairs(&self) -> impl Iterator<Item = (&str, f64)> {
        let size = self.start_volume.powf(1.0 / self.dimension as f64);
        let scale = move |name: &str| match Repairs::ENTRIES.iter().find(|(known, _)| *known == name) {
            Some((_, Quantity::Volume)) => self.start_volume,
            Some((_, Quantity::Momentum)) => self.momentum_scale,
            Some((_, Quantity::AngularMomentum)) => self.momentum_scale * size,
            Some((_, Quantity::Length)) => self.dx,
            Some((_, Quantity::Count | Quantity::Ratio)) | None => 1.0,
        };
        let relative = move |name: &str, value: f64| if value == 0.0 { 0.0 } else { value / scale(name) };
        self.repairs.iter().map(move |(name, value)| (name.as_str(), relative(name, *value)))
    }

    /// Reads a file.
    ///
    /// # Errors
    /// [`FileError`], also for content that is not a summary.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        let fail = |source| FileError { action: "read", path: path.to_path_buf(), source };
        let text = std::fs::read_to_string(path).map_err(fail)?;
        serde_json::from_str(&text).map_err(|e| fail(e.into()))
    }

    /// Writes a file.
    ///
    /// # Errors
    /// [`FileError`].
    pub fn write(&self, path: &Path) -> Result<(), FileError> {
        atomic_file::write_atomically(path, |writer| {
            serde_json::to_writer_pretty(&mut *writer, self)?;
            writer.write_all(b"\n")
        })
    }
}

/// Repairs by name.
fn repairs_by_name(repairs: &Repairs) -> BTreeMap<String, f64> {
    let entries = Repairs::ENTRIES.iter().zip(repairs.values());
    let all = entries.map(|((name, _), value)| ((*name).to_string(), value));
    all.chain([(UNCONVERGED.to_string(), repairs.unconverged() as f64)]).collect()
}

impl ComponentSummary {
    fn of<const D: usize>(drop: &Component<D>) -> Self {
        let [centroid, velocity, lower, upper] =
            [drop.centroid, drop.velocity, drop.lower, drop.upper].map(|v| padded_to_3d(&v)[..D].to_vec());
        Self { volume: drop.volume, target_volume: drop.target_volume, centroid, velocity, lower, upper }
    }
}

/// Peak memory of this process, bytes. Known on Linux only.
pub fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.split_whitespace().next()?.parse::<u64>().ok().map(|kib| kib * 1024)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// The summary of a run without any step.
    pub(crate) fn empty() -> Summary {
        let text = "{\"scene\":\"\",\"version\":\"\",\"exit_reason\":\"running\",\"dimension\":2,\"resolution\":1,\
                    \"cells\":[],\"dx\":1,\"domain\":[],\"threads\":1,\"steps\":0,\"frames\":0,\"frame_interval\":1,\
                    \"simulated_seconds\":0,\"wall_seconds\":0,\"volume_error\":0,\"momentum_error\":0,\
                    \"max_divergence\":0,\"max_speed\":0,\"lost_volume\":0,\"redone\":0,\"phases\":{},\"solves\":{},\
                    \"peak_memory_bytes\":0,\"drops\":[],\"solids\":[]}";
        serde_json::from_str(text).unwrap()
    }

    #[test]
    fn held_parts_carry_a_solid_along() {
        let start = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 3.0]];
        let start = start.map(Vector::<3>::from);
        let held = [true, true, true, true, false];
        // All points move up by two; the free end also moves sideways by half.
        let mut end = start.map(|x| x + Vector::<3>::new(0.0, 0.0, 2.0));
        end[4][0] += 0.5;
        let undone = rigid_motion_of_anchors(&held, &start, &end)
            .map(|motion| motion.inverse_transformed(&end[4]) - start[4]);
        assert!(
            undone.is_some_and(|way| (way - Vector::<3>::new(0.5, 0.0, 0.0)).norm() < 1e-12),
            "{undone:?}"
        );
        assert!(rigid_motion_of_anchors(&held, &start, &start).is_none());
    }
}
