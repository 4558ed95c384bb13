//! Long work beside Python: its other threads go on meanwhile, and Ctrl-C is a request to stop.

use pyo3::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

/// Time between looks for signals.
const LOOK: Duration = Duration::from_millis(50);

/// What work came to, and the exception of the signal that came meanwhile.
pub struct Interrupted<T> {
    /// The result.
    pub value: T,
    /// The exception.
    pub error: Option<PyErr>,
}

/// Does work in another thread. It gets a function that tells whether a signal asked to stop.
///
/// Handlers of signals run in Python's main thread only: in other ones nothing ever asks to stop.
pub fn wait<T: Send>(
    py: Python<'_>,
    work: impl FnOnce(&(dyn Fn() -> bool + Sync)) -> T + Send,
) -> Interrupted<T> {
    let (stop, mut error) = (AtomicBool::new(false), None);
    let value = py.detach(|| {
        std::thread::scope(|scope| {
            let (done, is_done) = channel();
            let asked = || stop.load(Ordering::Relaxed);
            let working = scope.spawn(move || {
                let value = work(&asked);
                // The receiver waits until this comes or the thread panics.
                let _ = done.send(());
                value
            });
            while is_done.recv_timeout(LOOK) == Err(RecvTimeoutError::Timeout) {
                if let Err(new) = Python::attach(|py| py.check_signals()) {
                    error.get_or_insert(new);
                    stop.store(true, Ordering::Relaxed);
                }
            }
            working.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
        })
    });
    Interrupted { value, error }
}
