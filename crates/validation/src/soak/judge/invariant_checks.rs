//! Checks the invariants of a run after every step.

use super::invariants::{
    MAX_ENERGY_GROWTH, MAX_LIQUID_DEPTH_CELLS, MAX_MOMENTUM_ERROR, MAX_OVERLAP_CELLS, MAX_SPEED_RATIO,
    MAX_VOLUME_ERROR,
};
use crate::soak::{EnergyLaw, EnergyMonitor, Violation};
use meniscus_numerics::Vector;
use meniscus_scene::file::{Keyframe, Material, Scene};
use meniscus_sim::{Diagnostics, Model, Simulation, SolidKind, SolidState, State, StepReport, overlaps};
use std::collections::VecDeque;
use std::f64::consts::PI;

/// Steps between checks that cost as much as a step: fields, overlaps, liquid within solids.
const CHECK_INTERVAL_STEPS: u64 = 4;
/// Steps over which the energy is averaged for the comparison with its minimum.
const AVERAGING_STEPS: usize = 8;
/// Distance to a side, in cells, within which something may touch it.
const SIDE_CONTACT_CELLS: f64 = 3.0;

/// Initial quantities and running checks of a run.
pub struct InvariantChecks<const D: usize> {
    energy: f64,
    /// Largest kind of energy at the start, J.
    scale: f64,
    /// The energies after the last [`AVERAGING_STEPS`] steps, J, and the smallest mean over as many steps so far.
    recent_energies: VecDeque<f64>,
    least_energy: f64,
    /// Monitor of the energy of every step.
    steps: EnergyMonitor<D>,
    volume: f64,
    momentum: Vector<D>,
    mass: f64,
    largest_kinetic: f64,
    overlap: f64,
    /// The largest physical speed, m/s.
    speed: f64,
    /// Whether there is no external work.
    is_isolated: bool,
    /// Whether no solid has prescribed motion, so that overlaps can be resolved.
    has_no_prescribed_motion: bool,
    /// Whether nothing has touched a side so far, and no solid is anchored or has prescribed motion.
    conserves_momentum: bool,
}

impl<const D: usize> InvariantChecks<D> {
    /// The checks of a simulation at its start.
    pub fn at_start(simulation: &Simulation<D>, scene: &Scene) -> Self {
        let (model, ledger) = (&simulation.model, simulation.diagnostics());
        let prescribed = model.solids.iter().any(|s| matches!(s.kind, SolidKind::Prescribed(_)));
        let moved = scene.solids.iter().any(|s| !s.moved.is_empty());
        let lines = scene.contact_line.enabled || model.solids.is_empty();
        let scale = energy_scale(model, &ledger);
        let steps = EnergyMonitor::new(model, scale);
        let barriers = steps.barrier_energy(model, &simulation.state);
        let energy = potential_and_stored(&ledger) + ledger.kinetic_energy + barriers;
        let unanchored = model.solids.iter().all(|s| s.is_unconstrained());
        Self {
            energy,
            scale,
            recent_energies: VecDeque::new(),
            least_energy: f64::INFINITY,
            steps,
            volume: ledger.volume,
            momentum: momentum(model, &simulation.state.solids, &ledger),
            mass: mass(model, &ledger),
            largest_kinetic: ledger.kinetic_energy,
            overlap: deepest_overlap(simulation),
            speed: max_physical_speed(simulation, scene, &ledger),
            is_isolated: !prescribed && !moved && lines,
            has_no_prescribed_motion: !prescribed && !moved,
            conserves_momentum: unanchored && lines,
        }
    }

    /// The scale of the energy, J.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// The energy law of the run; none with external work.
    pub fn energy_law(&self) -> Option<&EnergyLaw> {
        self.is_isolated.then(|| self.steps.law())
    }

    /// The violations of the step that led to this state.
    pub fn check(&mut self, simulation: &Simulation<D>, report: &StepReport<D>) -> Vec<Violation> {
        let (model, state, ledger) = (&simulation.model, &simulation.state, &report.diagnostics);
        let mut found = StepViolations { step: state.step, time: state.time, all: Vec::new() };
        let not_finite = count_not_finite(ledger) as f64;
        found.at_most("not-finite", not_finite, 0.0, "sums over the liquid that are not finite");
        self.check_energy(&mut found, simulation, ledger);
        self.check_momentum(&mut found, simulation, ledger);
        self.check_volume(&mut found, state, report);
        found.at_most("speed", ledger.max_speed, MAX_SPEED_RATIO * self.speed, "m/s");
        let rigid = model.solids.iter().zip(&state.solids).filter(|(s, _)| s.kind.is_free_rigid());
        let fastest = rigid.map(|(s, now)| s.max_speed(now)).fold(0.0, f64::max);
        found.at_most("solid-speed", fastest, MAX_SPEED_RATIO * self.speed, "m/s");
        if let Some(least) = ledger.least_element.filter(|least| *least <= 0.0) {
            found.add("inverted", least, 0.0, "ratio of an element's volume to that at rest");
        }
        if state.step.is_multiple_of(CHECK_INTERVAL_STEPS) {
            self.check_fields_and_overlaps(&mut found, simulation);
        }
        found.all
    }

    /// Volume shifted, leaked, misplaced and lost, over that at the start.
    fn check_volume(&self, found: &mut StepViolations, state: &State<D>, report: &StepReport<D>) {
        let (ledger, repairs) = (&report.diagnostics, &report.repairs);
        let mut check = |kind: &str, share: f64, words: &str| {
            found.at_most(kind, share, MAX_VOLUME_ERROR, words);
        };
        check("volume-before", repairs.volume_shift / self.volume, "share of the volume shifted in a step");
        let leaked = repairs.leaked_volume / self.volume;
        check("leak", leaked, "share of the volume leaked through a solid in a step");
        let misplaced = ledger.volume_error.abs() * ledger.target_volume / self.volume;
        check("volume", misplaced, "share of the volume misplaced");
        check("volume", state.lost_volume / self.volume, "share of the volume lost");
    }

    /// Checks that cost as much as a step: fields, overlaps, liquid within solids.
    fn check_fields_and_overlaps(&self, found: &mut StepViolations, simulation: &Simulation<D>) {
        let (model, state) = (&simulation.model, &simulation.state);
        let dx = model.grid.dx;
        let fields = state.velocity.axes.iter().chain([&state.phi.data]).flatten();
        let not_finite = fields.filter(|v| !v.is_finite()).count() as f64;
        found.at_most("not-finite", not_finite, 0.0, "values of fields that are not finite");
        if self.has_no_prescribed_motion {
            let allowed = (MAX_OVERLAP_CELLS * dx).max(self.overlap + MAX_OVERLAP_CELLS * dx);
            found.at_most("overlap", deepest_overlap(simulation), allowed, "m");
        }
        found.at_most("within-solid", deepest_liquid(simulation), MAX_LIQUID_DEPTH_CELLS * dx, "m");
    }

    /// The energy is taken at the time of the velocities ([`EnergyMonitor`]), where it is conserved for solids; at the positions the
    /// elastic energy of an unresolved vibration is too large. Steps do not report the work of prescribed motion, so the check is then
    /// skipped. Energy that left through open sides counts.
    ///
    /// Steps of many capillary limits conserve a modified energy, about which the energy oscillates by `(ω h)²` of that of the fastest
    /// waves. So the mean over some steps must not rise again.
    fn check_energy(
        &mut self,
        found: &mut StepViolations,
        simulation: &Simulation<D>,
        ledger: &Diagnostics<D>,
    ) {
        let energy = if self.is_isolated { self.steps.record(simulation, ledger) } else { None };
        let Some(energy) = energy else { return };
        found.at_most(
            "energy",
            (energy - self.energy) / self.scale,
            MAX_ENERGY_GROWTH,
            "energy above its initial value, over its scale",
        );
        self.recent_energies.push_back(energy);
        if self.recent_energies.len() > AVERAGING_STEPS {
            self.recent_energies.pop_front();
            let mean = self.recent_energies.iter().sum::<f64>() / AVERAGING_STEPS as f64;
            self.least_energy = self.least_energy.min(mean);
            let risen = (mean - self.least_energy) / self.scale;
            found.at_most(
                "energy-again",
                risen,
                MAX_ENERGY_GROWTH,
                "mean energy above its minimum, over its scale",
            );
        }
    }

    /// $|P - P_0 - M g t| / \sqrt{2 M E_{max}}$ at the time of the velocity.
    fn check_momentum(
        &mut self,
        found: &mut StepViolations,
        simulation: &Simulation<D>,
        ledger: &Diagnostics<D>,
    ) {
        let (model, state) = (&simulation.model, &simulation.state);
        self.largest_kinetic = self.largest_kinetic.max(ledger.kinetic_energy);
        self.conserves_momentum &= !touches_a_side(simulation);
        let scale = (2.0 * self.largest_kinetic * self.mass).sqrt();
        if !self.conserves_momentum || scale == 0.0 {
            return;
        }
        let given = model.gravity * (self.mass * (state.time + state.velocity_lead));
        let off = (momentum(model, &state.solids, ledger) - self.momentum - given).norm();
        found.at_most("momentum", off / scale, MAX_MOMENTUM_ERROR, "share of the largest momentum");
    }
}

/// Violations of a step.
struct StepViolations {
    step: u64,
    time: f64,
    all: Vec<Violation>,
}

impl StepViolations {
    /// Adds a violation if a value exceeds its bound or is NaN.
    fn at_most(&mut self, kind: &str, value: f64, bar: f64, words: &str) {
        if value.is_nan() || value > bar {
            self.add(kind, value, bar, words);
        }
    }

    fn add(&mut self, kind: &str, value: f64, bar: f64, words: &str) {
        let (step, time) = (self.step, self.time);
        // JSON has no numbers that are not finite.
        let value = if value.is_nan() { f64::MAX } else { value.clamp(f64::MIN, f64::MAX) };
        self.all.push(Violation {
            value,
            worst: value,
            bar,
            ..Violation::described(kind, step, time, words.into())
        });
    }
}

fn count_not_finite<const D: usize>(ledger: &Diagnostics<D>) -> usize {
    let energies =
        [ledger.kinetic_energy, ledger.surface_energy, ledger.elastic_energy, ledger.potential_energy];
    let sums =
        energies.into_iter().chain([ledger.volume, ledger.max_speed]).chain(ledger.momentum.iter().copied());
    sums.filter(|v| !v.is_finite()).count()
}

fn potential_and_stored<const D: usize>(ledger: &Diagnostics<D>) -> f64 {
    ledger.surface_energy + ledger.elastic_energy + ledger.potential_energy
}

/// The largest kind of energy at the start, J: kinetic, potential over the lowest corner, surface. The surface energy is at least that of
/// one ball of all the liquid, because wetting liquid may have none left.
fn energy_scale<const D: usize>(model: &Model<D>, ledger: &Diagnostics<D>) -> f64 {
    let lowest: f64 = (0..D).map(|a| (model.gravity[a] * model.grid.domain_upper()[a]).max(0.0)).sum();
    let height = ledger.potential_energy + mass(model, ledger) * lowest;
    let surface = ledger.surface_energy.abs().max(model.surface_tension * ball_area::<D>(ledger.volume));
    ledger.kinetic_energy.max(height).max(surface).max(ledger.elastic_energy)
}

/// Area of a ball of a volume, m² (2D: m).
fn ball_area<const D: usize>(volume: f64) -> f64 {
    if D == 2 { 2.0 * (PI * volume).sqrt() } else { (36.0 * PI * volume * volume).cbrt() }
}

/// Mass of liquid and free solids, kg.
fn mass<const D: usize>(model: &Model<D>, ledger: &Diagnostics<D>) -> f64 {
    let solids = model.solids.iter().filter(|s| !s.kind.is_prescribed()).map(|s| s.mass_properties.mass);
    model.density * ledger.target_volume + solids.sum::<f64>()
}

/// Momentum of liquid and free solids, kg m/s.
fn momentum<const D: usize>(
    model: &Model<D>,
    solids: &[SolidState<D>],
    ledger: &Diagnostics<D>,
) -> Vector<D> {
    let free = model.solids.iter().zip(solids).filter(|(s, _)| !s.kind.is_prescribed());
    free.fold(ledger.momentum, |sum, (solid, now)| sum + now.velocity() * solid.mass_properties.mass)
}

/// Depth of the deepest overlap of solids, m.
fn deepest_overlap<const D: usize>(simulation: &Simulation<D>) -> f64 {
    overlaps(simulation.solids()).into_iter().map(|o| o.2).fold(0.0, f64::max)
}

/// Depth of the deepest centre of a liquid cell within a solid, m.
fn deepest_liquid<const D: usize>(simulation: &Simulation<D>) -> f64 {
    let grid = &simulation.model.grid;
    if simulation.model.solids.is_empty() {
        return 0.0;
    }
    let cells = simulation.liquid_cells().segments();
    let cells = cells.iter().flat_map(|s| (s.start..s.end).map(|i| s.row * grid.cells[0] + i));
    let centers = cells.map(|cell| grid.center(grid.lattice().coordinates(cell)));
    centers.map(|x| -simulation.distance_to_solids(&x)).fold(0.0, f64::max)
}

fn touches_a_side<const D: usize>(simulation: &Simulation<D>) -> bool {
    let (model, state) = (&simulation.model, &simulation.state);
    let (near, upper) = (SIDE_CONTACT_CELLS * model.grid.dx, model.grid.domain_upper());
    let out = |low: &Vector<D>, high: &Vector<D>| (0..D).any(|a| low[a] < near || high[a] > upper[a] - near);
    state.components.iter().any(|d| out(&d.lower, &d.upper))
        || simulation.solids().iter().any(|solid| {
            let [low, high] = solid.bounds();
            out(&low, &high)
        })
}

/// The largest speed that the energy of a scene can give the liquid, m/s, as the root of a sum of `2 E/m`:
///
/// - `v₀²`, the largest initial or prescribed speed: an impact redirects it and displaces liquid as fast;
/// - `2 g H`, a fall through the whole domain;
/// - `2 γ A₀ / ρ V`, the initial surface energy in all of the liquid;
/// - `γ / ρ Δ`, the retraction of a sheet of two cells, the thinnest on the grid (Taylor 1959, Culick 1960: `√(2 γ / ρ h)`); threads of
///   that size are as fast.
///
/// Splashes and jets of resolved liquid reach one to two times this speed; the bound is three times.
fn max_physical_speed<const D: usize>(
    simulation: &Simulation<D>,
    scene: &Scene,
    ledger: &Diagnostics<D>,
) -> f64 {
    let (model, solids) = (&simulation.model, &simulation.state.solids);
    let bodies = scene.liquid.bodies.iter().map(|b| b.velocity.iter().map(|v| v * v).sum::<f64>().sqrt());
    let starts = model.solids.iter().zip(solids).map(|(s, now)| s.max_speed(now));
    let led = scene.solids.iter().map(|s| match &s.material {
        Material::Kinematic { keyframes, .. } => keyframe_speed(keyframes),
        _ => 0.0,
    });
    let start = bodies.chain(starts).chain(led).filter(|v| v.is_finite()).fold(0.0, f64::max);
    let fall: f64 = (0..D).map(|a| 2.0 * (model.gravity[a] * model.grid.domain_upper()[a]).abs()).sum();
    let weight = model.density * ledger.volume;
    let surface =
        2.0 * ledger.surface_energy.abs().max(model.surface_tension * ball_area::<D>(ledger.volume));
    let sheet = model.surface_tension / (model.density * model.grid.dx);
    (start * start + fall + surface / weight + sheet).sqrt()
}

/// The largest speed between keyframes, m/s.
fn keyframe_speed(keyframes: &[Keyframe]) -> f64 {
    let speed = |pair: &[Keyframe]| {
        let ends = pair[1].translate.iter().zip(&pair[0].translate);
        ends.map(|(b, a)| (b - a).powi(2)).sum::<f64>().sqrt() / (pair[1].time - pair[0].time)
    };
    keyframes.windows(2).map(speed).fold(0.0, f64::max)
}
