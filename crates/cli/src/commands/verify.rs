//! `meniscus verify`.

use super::{print, save, version, with_threads};
use crate::args::{ChosenScheme, VerifyArgs};
use crate::failure::{Failure, MISSED, Result, USAGE};
use meniscus_sim::Scheme;
use meniscus_validation::cases::paper;
use meniscus_validation::report::{self, History};
use meniscus_validation::setup::choose_scheme;
use meniscus_validation::{Case, Mode, Outcome, cases, groups};
use std::fmt::Write as _;
use std::panic::resume_unwind;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

/// Runs the validation suite or some of its cases.
pub fn verify(args: &VerifyArgs) -> Result {
    let chosen = choose(args)?;
    if args.list {
        let mut out = String::new();
        for case in &chosen {
            let quick = if case.quick { "quick" } else { "" };
            let _ = writeln!(out, "{:24} {quick:6} {}", case.name, case.title);
        }
        print(&out)?;
        return Ok(0);
    }
    if args.scheme == ChosenScheme::Paper {
        choose_scheme(Scheme::Paper);
    }
    earlier_history(args)?;
    let mode = if args.quick { Mode::Quick } else { Mode::Full };
    let earlier = if args.resume { earlier_outcomes(args, mode)? } else { Vec::new() };
    let suite = Suite { args, mode, chosen: &chosen, progress: Mutex::new(Progress::new(&chosen, earlier)) };
    let outcomes = suite.run()?;
    print(&report::summary(&outcomes))?;
    let passed = outcomes.iter().all(|o| o.checks.iter().all(|c| c.pass));
    Ok(if passed { 0 } else { MISSED })
}

/// The cases of a run, which workers take one after another.
struct Suite<'a> {
    args: &'a VerifyArgs,
    mode: Mode,
    chosen: &'a [&'a Case],
    progress: Mutex<Progress>,
}

/// What is done, and what is next.
struct Progress {
    /// Number of the next case to look at.
    next: usize,
    /// The outcome of each chosen case that has one.
    outcomes: Vec<Option<Outcome>>,
    /// Earlier outcomes of cases that were not chosen; they are saved with the rest.
    others: Vec<Outcome>,
}

impl Progress {
    fn new(chosen: &[&Case], mut others: Vec<Outcome>) -> Self {
        let earlier =
            |case: &&Case| others.iter().position(|o| o.name == case.name).map(|k| others.remove(k));
        Self { next: 0, outcomes: chosen.iter().map(earlier).collect::<Vec<_>>(), others }
    }

    /// The number of the next case without an outcome; its title and those of the earlier outcomes before it are printed.
    fn take(&mut self, chosen: &[&Case]) -> Result<Option<usize>> {
        while let Some(case) = chosen.get(self.next) {
            self.next += 1;
            let earlier = &self.outcomes[self.next - 1];
            let when = if earlier.is_some() { " (earlier)" } else { "" };
            eprintln!("[{}/{}] {}{when}", self.next, chosen.len(), case.title);
            let Some(earlier) = earlier else { return Ok(Some(self.next - 1)) };
            print(&report::text(earlier))?;
        }
        Ok(None)
    }
}

impl Suite<'_> {
    /// Runs the cases on as many workers as jobs were asked for, prints their checks, and saves the results after each. Returns the
    /// outcomes in the order of the cases.
    fn run(self) -> Result<Vec<Outcome>> {
        let jobs = usize::from(self.args.jobs);
        let threads = std::thread::available_parallelism().map_or(1, |cores| (cores.get() / jobs).max(1));
        let work = || with_threads(Some(threads), || self.work());
        std::thread::scope(|scope| {
            let workers: Vec<_> = (0..jobs).map(|_| scope.spawn(work)).collect();
            let ended = workers.into_iter().map(|w| w.join().unwrap_or_else(|panic| resume_unwind(panic)));
            ended.collect::<Vec<_>>().into_iter().collect::<Result<()>>()
        })?;
        let progress = self.progress.into_inner().unwrap_or_else(PoisonError::into_inner);
        let outcomes: Vec<Outcome> = progress.outcomes.into_iter().flatten().collect();
        save_results(self.args, &[outcomes.as_slice(), &progress.others].concat(), self.mode)?;
        Ok(outcomes)
    }

    /// Runs cases on the current thread pool until none is left.
    fn work(&self) -> Result<()> {
        let progress = || self.progress.lock().unwrap_or_else(PoisonError::into_inner);
        loop {
            let Some(number) = progress().take(self.chosen)? else { return Ok(()) };
            let outcome = self.chosen[number].outcome(self.mode);
            let mut progress = progress();
            print(&report::text(&outcome))?;
            progress.outcomes[number] = Some(outcome);
            let all: Vec<Outcome> =
                progress.outcomes.iter().flatten().chain(&progress.others).cloned().collect();
            if let Err(failure) = save_results(self.args, &all, self.mode) {
                progress.next = self.chosen.len();
                return Err(failure);
            }
        }
    }
}

/// Saves the results in the files that the arguments name.
fn save_results(args: &VerifyArgs, outcomes: &[Outcome], mode: Mode) -> Result<()> {
    let save = |path: &Option<PathBuf>, text: &dyn Fn() -> String| match path {
        Some(path) => save(path, &text()),
        None => Ok(()),
    };
    let mut history = earlier_history(args)?;
    history.add(outcomes, mode, &version_and_scheme(args));
    save(&args.json, &|| format!("{:#}\n", report::json(outcomes, mode, &version_and_scheme(args))))?;
    save(&args.history, &|| history.text())?;
    save(&args.html, &|| report::html(outcomes, mode, &version_and_scheme(args), &history))?;
    save(&args.markdown, &|| report::markdown(outcomes, groups(), mode, &version_and_scheme(args), &history))
}

/// The history in the file of `--history`; empty where there is no such file.
fn earlier_history(args: &VerifyArgs) -> Result<History> {
    let Some(path) = args.history.as_ref().filter(|path| path.exists()) else {
        return Ok(History::default());
    };
    let text = std::fs::read_to_string(path).map_err(Failure::file("read", path))?;
    History::parse(&text).map_err(|reason| {
        Failure::new(USAGE, format!("{} is no history: {reason}", path.display()))
            .help("give another file to --history")
    })
}

/// The outcomes in the file of `--json`; none where there is no such file.
fn earlier_outcomes(args: &VerifyArgs, mode: Mode) -> Result<Vec<Outcome>> {
    let Some(path) = args.json.as_ref().filter(|path| path.exists()) else { return Ok(Vec::new()) };
    let text = std::fs::read_to_string(path).map_err(Failure::file("read", path))?;
    report::outcomes_of_json(&text, mode, &version_and_scheme(args)).map_err(|reason| {
        Failure::new(USAGE, format!("cannot resume from {}: {reason}", path.display()))
            .help("give another file to --json, or leave out --resume")
    })
}

/// The version of the program, with the scheme if it is not that of Meniscus.
fn version_and_scheme(args: &VerifyArgs) -> String {
    match args.scheme {
        ChosenScheme::Meniscus => version(),
        ChosenScheme::Paper => format!("{}, scheme of the paper", version()),
    }
}

fn choose(args: &VerifyArgs) -> Result<Vec<&'static Case>> {
    let can_run = |case: &Case| args.scheme == ChosenScheme::Meniscus || paper::NAMES.contains(&case.name);
    if args.names.is_empty() {
        return Ok(cases().iter().filter(|case| can_run(case) && (case.quick || !args.quick)).collect());
    }
    let find = |name: &String| {
        cases().iter().find(|case| case.name == name).ok_or_else(|| {
            Failure::new(USAGE, format!("there is no validation case `{name}`"))
                .help("`meniscus verify --list` shows them all")
        })
    };
    let chosen: Vec<&Case> = args.names.iter().map(find).collect::<Result<_>>()?;
    match chosen.iter().find(|case| !can_run(case)) {
        Some(case) => {
            let message = format!("the scheme of the paper cannot run the validation case `{}`", case.name);
            Err(Failure::new(USAGE, message)
                .help("`meniscus verify --scheme paper --list` shows those that it can"))
        }
        None => Ok(chosen),
    }
}
