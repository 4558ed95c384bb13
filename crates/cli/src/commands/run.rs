//! `meniscus run`.

use super::{print, view, with_threads};
use crate::args::{LogFormat, RunArgs};
use crate::failure::{Failure, MISSED, Result, STOPPED};
use crate::progress::{Reporter, format_simulated_time, format_wall_time};
use crate::scenes::{self, Loaded};
use crate::stop::StopMonitor;
use meniscus_scene::expect;
use meniscus_scene::file::{Expect, Scene};
use meniscus_scene::output::Folder;
use meniscus_scene::output::frame::Format;
use meniscus_scene::output::summary::{Summary, Verdict};
use meniscus_scene::output::time_series::TimeSeries;
use meniscus_scene::run::{ExistingRun, Outcome};
use meniscus_view::RenderOptions;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Most pictures at the end of a run; they show the motion in a few seconds.
const MAX_PICTURES: u64 = 50;

/// Simulates a scene into its output folder, then makes pictures and the page.
pub fn run(args: &RunArgs) -> Result {
    let loaded = load(args)?;
    let scene = loaded.scene;
    scenes::check_runnable(&scene)?;
    let threads = args.threads.map(usize::from).or(scene.numerics.threads);
    with_threads(threads, || simulate(args, &scene, loaded.folder))
}

/// Runs a scene on the current thread pool; `folder` is the output folder of an earlier run from which the scene was read.
fn simulate(args: &RunArgs, scene: &Scene, folder: Option<PathBuf>) -> Result {
    let out = args.out.clone().or(folder).unwrap_or_else(|| Path::new("out").join(&scene.name));
    let watch = StopMonitor::begin(args.walltime)
        .map_err(|e| Failure::new(1, format!("cannot install the signal handlers: {e}")))?;
    let existing = match (args.resume, args.force) {
        (true, _) => ExistingRun::Resume,
        (_, true) => ExistingRun::Replace,
        _ => ExistingRun::Refuse,
    };
    let folder = Folder::at(&out);
    let mut reporter = Reporter::new(args.log, args.quiet, resume_command(args, &out));
    let (setup, mut job) = scenes::prepare(scene)?;
    job.frames = args.frames;
    let outcome = setup.run(&job, &folder, existing, &|| watch.request(), &mut reporter)?;
    let text = args.log == LogFormat::Text && !args.quiet;
    match outcome {
        Outcome::AlreadyFinished(summary) if is_concluded(scene, &summary, &folder) => {
            if text {
                print(&format!("already finished: {}\n", out.display()))?;
            }
            Ok(status(&summary))
        }
        Outcome::AlreadyFinished(summary) => finish(args, scene, summary, &folder),
        Outcome::Stopped(_, summary) => stopped(args, &summary, &out),
        Outcome::Finished(summary) => finish(args, scene, summary, &folder),
    }
}

/// Loads the scene. `[expect]` concerns the whole run, so a shortened run is not checked against it.
fn load(args: &RunArgs) -> Result<Loaded> {
    let mut loaded = scenes::load(&args.scene, &[])?;
    let whole = loaded.scene.output.duration;
    if let Some(time) = &args.until {
        loaded = scenes::load(&args.scene, &[duration(time)])?;
    }
    let output = &loaded.scene.output;
    let last = args.frames.map_or(f64::INFINITY, |(_, b)| b as f64 * output.frame_interval());
    if output.duration.min(last) < whole * (1.0 - 1e-9) && !loaded.scene.expect.is_empty() {
        loaded.scene.expect = Expect::default();
        if !args.quiet && args.log == LogFormat::Text {
            eprintln!("the run is shorter than the scene's duration: [expect] is not checked");
        }
    }
    Ok(loaded)
}

/// `--until` as a setting of the scene, so that `scene.toml` reproduces this run.
pub fn duration(time: &str) -> String {
    format!("output.duration=\"{}\"", time.replace(['"', '\\'], ""))
}

fn stopped(args: &RunArgs, summary: &Summary, out: &Path) -> Result {
    if args.log == LogFormat::Text {
        let at = format_simulated_time(summary.simulated_seconds, summary.simulated_seconds);
        eprintln!("{} at {at}. Resume with:\n  {}", summary.exit_reason, resume_command(args, out));
    }
    Ok(STOPPED)
}

/// The command that resumes this run.
fn resume_command(args: &RunArgs, out: &Path) -> String {
    let mut words = vec!["meniscus".to_string(), "run".into(), quote(&args.scene.scene)];
    words.extend(args.scene.set.iter().flat_map(|set| ["--set".into(), quote(set)]));
    if let Some(quality) = args.scene.quality {
        words.push(format!("--quality {quality:?}").to_lowercase());
    }
    if let Some(until) = &args.until {
        words.extend(["--until".into(), quote(until)]);
    }
    if let Some((a, b)) = args.frames {
        let b = if b == u64::MAX { String::new() } else { b.to_string() };
        words.push(format!("--frames {a}:{b}"));
    }
    words.extend(["--out".into(), quote(&out.display().to_string()), "--resume".into()]);
    words.join(" ")
}

/// Quotes a word for a shell.
fn quote(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=:,+@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_string()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

/// Whether all that follows a finished run is there: the verdicts and, made last, the page.
fn is_concluded(scene: &Scene, summary: &Summary, folder: &Folder) -> bool {
    let has_page = folder.root().join("page/index.html").is_file();
    let has_verdicts = scene.expect.is_empty() || !summary.expect.is_empty();
    has_verdicts && (has_page || !scene.output.formats.contains(&Format::Page))
}

/// The exit status of a finished run.
fn status(summary: &Summary) -> u8 {
    if summary.expect.iter().all(|v| v.pass) { 0 } else { MISSED }
}

/// Reports expectations, makes pictures and page, and prints their paths.
fn finish(args: &RunArgs, scene: &Scene, mut summary: Summary, folder: &Folder) -> Result {
    conclude(scene, &mut summary, folder)?;
    let text = args.log == LogFormat::Text && !args.quiet;
    let mut report = String::new();
    let _ = writeln!(
        report,
        "{}: {} in {} steps, {} ({:.2} s/step), largest volume error of the run {:+.0e}",
        summary.scene,
        format_simulated_time(summary.simulated_seconds, summary.simulated_seconds),
        summary.steps,
        format_wall_time(summary.wall_seconds),
        summary.wall_seconds / summary.steps.max(1) as f64,
        summary.volume_error
    );
    let _ = writeln!(report, "frames    {} ({} frames)", folder.frames().display(), summary.frames);
    let shown = if scene.output.formats.contains(&Format::Page) {
        show(folder.root(), summary.frames, !text)
    } else {
        Ok(String::new())
    };
    report += shown.as_deref().unwrap_or_default();
    report += &repairs(&summary);
    let invariants = expect::solid_integrity(&summary).count();
    let (expected, always) = summary.expect.split_at(summary.expect.len().saturating_sub(invariants));
    let (expected, always) = (expected.iter().map(|v| ("expect", v)), always.iter().map(|v| ("always", v)));
    let verdicts = expected.chain(always);
    if text {
        let lines: String = verdicts.map(|(group, v)| verdict_line(group, v) + "\n").collect();
        print(&(report + &lines))?;
    } else if args.log == LogFormat::Text {
        verdicts.filter(|(_, v)| !v.pass).for_each(|(group, v)| eprintln!("{}", verdict_line(group, v)));
    }
    shown?;
    Ok(status(&summary))
}

/// Evaluates `[expect]` of a finished run and writes its summary.
///
/// # Errors
/// A failure of status 4 if a file cannot be read or written.
pub fn conclude(scene: &Scene, summary: &mut Summary, folder: &Folder) -> Result<()> {
    summary.expect = expect::evaluate(scene, summary, &TimeSeries::read(&folder.series())?);
    Ok(summary.write(&folder.summary())?)
}

/// Makes pictures and the page. Returns their paths as text.
///
/// # Errors
/// A failure of status 4 if a file cannot be read or written.
pub fn show(dir: &Path, frames: u64, quiet: bool) -> Result<String> {
    let every = frames.div_ceil(MAX_PICTURES).max(1) as usize;
    let options = RenderOptions { every, ..RenderOptions::default() };
    let rendered = view::pictures(dir, &options, quiet)?;
    let page: PathBuf = view::make_page(dir, 1, view::DEFAULT_PAGE_MB)?;
    Ok(view::describe(&rendered) + &format!("page      {}\n", page.display()))
}

/// A line with the nonzero repairs of a run, scaled as their bounds are: counts, and sums of volumes and momenta.
fn repairs(summary: &Summary) -> String {
    let part = |name: &str| ["_net", "_largest", "_residual"].iter().any(|end| name.ends_with(end));
    let told = summary.relative_repairs().filter(|(name, value)| *value != 0.0 && !part(name));
    let told: Vec<String> = told.map(|(name, value)| format!("{name} {}", short(value))).collect();
    if told.is_empty() { String::new() } else { format!("repairs   {}\n", told.join(", ")) }
}

/// A number in few characters.
fn short(value: f64) -> String {
    if value.fract() == 0.0 && value < 1e6 { format!("{value}") } else { format!("{value:.1e}") }
}

/// The line of a verdict; `group` is `expect` for those of the scene, or `always` for the invariants.
fn verdict_line(group: &str, v: &Verdict) -> String {
    let value = v.value.map_or_else(|| "not measured".into(), |x| expect::format_value(x, &v.unit));
    let verdict = if v.pass { "met" } else { "MISSED" };
    format!("{group:<10}{}: {value} (required: {}) {verdict}", v.quantity, v.bar)
}
