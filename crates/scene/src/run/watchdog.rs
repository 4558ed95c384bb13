//! Watches a step from another thread. A long step is reported with its phase, and a request to stop within a step is recorded in
//! `summary.json` even if the step never ends.

use super::event::Event;
use crate::job::Stop;
use crate::output::log::Log;
use crate::output::summary::Summary;
use crate::run::event::RemoteObserver;
use std::path::Path;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// When a step is long, and how long a request to stop waits for its end.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// Shortest duration of a long step.
    pub min_long_step: Duration,
    /// The same while fewer than [`MIN_STEPS_FOR_MEDIAN`] durations are known.
    pub min_long_first_step: Duration,
    /// Time from a request to stop to the end of the process within a step that takes over twice the median.
    pub grace: Duration,
    /// Time between two polls.
    pub poll_interval: Duration,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            min_long_step: Duration::from_secs(5),
            min_long_first_step: Duration::from_secs(60),
            grace: Duration::from_secs(5),
            poll_interval: Duration::from_millis(100),
        }
    }
}

/// A step is long if it takes more than this multiple of the median.
const LONG_STEP_FACTOR: u32 = 50;
/// Fewest steps for a median.
const MIN_STEPS_FOR_MEDIAN: usize = 5;
/// Number of steps in the median.
const MEDIAN_WINDOW_STEPS: usize = 1001;

/// Progress of the present step.
#[derive(Default)]
struct StepProgress {
    /// Number of the step and its start; none between steps.
    step: Option<(u64, Instant)>,
    /// Length of the previous step, s.
    dt: f64,
    /// Phases that have ended in this step, and those of the previous step, which tell the one at work.
    phases: Vec<&'static str>,
    previous_phases: Vec<&'static str>,
    /// Durations of the last steps.
    durations: Vec<Duration>,
    done: bool,
}

impl StepProgress {
    fn median(&self) -> Option<Duration> {
        let mut sorted = self.durations.clone();
        sorted.sort_unstable();
        (sorted.len() >= MIN_STEPS_FOR_MEDIAN).then(|| sorted[sorted.len() / 2])
    }

    /// If a step of this duration is long, the median, if known.
    fn is_long(&self, taken: Duration, limits: &Limits) -> Option<Option<Duration>> {
        if taken < limits.min_long_step {
            return None;
        }
        let median = self.median();
        median
            .map_or(taken >= limits.min_long_first_step, |median| taken > LONG_STEP_FACTOR * median)
            .then_some(median)
    }

    /// The phase at work, inferred from the previous step.
    fn phase(&self) -> String {
        let ended = self.phases.len();
        let same = self.previous_phases.get(..ended).is_some_and(|before| before == self.phases);
        match (self.previous_phases.get(ended).filter(|_| same), self.phases.last()) {
            (Some(next), _) => (*next).to_owned(),
            (None, Some(last)) => format!("after {last}"),
            (None, None) => "the first phase".to_owned(),
        }
    }
}

/// The watchdog of a run.
pub(super) struct Watchdog {
    progress: Mutex<StepProgress>,
    wake_up: Condvar,
    limits: Limits,
}

/// Ends the watch when it is dropped, also if the run panics.
pub(super) struct FinishOnDrop<'a>(pub &'a Watchdog);

impl Drop for FinishOnDrop<'_> {
    fn drop(&mut self) {
        self.0.lock().done = true;
        self.0.wake_up.notify_all();
    }
}

impl Watchdog {
    pub fn new(limits: Limits) -> Self {
        Self { progress: Mutex::default(), wake_up: Condvar::new(), limits }
    }

    fn lock(&self) -> MutexGuard<'_, StepProgress> {
        self.progress.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Marks the start of a step.
    pub fn begin(&self, step: u64) {
        let mut pulse = self.lock();
        pulse.previous_phases = std::mem::take(&mut pulse.phases);
        pulse.step = Some((step, Instant::now()));
    }

    /// Marks the end of a phase.
    pub fn phase_end(&self, name: &'static str) {
        self.lock().phases.push(name);
    }

    /// Marks the end of a step of length `dt` (s). Returns a message if it took long.
    pub fn end(&self, dt: f64) -> Option<String> {
        let mut pulse = self.lock();
        let (step, began) = pulse.step.take()?;
        let taken = began.elapsed();
        let long = pulse.is_long(taken, &self.limits);
        pulse.dt = dt;
        if pulse.durations.len() == MEDIAN_WINDOW_STEPS {
            pulse.durations.remove(0);
        }
        pulse.durations.push(taken);
        long.map(|median| {
            let median = median.map_or_else(String::new, |m| format!(" (median {:.3} s)", m.as_secs_f64()));
            format!("time step {step} ({dt:.1e} s) took {:.1} s of wall time{median}", taken.as_secs_f64())
        })
    }

    /// Watches until the run ends.
    pub fn watch(
        &self,
        stop: &(dyn Fn() -> Option<Stop> + Sync),
        remote: &dyn RemoteObserver,
        mut log: Option<Log>,
        summary: &Path,
    ) {
        let (mut told, mut asked): ((u64, Duration), Option<(u64, Instant)>) = Default::default();
        let mut pulse = self.lock();
        while !pulse.done {
            let waited = self.wake_up.wait_timeout(pulse, self.limits.poll_interval);
            pulse = waited.unwrap_or_else(PoisonError::into_inner).0;
            let Some((step, began)) = pulse.step.filter(|_| !pulse.done) else { continue };
            let taken = began.elapsed();
            // Reported once the step is long, and again whenever its duration has doubled.
            if (told.0 != step || taken >= 2 * told.1)
                && let Some(median) = pulse.is_long(taken, &self.limits)
            {
                told = (step, taken);
                let seconds = taken.as_secs_f64();
                let median = median.map(|m| m.as_secs_f64());
                let event =
                    Event::LongStep { step, seconds, median, dt_before: pulse.dt, phase: pulse.phase() };
                remote.notify(&event);
                write_log(&mut log, &event);
            }
            let Some(stop) = stop() else { continue };
            let reason = format!(
                "{}, within step {step}; the saved state is that of the last checkpoint",
                stop.reason()
            );
            let first = *asked.get_or_insert_with(|| {
                // The lock is held meanwhile, so that the step cannot end and write the summary.
                write_exit_reason(summary, &reason);
                (step, Instant::now())
            });
            let stuck = taken > 2 * pulse.median().unwrap_or_default();
            if stop == Stop::AtOnce || first.1.elapsed() >= self.limits.grace && stuck && first.0 == step {
                write_exit_reason(summary, &reason);
                write_log(&mut log, &Event::Warning { message: reason.clone() });
                remote.abandon(&reason);
                return;
            }
        }
    }
}

fn write_log(log: &mut Option<Log>, event: &Event) {
    if let Some(log) = log {
        // A log that cannot be written is an error at the end of the step; here it is ignored.
        let _ = log.write(&serde_json::to_value(event).unwrap_or_default());
    }
}

/// Writes the exit reason into the summary, which otherwise is that of the last checkpoint.
fn write_exit_reason(path: &Path, reason: &str) {
    if let Ok(mut summary) = Summary::read(path) {
        summary.exit_reason = reason.to_owned();
        // A summary that cannot be written stays as it was; the process ends anyway.
        let _ = summary.write(path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::event::RemoteObserver;
    use std::sync::Arc;

    #[derive(Clone, Default)]
    struct Record(Arc<Mutex<Vec<String>>>);

    impl RemoteObserver for Record {
        fn notify(&self, event: &Event) {
            self.0.lock().unwrap().push(serde_json::to_string(event).unwrap());
        }

        fn abandon(&self, reason: &str) {
            self.0.lock().unwrap().push(reason.to_owned());
        }
    }

    const QUICK: Limits = Limits {
        min_long_step: Duration::from_millis(40),
        min_long_first_step: Duration::from_secs(9),
        grace: Duration::from_millis(60),
        poll_interval: Duration::from_millis(5),
    };

    /// The events and the summary of five short steps and a long one of 400 ms.
    fn watched(
        stop: &(dyn Fn() -> Option<Stop> + Sync),
        name: &str,
    ) -> (Vec<String>, String, Option<String>) {
        let path = std::env::temp_dir().join(format!("meniscus-watchdog-{name}-{}.json", std::process::id()));
        let (dog, record) = (Watchdog::new(QUICK), Record::default());
        crate::output::summary::tests::empty().write(&path).unwrap();
        let long = std::thread::scope(|scope| {
            let _finish = FinishOnDrop(&dog);
            let remote = record.clone();
            scope.spawn(|| {
                let remote = remote;
                dog.watch(stop, &remote, None, &path);
            });
            for step in 1..=6 {
                dog.begin(step);
                dog.phase_end("surface");
                if step == 6 {
                    std::thread::sleep(Duration::from_millis(400));
                }
                dog.phase_end("pressure");
                if let Some(long) = dog.end(1e-4) {
                    return Some(long);
                }
            }
            None
        });
        let reason = Summary::read(&path).unwrap().exit_reason;
        let _ = std::fs::remove_file(&path);
        let said = record.0.lock().unwrap().clone();
        (said, reason, long)
    }

    #[test]
    fn a_long_step_says_what_it_does() {
        let (said, reason, long) = watched(&|| None, "long");
        assert!(said[0].contains("\"step\":6") && said[0].contains("\"phase\":\"pressure\""), "{said:?}");
        assert!(said.len() < 8 && reason == "running", "{said:?} {reason}");
        assert!(long.is_some_and(|l| l.contains("time step 6 (1.0e-4 s) took")));
    }

    #[test]
    fn a_request_to_stop_within_a_step_leaves_its_reason() {
        for (stop, name) in [(Stop::Signal, "signal"), (Stop::Walltime, "walltime"), (Stop::AtOnce, "again")]
        {
            let (said, reason, _) = watched(&|| Some(stop), name);
            let word = if name == "walltime" {
                "stopped: walltime, within step"
            } else {
                "stopped: signal, within step"
            };
            assert!(reason.starts_with(word), "{reason}");
            assert!(said.last().is_some_and(|last| *last == reason), "{said:?} {reason}");
        }
    }
}
