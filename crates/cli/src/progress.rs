//! Progress reports: a bar on a terminal, plain lines or JSON lines elsewhere.

use crate::args::LogFormat;
use crate::failure::STOPPED;
use indicatif::{ProgressBar, ProgressStyle};
use meniscus_scene::run::{Event, Observer, Progress, RemoteObserver};
use std::io::IsTerminal;
use std::time::{Duration, Instant};

/// Reports the events of a run on standard error.
pub struct Reporter {
    style: Style,
    begun: Instant,
    /// The next frame at the start of this process.
    first_frame: Option<u64>,
    last_step: Option<Progress>,
    last_line: Option<Instant>,
    /// The command that resumes the run.
    resume_command: String,
}

#[derive(Clone)]
enum Style {
    Quiet,
    Json,
    Lines,
    Bar(ProgressBar),
}

impl Style {
    fn say(&self, line: &str) {
        match self {
            Self::Bar(bar) => bar.println(line),
            Self::Lines => eprintln!("{line}"),
            Self::Quiet | Self::Json => {}
        }
    }
}

/// The part of the reporter in the watchdog's thread.
struct RemoteReporter {
    style: Style,
    resume_command: String,
}

impl RemoteObserver for RemoteReporter {
    fn notify(&self, event: &Event) {
        match &self.style {
            Style::Json => json(event),
            style => style.say(&long_step(event)),
        }
    }

    fn abandon(&self, reason: &str) {
        match &self.style {
            Style::Json => eprintln!("{}", serde_json::json!({ "event": "end", "reason": reason })),
            _ => eprintln!("{reason}. Resume with:\n  {}", self.resume_command),
        }
        std::process::exit(STOPPED.into());
    }
}

fn json(event: &Event) {
    if let Ok(line) = serde_json::to_string(event) {
        eprintln!("{line}");
    }
}

/// The message about a long step; empty for other events.
fn long_step(event: &Event) -> String {
    let Event::LongStep { step, seconds, median, dt_before, phase } = event else { return String::new() };
    let median = median.map_or_else(String::new, |m| format!(" (median {m:.3} s)"));
    format!(
        "time step {step} has taken {} of wall time so far{median}; length of the previous step {dt_before:.1e} s; phase: {phase}",
        format_wall_time(*seconds)
    )
}

/// Shortest time between plain lines, which limits the logs of long runs.
const MIN_LINE_INTERVAL: Duration = Duration::from_millis(500);

impl Reporter {
    /// A reporter for standard error. `resume_command` is the command that resumes the run.
    pub fn new(log: LogFormat, quiet: bool, resume_command: String) -> Self {
        let style = match log {
            LogFormat::Json => Style::Json,
            LogFormat::Text if quiet => Style::Quiet,
            LogFormat::Text if std::io::stderr().is_terminal() => Style::Bar(bar()),
            LogFormat::Text => Style::Lines,
        };
        Self {
            style,
            begun: Instant::now(),
            first_frame: None,
            last_step: None,
            last_line: None,
            resume_command,
        }
    }

    fn say(&self, line: &str) {
        self.style.say(line);
    }

    /// Seconds per frame and remaining seconds.
    fn pace(&self, now: &Progress) -> Option<(f64, f64)> {
        let done = now.frame.checked_sub(self.first_frame?).filter(|&n| n > 0)?;
        let per_frame = self.begun.elapsed().as_secs_f64() / done as f64;
        Some((per_frame, per_frame * (now.last_frame + 1).saturating_sub(now.frame) as f64))
    }

    fn line(&self, p: &Progress) -> String {
        let mut line = format!(
            "t {}  dt {:.1e} s  CFL {:.2}  {} it  volume error {:+.0e}",
            format_simulated_time(p.time, p.end),
            p.dt,
            p.cfl,
            p.iterations,
            p.volume_error
        );
        if let Some((per_frame, left)) = self.pace(p) {
            line += &format!("  {per_frame:.2} s/frame  ETA {}", format_wall_time(left));
        }
        line
    }

    fn text(&mut self, event: &Event) {
        match event {
            Event::Begin { scene, dimension, cells, folder, resumed_at, threads, .. } => {
                let cells: Vec<String> = cells.iter().map(usize::to_string).collect();
                let mut line = format!(
                    "{scene}: {dimension}D, {} cells, {threads} threads, into {}",
                    cells.join(" x "),
                    folder.display()
                );
                if let Some(time) = resumed_at {
                    line += &format!(", resumed at {}", self::format_simulated_time(*time, *time));
                }
                self.say(&line);
            }
            Event::Step(progress) => self.step(progress),
            Event::Frame { frame, .. } => self.frame(*frame),
            Event::LongStep { .. } => self.say(&long_step(event)),
            Event::Warning { message } => self.say(&format!("warning: {message}")),
            Event::Checkpoint { .. } => {}
            Event::End { .. } => {
                if let Style::Bar(bar) = &self.style {
                    bar.finish_and_clear();
                }
            }
        }
    }

    fn step(&mut self, progress: &Progress) {
        self.first_frame.get_or_insert(progress.frame);
        if let Style::Bar(bar) = &self.style {
            bar.set_length(1000);
            bar.set_position((1000.0 * progress.time / progress.end.max(f64::MIN_POSITIVE)) as u64);
            bar.set_prefix(format!("frame {}/{}", progress.frame, progress.last_frame));
            bar.set_message(self.line(progress));
        }
        self.last_step = Some(progress.clone());
    }

    fn frame(&mut self, frame: u64) {
        let Some(progress) = self.last_step.clone().filter(|_| matches!(self.style, Style::Lines)) else {
            return;
        };
        let due = self.last_line.is_none_or(|last| last.elapsed() >= MIN_LINE_INTERVAL);
        if due || frame == progress.last_frame {
            self.last_line = Some(Instant::now());
            let after = Progress { frame: frame + 1, ..progress.clone() };
            self.say(&format!("frame {frame}/{}  {}", progress.last_frame, self.line(&after)));
        }
    }
}

impl Observer for Reporter {
    fn notify(&mut self, event: &Event) {
        if matches!(self.style, Style::Json) {
            json(event);
        } else {
            self.text(event);
        }
    }

    fn remote(&self) -> Option<Box<dyn RemoteObserver>> {
        Some(Box::new(RemoteReporter {
            style: self.style.clone(),
            resume_command: self.resume_command.clone(),
        }))
    }
}

fn bar() -> ProgressBar {
    let bar = ProgressBar::new(1000);
    if let Ok(style) = ProgressStyle::with_template("{prefix} [{bar:24.cyan}] {wide_msg}") {
        bar.set_style(style.progress_chars("=> "));
    }
    bar
}

/// A simulated time in the unit that suits `size`.
pub fn format_simulated_time(seconds: f64, size: f64) -> String {
    if size < 1e-3 {
        format!("{:.2} us", seconds * 1e6)
    } else if size < 1.0 {
        format!("{:.2} ms", seconds * 1e3)
    } else {
        format!("{seconds:.3} s")
    }
}

/// A readable duration: `42 s`, `3 min 20 s`, `2 h 05 min`.
pub fn format_wall_time(seconds: f64) -> String {
    let s = seconds.max(0.0).round() as u64;
    match s {
        0..10 => format!("{:.1} s", seconds.max(0.0)),
        10..60 => format!("{s} s"),
        60..3600 => format!("{} min {:02} s", s / 60, s % 60),
        _ => format!("{} h {:02} min", s / 3600, s % 3600 / 60),
    }
}
