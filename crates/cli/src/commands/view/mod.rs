//! `meniscus render`, `page` and `view`: runs as pictures, as a file, and in the browser.

mod pictures;
mod server;
mod source;

pub use self::pictures::{DEFAULT_PAGE_MB, describe, make_page, page, pictures, render};

use self::server::Server;
use self::source::Source;
use super::print;
use crate::args::ViewArgs;
use crate::failure::{Failure, Result};
use crate::stop::StopMonitor;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// Time between looks at the files.
const LOOK: Duration = Duration::from_millis(400);

/// Shows a scene before its run, or a run, in the browser until a signal comes.
pub fn view(args: &ViewArgs) -> Result {
    let watch = StopMonitor::begin(None)
        .map_err(|e| Failure::new(1, format!("cannot install the signal handlers: {e}")))?;
    let mut source = Source::new(args)?;
    let shown = Mutex::new(source.shown());
    let server = Server::open(args.port)?;
    print(&format!("{}\nCtrl-C ends the server.\n", server.address()))?;
    std::thread::scope(|scope| {
        for _ in 0..server::THREADS {
            scope.spawn(|| server.answer(&shown, &|| watch.request().is_some()));
        }
        while watch.request().is_none() {
            if source.look() {
                *shown.lock().unwrap_or_else(PoisonError::into_inner) = source.shown();
            }
            std::thread::sleep(LOOK);
        }
    });
    Ok(0)
}
