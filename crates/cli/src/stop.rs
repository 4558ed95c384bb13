//! Requests to stop: signals and the wall time.

use meniscus_scene::run::Stop;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Watches for requests to stop.
pub struct Watch {
    signal: Arc<AtomicBool>,
    until: Option<Instant>,
}

/// The signal that ends a process whose file grows beyond `ulimit -f`; ignored, so that the write fails instead.
#[cfg(unix)]
const FILE_TOO_LARGE: i32 = 25;

impl Watch {
    /// Begins to watch. A second Ctrl-C ends the process at once.
    pub fn begin(walltime: Option<Duration>) -> std::io::Result<Self> {
        let signal = Arc::new(AtomicBool::new(false));
        register(&signal)?;
        Ok(Self { signal, until: walltime.and_then(|w| Instant::now().checked_add(w)) })
    }

    /// The request, if there is one.
    pub fn request(&self) -> Option<Stop> {
        if self.signal.load(Ordering::Relaxed) {
            return Some(Stop::Signal);
        }
        self.until.filter(|&until| Instant::now() >= until).map(|_| Stop::Walltime)
    }
}

#[cfg(unix)]
fn register(signal: &Arc<AtomicBool>) -> std::io::Result<()> {
    use signal_hook::consts::{SIGINT, SIGTERM, SIGUSR1};
    for number in [SIGINT, SIGTERM] {
        signal_hook::flag::register_conditional_shutdown(number, 128 + number, Arc::clone(signal))?;
    }
    for number in [SIGINT, SIGTERM, SIGUSR1] {
        signal_hook::flag::register(number, Arc::clone(signal))?;
    }
    signal_hook::flag::register(FILE_TOO_LARGE, Arc::default())?;
    Ok(())
}

#[cfg(not(unix))]
fn register(signal: &Arc<AtomicBool>) -> std::io::Result<()> {
    signal_hook::flag::register(signal_hook::consts::SIGINT, Arc::clone(signal))?;
    Ok(())
}
