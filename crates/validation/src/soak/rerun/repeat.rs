//! Repeats a case in a way that must give the same result: on two threads, from a checkpoint, mirrored, shifted.

use super::accepted::round_tripped;
use super::evidence::checkpoint_round_trip;
use super::scene_transform::SceneTransform;
use crate::soak::Violation;
use crate::soak::judge::invariants::{COMPARED_STEPS, MIRROR_TOLERANCES, SHIFT_TOLERANCES};
use crate::soak::scheduled::ScheduledSimulation;
use meniscus_scene::build::AnySetup;
use meniscus_scene::file::Scene;
use meniscus_scene::run::Setup;
use meniscus_sim::{Compiled, Simulation, State};

/// Shift of the shifted run, in cells; not a simple fraction.
const SHIFT_CELLS: f64 = 0.37;

/// A state of the original run for comparison.
pub struct Waypoint<const D: usize> {
    /// The state after a step.
    pub state: State<D>,
    /// The next frame at that state.
    pub frame: u64,
}

/// Repeats a run from its start or its middle to the end of its first [`COMPARED_STEPS`] steps; none if the scene has no such image.
/// `scale` is that of its energy, J; `begins` is called before every step.
pub fn repeat<const D: usize>(
    how: &str,
    scene: &Scene,
    setup: &Setup<D>,
    [middle, end]: [&Waypoint<D>; 2],
    scale: f64,
    begins: &(dyn Fn() + Sync),
) -> Option<Vec<Violation>>
where
    Simulation<D>: Compiled<D>,
{
    let walk = ScheduledSimulation::start;
    match how {
        "threads" => {
            let two = rayon::ThreadPoolBuilder::new().num_threads(2).build().ok()?;
            let state = two.install(|| steps(walk(setup, scene), COMPARED_STEPS, begins));
            Some(same_bits(how, &state, &end.state))
        }
        "resume" => {
            let folder = std::env::temp_dir().join(format!("meniscus-soak-{}", std::process::id()));
            let read = match checkpoint_round_trip(&folder, &middle.state) {
                Ok(state) => state,
                Err(error) => return Some(vec![broken(how, error)]),
            };
            let simulation = Simulation::resume(setup.model.clone(), read);
            let state =
                steps(ScheduledSimulation::from(simulation, scene, middle.frame), COMPARED_STEPS / 2, begins);
            Some(same_bits(how, &state, &end.state))
        }
        _ => {
            let shift = if how == "shift" { SHIFT_CELLS * scene.domain.dx } else { 0.0 };
            let image = SceneTransform { mirrored: how == "mirror", size: scene.domain.size[0], shift };
            let (other, its_setup) = round_tripped(&image.scene(scene)?)?;
            let compared = Pair { how, image, setup, end, scale, begins };
            match &its_setup {
                AnySetup::D2(its) if D == 2 => compared.compare_with::<2>(its, &other),
                AnySetup::D3(its) if D == 3 => compared.compare_with::<3>(its, &other),
                _ => None,
            }
        }
    }
}

fn broken(how: &str, words: String) -> Violation {
    Violation::described(how, COMPARED_STEPS, 0.0, words)
}

/// The state after some steps, or a message if there is none.
fn steps<const D: usize>(
    mut walk: ScheduledSimulation<D>,
    count: u64,
    begins: &(dyn Fn() + Sync),
) -> Result<State<D>, String> {
    for _ in 0..count {
        begins();
        walk.step().map_err(|e| e.to_string())?;
    }
    Ok(walk.simulation.state)
}

fn same_bits<const D: usize>(
    how: &str,
    state: &Result<State<D>, String>,
    wanted: &State<D>,
) -> Vec<Violation> {
    match state {
        Ok(state) if state == wanted => Vec::new(),
        Ok(state) => {
            let fields = |s: &State<D>| {
                let all = s.velocity.axes.iter().chain([&s.phi.data]).flatten();
                all.copied().collect::<Vec<f64>>()
            };
            let (one, other) = (fields(state), fields(wanted));
            let differ = one.iter().zip(&other).filter(|(a, b)| a.to_bits() != b.to_bits()).count();
            let words =
                format!("values of φ and velocity differ; times {:e} and {:e} s", state.time, wanted.time);
            let value = differ as f64;
            vec![Violation { value, worst: value, time: wanted.time, ..broken(how, words) }]
        }
        Err(error) => vec![broken(how, format!("the repeated run failed: {error}"))],
    }
}

/// A run and its image.
struct Pair<'a, const D: usize> {
    how: &'a str,
    image: SceneTransform,
    setup: &'a Setup<D>,
    end: &'a Waypoint<D>,
    scale: f64,
    begins: &'a (dyn Fn() + Sync),
}

impl<const D: usize> Pair<'_, D> {
    /// Compares energy and centre of mass at the time of the waypoint.
    fn compare_with<const E: usize>(&self, its: &Setup<E>, scene: &Scene) -> Option<Vec<Violation>>
    where
        Simulation<D>: Compiled<D>,
        Simulation<E>: Compiled<E>,
    {
        let time = self.end.state.time;
        let mut simulation = its.simulation();
        let start = simulation.diagnostics().volume;
        while simulation.state.time < time * (1.0 - 1e-12) {
            (self.begins)();
            if let Err(error) = simulation.step(time - simulation.state.time, &mut |_| ()) {
                return Some(vec![broken(self.how, format!("the transformed run failed: {error}"))]);
            }
        }
        let own = Simulation::resume(self.setup.model.clone(), self.end.state.clone()).diagnostics();
        let other = simulation.diagnostics();
        let stored = |surface: f64, elastic: f64| surface + elastic;
        let energies = stored(own.surface_energy, own.elastic_energy) + own.kinetic_energy
            - stored(other.surface_energy, other.elastic_energy)
            - other.kinetic_energy;
        let wanted = self.image.point(own.centroid.as_slice());
        // The centre of the liquid that left through open sides is unknown.
        let share = own.volume.min(other.volume) / start;
        let off = other.centroid.iter().zip(&wanted).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
        let mut found = Vec::new();
        let mut at_most = |value: f64, bar: f64, words: &str| {
            if value > bar {
                found.push(Violation { value, worst: value, bar, time, ..broken(self.how, words.into()) });
            }
        };
        let (of_energy, of_place) = if self.image.mirrored { MIRROR_TOLERANCES } else { SHIFT_TOLERANCES };
        at_most(energies.abs() / self.scale, of_energy, "energy difference over the energy scale");
        at_most(share * off / scene.domain.dx, of_place, "distance of the centres of mass, cells");
        Some(found)
    }
}
