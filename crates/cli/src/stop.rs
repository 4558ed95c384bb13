//! Requests to stop: signals and the wall time.

use meniscus_scene::run::Stop;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// Receives requests to stop.
pub struct StopMonitor {
    /// Signals so far.
    signals: Arc<AtomicUsize>,
    until: Option<Instant>,
}

/// SIGXFSZ, sent to a process whose file exceeds `ulimit -f`; it is ignored, so that the write fails instead.
#[cfg(unix)]
const FILE_TOO_LARGE: i32 = 25;

impl StopMonitor {
    /// Starts to listen. A first signal stops the run after the step, a second one within it, a third ends the process at once.
    pub fn begin(walltime: Option<Duration>) -> std::io::Result<Self> {
        let signals = Arc::new(AtomicUsize::new(0));
        register(&signals)?;
        Ok(Self { signals, until: walltime.and_then(|w| Instant::now().checked_add(w)) })
    }

    /// The request, if there is one.
    pub fn request(&self) -> Option<Stop> {
        match self.signals.load(Ordering::Relaxed) {
            0 => self.until.filter(|&until| Instant::now() >= until).map(|_| Stop::Walltime),
            1 => Some(Stop::Signal),
            _ => Some(Stop::AtOnce),
        }
    }
}

#[cfg(unix)]
fn register(signals: &Arc<AtomicUsize>) -> std::io::Result<()> {
    use signal_hook::consts::{SIGINT, SIGTERM, SIGUSR1};
    signal_hook::flag::register(FILE_TOO_LARGE, Arc::<AtomicBool>::default())?;
    let mut coming = signal_hook::iterator::Signals::new([SIGINT, SIGTERM, SIGUSR1])?;
    let signals = Arc::clone(signals);
    std::thread::Builder::new().name("signals".into()).spawn(move || {
        for number in coming.forever() {
            // SIGUSR1 counts as one request, however often it is sent.
            let before = if number == SIGUSR1 {
                signals.fetch_max(1, Ordering::Relaxed)
            } else {
                signals.fetch_add(1, Ordering::Relaxed)
            };
            if before >= 2 && number != SIGUSR1 {
                std::process::exit(128 + number);
            }
        }
    })?;
    Ok(())
}

#[cfg(not(unix))]
fn register(signals: &Arc<AtomicUsize>) -> std::io::Result<()> {
    use signal_hook::consts::SIGINT;
    signal_hook::flag::register_usize(SIGINT, Arc::clone(signals), 1)?;
    Ok(())
}
