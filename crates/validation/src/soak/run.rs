//! Runs a case step by step as `meniscus run` does, checks the invariants, and ends hanging steps from a second thread.

use super::judge::invariant_checks::InvariantChecks;
use super::judge::invariants::{
    COMPARED_STEPS, CPU_BUDGET_SECONDS, DROP_TEST_CPU_BUDGET_SECONDS, DROP_TEST_MAX_STEPS, HANG_CPU_SECONDS,
    MAX_ENERGY_RISE_PER_STEP, MAX_STEPS, MEMORY_LIMITS, SLOW_STEP_LIMITS,
};
use super::rerun::accepted::{AcceptedScene, accepted_scene};
use super::rerun::evidence;
use super::rerun::repeat::{Waypoint, repeat};
use super::{CaseSet, Outcome, Subject, Violation, cpu_time};
use crate::soak::scheduled::ScheduledSimulation;
use meniscus_scene::build::AnySetup;
use meniscus_scene::estimate::check::check;
use meniscus_scene::file::Scene;
use meniscus_scene::output::summary::peak_memory;
use meniscus_scene::run::{RunStatistics, Setup};
use meniscus_sim::{Compiled, Model, Simulation, State, StepError};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Time between polls of the guard.
const POLL_INTERVAL: Duration = Duration::from_millis(100);

/// Data shared by the worker and its guard.
struct Record<const D: usize> {
    outcome: Outcome,
    model: Model<D>,
    /// The state before the current step, and its statistics.
    state_before_step: Option<(State<D>, RunStatistics)>,
    /// Processor time at the start of the current step, s; none between steps.
    step_began: Option<f64>,
    written: bool,
}

/// The scene of a case and the folder of its evidence.
struct Case {
    scene: Scene,
    text: String,
    out: PathBuf,
    set: CaseSet,
}

/// Runs a subject. `tell` receives the text of every scene before it is tried. If a step hangs, `hung` receives the outcome on another
/// thread and must end the process, because nothing else stops a step.
///
/// # Errors
/// A message if there is no scene or nothing can be written.
pub fn run(
    subject: &Subject,
    out: &Path,
    tell: &mut (dyn FnMut(&str) + Send),
    hung: fn(&Outcome),
) -> Result<Outcome, String> {
    // On one thread a step takes about as long, and two cases side by side keep two cores busy.
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().map_err(|e| e.to_string())?;
    one.install(|| {
        let AcceptedScene { text, scene, setup, refused } = accepted_scene(subject, tell)?;
        let number = if let Subject::Case(_, case) = subject { *case } else { 0 };
        let outcome = Outcome::at_start(&scene, number, refused);
        let wanted = repeat_for(subject);
        let case = Arc::new(Case { scene, text, out: out.to_path_buf(), set: subject.set() });
        match &setup {
            AnySetup::D2(setup) => run_guarded(&case, setup, outcome, wanted, hung),
            AnySetup::D3(setup) => run_guarded(&case, setup, outcome, wanted, hung),
        }
    })
}

/// Kind of the repetition of a random case; half of the cases are not repeated.
fn repeat_for(subject: &Subject) -> Option<&'static str> {
    let Subject::Case(wish, case) = subject else { return None };
    if wish.set != CaseSet::Random {
        return None;
    }
    let mut random = super::draw::random::Random::of(&[wish.seed, *case, u64::MAX]);
    let kinds = [None, Some("threads"), Some("resume"), Some("mirror"), Some("shift")];
    kinds[random.weighted_index(&[0.5, 0.13, 0.13, 0.12, 0.12])]
}

fn run_guarded<const D: usize>(
    case: &Arc<Case>,
    setup: &Setup<D>,
    outcome: Outcome,
    wanted: Option<&'static str>,
    hung: fn(&Outcome),
) -> Result<Outcome, String>
where
    Simulation<D>: Compiled<D>,
{
    let model = setup.model.clone();
    let record = Record { outcome, model, state_before_step: None, step_began: None, written: false };
    let record = Arc::new(Mutex::new(record));
    let watched = (record.clone(), case.clone());
    std::thread::spawn(move || guard(&watched.0, &watched.1, hung));
    let mut worker =
        Worker { record: record.clone(), case: case.clone(), times: Vec::new(), points: Vec::new() };
    let done = catch_unwind(AssertUnwindSafe(|| worker.work(setup, wanted)));
    let mut record = lock(&record);
    record.step_began = None;
    if let Err(payload) = done {
        let words = payload.downcast_ref::<String>().cloned();
        let words = words.or_else(|| payload.downcast_ref::<&str>().map(|s| (*s).to_owned()));
        record.add_described("panic", words.unwrap_or_default());
        record.save(case)?;
    }
    record.outcome.seconds = cpu_time::of_this_process();
    Ok(record.outcome.clone())
}

fn lock<const D: usize>(record: &Mutex<Record<D>>) -> MutexGuard<'_, Record<D>> {
    record.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Ends a step that takes too long.
fn guard<const D: usize>(record: &Mutex<Record<D>>, case: &Case, hung: fn(&Outcome))
where
    Simulation<D>: Compiled<D>,
{
    loop {
        std::thread::sleep(POLL_INTERVAL);
        let mut record = lock(record);
        let Some(seconds) = record.step_began.map(|began| cpu_time::of_this_process() - began) else {
            continue;
        };
        if seconds > HANG_CPU_SECONDS {
            record.add("hang", seconds, HANG_CPU_SECONDS, "s of processor time in one step".into());
            let saved = record.save(case);
            saved.err().into_iter().for_each(|error| record.outcome.cut = Some(error));
            record.outcome.seconds = cpu_time::of_this_process();
            hung(&record.outcome);
        }
    }
}

impl<const D: usize> Record<D> {
    fn add_described(&mut self, kind: &str, words: String) {
        self.add(kind, 0.0, 0.0, words);
    }

    /// Adds a violation in the current step.
    fn add(&mut self, kind: &str, value: f64, bar: f64, words: String) {
        let (step, time) = (self.outcome.steps + 1, self.outcome.time);
        self.note(Violation { value, worst: value, bar, ..Violation::described(kind, step, time, words) });
    }

    /// Keeps the first violation of a kind, and its worst value.
    fn note(&mut self, violation: Violation) {
        match self.outcome.violations.iter_mut().find(|v| v.kind == violation.kind) {
            Some(first) if first.words != violation.words => {}
            Some(first) if violation.bar > 0.0 => first.worst = first.worst.max(violation.value),
            Some(first) => first.worst = first.worst.min(violation.value),
            None => self.outcome.violations.push(violation),
        }
    }

    /// Writes scene and checkpoint before the first violation, once.
    fn save(&mut self, case: &Case) -> Result<(), String>
    where
        Simulation<D>: Compiled<D>,
    {
        if std::mem::replace(&mut self.written, true) {
            return Ok(());
        }
        let Case { scene, text, out, .. } = case;
        let written = match &self.state_before_step {
            Some((state, tally)) => evidence::write(out, scene, text, &self.model, state, tally),
            None => evidence::write_scene(out, &scene.name, text),
        };
        written.map_err(|e| e.to_string())
    }
}

/// Resets the peak memory, because refused scenes may have taken more. Only Linux supports it; elsewhere the peak of the whole process
/// counts.
fn forget_peak_memory() {
    let _ = std::fs::write("/proc/self/clear_refs", "5");
}

/// Performs and times the steps.
struct Worker<const D: usize> {
    record: Arc<Mutex<Record<D>>>,
    case: Arc<Case>,
    times: Vec<f64>,
    points: Vec<Waypoint<D>>,
}

impl<const D: usize> Worker<D> {
    fn work(&mut self, setup: &Setup<D>, wanted: Option<&'static str>)
    where
        Simulation<D>: Compiled<D>,
    {
        let case = self.case.clone();
        forget_peak_memory();
        lock(&self.record).step_began = Some(cpu_time::of_this_process());
        let mut walk = ScheduledSimulation::start(setup, &case.scene);
        let mut books = InvariantChecks::at_start(&walk.simulation, &case.scene);
        let mut tally = RunStatistics::at_start(&setup.model, &walk.simulation.diagnostics());
        while !walk.is_over() && self.within_budget() {
            tally.next_frame = walk.frame;
            let ended = self.step(&mut walk, &mut books, &mut tally);
            if wanted.is_some() && [COMPARED_STEPS / 2, COMPARED_STEPS].contains(&walk.simulation.state.step)
            {
                self.points.push(Waypoint { state: walk.simulation.state.clone(), frame: walk.frame });
            }
            if ended {
                break;
            }
        }
        self.close();
        if let (Some(wanted), [middle, end]) = (wanted, self.points.as_slice()) {
            let begins = || lock(&self.record).step_began = Some(cpu_time::of_this_process());
            let found = repeat(wanted, &self.case.scene, setup, [middle, end], books.scale(), &begins);
            let mut record = lock(&self.record);
            record.step_began = None;
            if let Some(found) = found {
                record.outcome.repeated = Some(wanted.into());
                found.into_iter().for_each(|violation| record.note(violation));
            }
        }
        self.save();
    }

    /// Performs one step. Returns whether the run has ended.
    fn step(
        &mut self,
        walk: &mut ScheduledSimulation<D>,
        books: &mut InvariantChecks<D>,
        tally: &mut RunStatistics,
    ) -> bool
    where
        Simulation<D>: Compiled<D>,
    {
        {
            let mut record = lock(&self.record);
            record.state_before_step = Some((walk.simulation.state.clone(), tally.clone()));
            record.step_began = Some(cpu_time::of_this_process());
        }
        let (wall, processor) = (Instant::now(), cpu_time::of_this_process());
        let done = walk.step();
        // The smaller of both: the wall clock includes the load of others, processor time comes in ticks.
        let seconds = wall.elapsed().as_secs_f64().min((cpu_time::of_this_process() - processor).max(0.01));
        self.times.push(seconds);
        let mut record = lock(&self.record);
        record.step_began = None;
        let report = match done {
            Ok(report) => report,
            Err(error) => {
                let kind =
                    if matches!(error, StepError::NotFinite { .. }) { "not-finite" } else { "gave-up" };
                record.add_described(kind, error.to_string());
                drop(record);
                self.save();
                return true;
            }
        };
        let state = &walk.simulation.state;
        tally.add_step(&walk.simulation.model, state.time, &report);
        let found = books.check(&walk.simulation, &report);
        if self.case.set == CaseSet::DropTest {
            record.outcome.energy_law = books.energy_law().cloned();
        }
        let is_finite = found.iter().all(|v| v.kind != "not-finite");
        (record.outcome.steps, record.outcome.time) = (state.step, state.time);
        found.into_iter().for_each(|violation| record.note(violation));
        drop(record);
        self.save();
        !is_finite
    }

    /// Writes the evidence if there is a violation.
    fn save(&self)
    where
        Simulation<D>: Compiled<D>,
    {
        let mut record = lock(&self.record);
        if !record.outcome.violations.is_empty()
            && let Err(error) = record.save(&self.case)
        {
            record.outcome.cut = Some(error);
        }
    }

    /// Whether there is time for another step.
    fn within_budget(&self) -> bool {
        let (budget, steps) = match self.case.set {
            CaseSet::Random => (CPU_BUDGET_SECONDS[D - 2], MAX_STEPS),
            CaseSet::DropTest => (DROP_TEST_CPU_BUDGET_SECONDS[D - 2], DROP_TEST_MAX_STEPS),
        };
        let mut record = lock(&self.record);
        if cpu_time::of_this_process() > budget {
            record.outcome.cut = Some(format!("after {budget} s"));
        } else if record.outcome.steps >= steps {
            record.outcome.cut = Some(format!("after {steps} steps"));
        }
        record.outcome.cut.is_none()
    }

    /// Checks of the whole run: its longest step, and its memory.
    fn close(&mut self) {
        let mut record = lock(&self.record);
        record.step_began = None;
        let slowest = self.times.iter().copied().enumerate().max_by(|a, b| a.1.total_cmp(&b.1));
        let mut sorted = self.times.clone();
        sorted.sort_by(f64::total_cmp);
        let median = sorted.get(sorted.len() / 2).copied().unwrap_or(0.0);
        let bar = (SLOW_STEP_LIMITS.0 * median).max(SLOW_STEP_LIMITS.1);
        record.outcome.median_step = median;
        if let Some((step, seconds)) = slowest {
            record.outcome.slowest_step = seconds;
            if seconds > bar {
                record.add("slow-step", seconds, bar, format!("s in step {}", step + 1));
            }
        }
        if let Some(law) =
            record.outcome.energy_law.clone().filter(|law| law.largest > MAX_ENERGY_RISE_PER_STEP)
        {
            let (value, worst, bar) = (law.largest, law.largest, MAX_ENERGY_RISE_PER_STEP);
            let told = Violation::described("energy-step", law.step, law.time, law.words());
            record.note(Violation { value, worst, bar, ..told });
        }
        record.outcome.memory = peak_memory();
        let estimate = check(&self.case.scene, 1).memory_bytes;
        let bar = MEMORY_LIMITS.0 * estimate + MEMORY_LIMITS.1;
        if let Some(bytes) = record.outcome.memory.map(|m| m as f64).filter(|bytes| *bytes > bar) {
            record.add("memory", bytes, bar, format!("bytes; estimate of `meniscus check`: {estimate:.3e}"));
        }
    }
}
