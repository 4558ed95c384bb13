//! `meniscus sweep`: many runs of a scene, their table, and the search of a threshold.
//!
//! A sweep is a folder: `sweep.json` with its plan, for each case `case_NNNN.toml`, the scene as run, and `case_NNNN`, the output folder,
//! `sweep.csv` and `index.html` with what the cases came to. All that says how far it is lies in these files: the same command goes on.

mod budget;
mod find;
mod grid;
mod outcome;
mod page;
mod plan;
mod runner;
mod slurm;
mod table;
mod vary;

pub use self::grid::Sweep;
pub use self::runner::{Ended, Runner};
pub use self::table::{Cell, Parameter, Row, Table};
pub use self::vary::Vary;

use self::budget::Budget;
use self::find::Search;
use self::plan::{Plan, SweepFolder};

use self::vary::{Interval, ValueError};
use super::{print, run, save};
use crate::args::{LogFormat, RunArgs, SceneArgs, SweepArgs};
use crate::failure::{Failure, MISSED, Result, STOPPED, USAGE};
use crate::own_program;
use crate::scenes;
use crate::stop::StopMonitor;
use meniscus_scene::run::Stop;
use std::path::{Path, PathBuf};

/// Relative width at which `--find` ends by default; chosen without experiment.
const TOLERANCE: f64 = 0.02;

/// Runs a sweep, a case of it, or a search.
pub fn sweep(args: &SweepArgs) -> Result {
    let given = SweepFolder::at(Path::new(&args.scene.scene));
    if given.holds_a_plan() {
        return of_folder(args, &given);
    }
    if args.vary.is_empty() {
        let message = "nothing is varied, and SCENE is not the folder of a sweep";
        let range = if args.find.is_some() { "60:120" } else { "60:120:3" };
        return Err(usage(
            message,
            format!("add, for example, --vary tension.plate.contact_angle={range}deg"),
        ));
    }
    match &args.find {
        Some(check) => find(args, check),
        None => grid(args),
    }
}

fn usage(message: impl Into<String>, help: impl Into<String>) -> Failure {
    Failure::new(USAGE, message).help(help)
}

fn wrong_value((message, help): ValueError) -> Failure {
    usage(format!("--vary: {message}"), help)
}

/// A sweep whose folder is given.
fn of_folder(args: &SweepArgs, folder: &SweepFolder) -> Result {
    let changes = !args.vary.is_empty() || !args.scene.set.is_empty() || args.scene.quality.is_some();
    let changes = changes || args.budget.is_some();
    if changes || args.out.is_some() || args.find.is_some() {
        let message =
            format!("`{}` is the folder of a sweep, whose scenes are written", folder.root().display());
        return Err(usage(
            message,
            "leave out --vary, --set, --quality, --budget, --find and --out, or give the scene",
        ));
    }
    let plan = folder.plan()?;
    if plan.find.is_some() && !args.collect {
        let message = format!("`{}` is the folder of a search", folder.root().display());
        return Err(usage(message, "to go on, give the command that began it; --collect writes the table"));
    }
    work(args, folder, &plan)
}

/// All combinations of the values.
fn grid(args: &SweepArgs) -> Result {
    let vary: Vec<Vary> =
        args.vary.iter().map(|text| Vary::parse(text).map_err(wrong_value)).collect::<Result<_>>()?;
    let count = vary.iter().try_fold(1usize, |n, v| n.checked_mul(v.values.len())).unwrap_or(usize::MAX);
    if let Some(case) = args.case.filter(|case| *case >= count) {
        return Err(no_case(case, count));
    }
    let name = scenes::load(&args.scene, &[])?.scene.name;
    let folder = SweepFolder::at(&out(args, &format!("{name}-sweep")));
    let first = vary.iter().filter_map(|v| Some(format!("{}={}", v.path, v.values.first()?)));
    let last = vary.iter().filter_map(|v| Some(format!("{}={}", v.path, v.values.last()?)));
    let scene = in_budget(args, &folder, count, &[first.collect(), last.collect()])?;
    let sweep = Sweep::new(&scene, vary, args.out.as_deref())?;
    work(args, sweep.folder(), sweep.plan())
}

/// The scene with the resolution for `--budget`, if it is given. `ends` are the settings of the first and the last of the cases.
fn in_budget(
    args: &SweepArgs,
    folder: &SweepFolder,
    cases: usize,
    ends: &[Vec<String>; 2],
) -> Result<SceneArgs> {
    let mut scene = args.scene.clone();
    if let Some(budget) = args.budget {
        // A search runs one case after the other.
        let jobs = if args.find.is_some() { 1 } else { args.jobs.into() };
        let budget = Budget { seconds: budget.as_secs_f64(), cases, jobs };
        scene.cells = Some(budget.cells(&scene, folder, ends)?);
    }
    Ok(scene)
}

fn out(args: &SweepArgs, name: &str) -> PathBuf {
    args.out.clone().unwrap_or_else(|| Path::new("out").join(name))
}

fn no_case(case: usize, count: usize) -> Failure {
    usage(format!("there is no case {case}"), format!("the cases are 0 to {}", count.saturating_sub(1)))
}

/// Does with a sweep whose cases are written what the arguments ask for.
fn work(args: &SweepArgs, folder: &SweepFolder, plan: &Plan) -> Result {
    let cases = match plan.find {
        Some(_) => folder.written_cases(plan),
        None => plan.cases(),
    };
    if args.slurm {
        let script = folder.file("run.sbatch");
        save(&script, &slurm::script(folder, &plan.name, cases.len(), args.threads)?)?;
        let root = folder.root().display();
        print(&format!(
            "{} cases in {root}\nstart them:      sbatch {}\nthen their table: meniscus sweep {root} --collect\n",
            cases.len(),
            script.display()
        ))?;
        return Ok(0);
    }
    if let Some(case) = args.case {
        return if case < cases.len() { one(args, folder, case) } else { Err(no_case(case, cases.len())) };
    }
    if args.collect {
        collect(args, folder, plan, &cases)?;
        return Ok(0);
    }
    let stop = stop_monitor(args)?;
    let all: Vec<usize> = (0..cases.len()).collect();
    let stop = || stop.request();
    let mut progress = Progress { folder, quiet: args.quiet, done: 0, count: Some(cases.len()) };
    let mut tell = |end: &Ended| progress.tell(end, &plan.sets(&cases[end.case]).join(" "));
    let ended = runner(args, folder, &stop)?.run(&all, &mut tell)?;
    collect(args, folder, plan, &cases)?;
    Ok(status(&ended))
}

/// Runs one case in this process.
fn one(args: &SweepArgs, folder: &SweepFolder, case: usize) -> Result {
    let scene = folder.scene(case).display().to_string();
    run::run(&RunArgs {
        scene: SceneArgs { scene, set: Vec::new(), quality: None, cells: None },
        out: Some(folder.run(case)),
        resume: true,
        until: None,
        frames: None,
        threads: args.threads,
        walltime: args.walltime,
        log: LogFormat::Text,
        quiet: args.quiet,
        force: false,
    })
}

/// Searches the value at which a check changes.
fn find(args: &SweepArgs, check: &str) -> Result {
    let [text] = &args.vary[..] else {
        return Err(usage("--find searches along one parameter", "give one --vary PATH=A:B"));
    };
    if args.case.is_some() {
        return Err(usage("--find chooses its cases itself", "leave out --case"));
    }
    let interval = Interval::parse(text).map_err(wrong_value)?;
    let tolerance = args.tolerance.unwrap_or(TOLERANCE);
    let name = scenes::load(&args.scene, &[])?.scene.name;
    let folder = SweepFolder::at(&out(args, &format!("{name}-find")));
    let ends = [interval.from, interval.to].map(|x| vec![format!("{}={}", interval.path, interval.text(x))]);
    // The two ends, and the halvings from the whole range to the tolerance.
    let cases = 2 + (1.0 / tolerance).log2().ceil() as usize;
    let scene = in_budget(args, &folder, cases, &ends)?;
    let load = |set: &str| Ok(scenes::load(&scene, &[set.to_owned()])?.scene);
    let search = Search { interval, check: check.to_owned(), tolerance, load: &load };
    let plan = search.plan(&name);
    search.check_ends()?;
    folder.keep_plan(&plan)?;
    let stop = stop_monitor(args)?;
    let mut progress = Progress { folder: &folder, quiet: args.quiet, done: 0, count: None };
    let stop = || stop.request();
    let found = search.run(&folder, &runner(args, &folder, &stop)?, &mut |end, set| progress.tell(end, set));
    collect(args, &folder, &plan, &folder.written_cases(&plan))?;
    found
}

fn stop_monitor(args: &SweepArgs) -> Result<StopMonitor> {
    StopMonitor::begin(args.walltime)
        .map_err(|e| Failure::new(1, format!("cannot install the signal handlers: {e}")))
}

fn runner<'a>(
    args: &SweepArgs,
    folder: &'a SweepFolder,
    stop: &'a dyn Fn() -> Option<Stop>,
) -> Result<Runner<'a>> {
    let jobs = usize::from(args.jobs);
    let threads = args.threads.map_or_else(|| Runner::threads_of_each(jobs), usize::from);
    Ok(Runner { folder, jobs, threads, program: own_program::words()?, stop })
}

/// Tells of cases as they end, on standard error.
struct Progress<'a> {
    folder: &'a SweepFolder,
    quiet: bool,
    done: usize,
    /// Number of all cases, where it is known.
    count: Option<usize>,
}

impl Progress<'_> {
    fn tell(&mut self, end: &Ended, sets: &str) {
        self.done += 1;
        if self.quiet && !end.has_failed() {
            return;
        }
        let how = match end.status {
            0 => "finished".to_owned(),
            MISSED => "finished, a check is missed".to_owned(),
            STOPPED => "stopped; the same command goes on".to_owned(),
            status => {
                format!("FAILED with exit status {status}, see {}", self.folder.log(end.case).display())
            }
        };
        let count = self.count.map_or_else(String::new, |count| format!("/{count}"));
        eprintln!("[{}{count}] case {}  {sets}: {how}", self.done, end.case);
    }
}

/// The exit status of all cases: 75 if one was stopped, else that of the first that failed, else 6 if a check is missed.
fn status(ended: &[Ended]) -> u8 {
    let all = || ended.iter().map(|end| end.status);
    let failed = all().find(|status| ![0, MISSED, STOPPED].contains(status));
    let of = |wanted: u8| all().find(|status| *status == wanted);
    of(STOPPED).or(failed).or(of(MISSED)).unwrap_or(0)
}

/// Writes table and page, and prints the table.
fn collect(args: &SweepArgs, folder: &SweepFolder, plan: &Plan, cases: &[Vec<String>]) -> Result<()> {
    let table = grid::write_table(folder, plan, cases)?;
    if args.quiet {
        return Ok(());
    }
    let (csv, page) = (folder.file(grid::TABLE), folder.file(grid::PAGE));
    print(&format!("{}table     {}\npage      {}\n", table.text(), csv.display(), page.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gravest_status_is_that_of_the_sweep() {
        let of = |all: &[u8]| {
            status(&all.iter().map(|status| Ended { case: 0, status: *status }).collect::<Vec<_>>())
        };
        assert_eq!([of(&[0, 0]), of(&[0, 6, 0]), of(&[6, 5, 4]), of(&[6, 5, 75])], [0, 6, 5, 75]);
    }
}
