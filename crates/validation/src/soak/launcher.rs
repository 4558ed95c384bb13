//! Runs every case in its own process, so that a hang, a panic or a lack of memory ends that case only.

use super::judge::invariants::{CPU_BUDGET_SECONDS, DROP_TEST_CPU_BUDGET_SECONDS, HANG_CPU_SECONDS};
use super::{CaseOptions, CaseSet, Outcome, Violation, cpu_time};
use meniscus_scene::file::{LoadOptions, Scene};
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc;
use std::time::{Duration, Instant};

/// Time between polls of a process.
const POLL_INTERVAL: Duration = Duration::from_millis(20);
/// Prefixes of the lines in which a case sends its parent the text of a scene before it is tried, and its outcome.
pub const MESSAGE_PREFIXES: [&str; 2] = ["scene ", "outcome "];

/// Launcher of case processes.
#[derive(Clone, Debug)]
pub struct Launcher {
    /// The program, whose command `soak … --child` runs a case.
    pub program: PathBuf,
    /// Options of the random cases.
    pub wish: CaseOptions,
    /// Folder of the violations.
    pub out: PathBuf,
}

/// Range of cases to run.
#[derive(Clone, Copy, Debug)]
pub struct CaseRange {
    /// The first case.
    pub first: u64,
    /// Number of cases; unlimited if none.
    pub scenes: Option<u64>,
    /// No case begins after this time.
    pub until: Option<Instant>,
    /// Number of concurrent cases.
    pub jobs: usize,
}

impl Launcher {
    /// Runs cases concurrently. `each` receives every outcome as it arrives.
    pub fn run(&self, extent: &CaseRange, each: &mut dyn FnMut(&Outcome)) -> Vec<Outcome> {
        let next = AtomicU64::new(extent.first);
        let stop = AtomicBool::new(false);
        let mut all = Vec::new();
        std::thread::scope(|scope| {
            let (tell, told) = mpsc::channel();
            for _ in 0..extent.jobs.max(1) {
                let (tell, next, stop) = (tell.clone(), &next, &stop);
                scope.spawn(move || {
                    while !stop.load(Ordering::Relaxed) && extent.until.is_none_or(|end| Instant::now() < end)
                    {
                        let case = next.fetch_add(1, Ordering::Relaxed);
                        if extent.scenes.is_some_and(|count| case >= extent.first + count) {
                            break;
                        }
                        if tell.send(self.case(case)).is_err() {
                            break;
                        }
                    }
                });
            }
            drop(tell);
            for outcome in told {
                match outcome {
                    Ok(outcome) => {
                        each(&outcome);
                        all.push(outcome);
                    }
                    Err(_) => stop.store(true, Ordering::Relaxed),
                }
            }
        });
        all.sort_by_key(|outcome| outcome.case);
        all
    }

    /// Runs a case.
    ///
    /// # Errors
    /// A message if no process can be started.
    pub fn case(&self, case: u64) -> Result<Outcome, String> {
        let mut command = Command::new(&self.program);
        command.arg("soak").args(arguments(&self.wish)).args(["--case", &case.to_string()]);
        self.run_child(command, case)
    }

    /// Runs a scene file.
    ///
    /// # Errors
    /// A message if no process can be started.
    pub fn file(&self, path: &Path) -> Result<Outcome, String> {
        let mut command = Command::new(&self.program);
        command.arg("soak").args(["--set", self.wish.set.name()]).arg("--scene").arg(path);
        self.run_child(command, 0)
    }

    fn run_child(&self, mut command: Command, case: u64) -> Result<Outcome, String> {
        command.arg("--child").arg("--out").arg(&self.out);
        let piped = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::null()).spawn();
        let mut child = piped.map_err(|e| format!("cannot start {}: {e}", self.program.display()))?;
        let lines = child.stdout.take().map(BufReader::new);
        let reader = std::thread::spawn(move || {
            let mut told = [None, None];
            for line in lines.into_iter().flat_map(BufRead::lines).map_while(Result::ok) {
                for (kind, slot) in MESSAGE_PREFIXES.iter().zip(&mut told) {
                    line.strip_prefix(kind).into_iter().for_each(|rest| *slot = Some(rest.to_owned()));
                }
            }
            told
        });
        let budget = if self.wish.set == CaseSet::DropTest {
            DROP_TEST_CPU_BUDGET_SECONDS
        } else {
            CPU_BUDGET_SECONDS
        };
        let ended = wait(&mut child, budget[1] + 3.0 * HANG_CPU_SECONDS);
        let [text, outcome] = reader.join().unwrap_or_default();
        if let Some(outcome) = outcome.and_then(|o| serde_json::from_str(&o).ok()) {
            return Ok(outcome);
        }
        let text: String = text.and_then(|t| serde_json::from_str(&t).ok()).unwrap_or_default();
        self.without_outcome(&text, case, ended.0, ended.1)
    }

    /// The outcome of a process that sent none: it was killed, or ended on its own.
    fn without_outcome(&self, text: &str, case: u64, kind: &str, words: String) -> Result<Outcome, String> {
        let scene = Scene::from_text("drawn.toml", text, Path::new(""), &LoadOptions::default());
        let scene = scene.map_err(|e| format!("case {case}: {words}; error in its scene: {e}"))?;
        super::rerun::evidence::write_scene(&self.out, &scene.name, text).map_err(|e| e.to_string())?;
        let mut outcome = Outcome::at_start(&scene, case, Vec::new());
        outcome.violations.push(Violation::described(kind, 0, 0.0, words));
        Ok(outcome)
    }
}

/// The arguments that reproduce the same scenes.
pub fn arguments(wish: &CaseOptions) -> Vec<String> {
    let mut words = vec!["--seed".into(), wish.seed.to_string()];
    if wish.set != CaseSet::Random {
        words.extend(["--set".into(), wish.set.name().into()]);
    }
    wish.dimension.iter().for_each(|d| words.extend(["--dimension".into(), d.to_string()]));
    wish.class.iter().for_each(|c| words.extend(["--solids".into(), solids(*c).into()]));
    if wish.quick {
        words.push("--quick".into());
    }
    words
}

/// The value of `--solids` for a class.
fn solids(class: super::Class) -> &'static str {
    match class {
        super::Class::Liquid => "none",
        other => other.name(),
    }
}

/// Waits for a process, and kills it if it exceeds all limits of its own guard.
fn wait(child: &mut Child, most: f64) -> (&'static str, String) {
    let start = Instant::now();
    loop {
        match child.try_wait() {
            Ok(Some(status)) => return ("panic", format!("the process ended with {status}")),
            Ok(None) => {}
            Err(error) => return ("panic", format!("the state of the process is unknown: {error}")),
        }
        let seconds = cpu_time::of_process(child.id()).unwrap_or_else(|| start.elapsed().as_secs_f64());
        if seconds > most {
            let _ = child.kill();
            let _ = child.wait();
            return ("hang", format!("killed after {seconds:.0} s, before the first step or after the last"));
        }
        std::thread::sleep(POLL_INTERVAL);
    }
}
