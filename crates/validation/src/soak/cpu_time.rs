//! Processor time of processes; on a shared machine the wall clock includes the load of others.

use std::sync::OnceLock;
use std::time::Instant;

/// Ticks per second in `/proc`: `USER_HZ`, 100 on every Linux.
const TICKS_PER_SECOND: f64 = 100.0;

/// Processor time of all threads of this process so far, s; without `/proc` the time since the first call.
pub fn of_this_process() -> f64 {
    static START: OnceLock<Instant> = OnceLock::new();
    let start = START.get_or_init(Instant::now);
    read("self").unwrap_or_else(|| start.elapsed().as_secs_f64())
}

/// Processor time of another process, s; none if it is unknown.
pub fn of_process(process: u32) -> Option<f64> {
    read(&process.to_string())
}

fn read(process: &str) -> Option<f64> {
    let text = std::fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    // The program's name, in brackets, may contain any character.
    let (_, rest) = text.rsplit_once(')')?;
    let mut fields = rest.split_whitespace().skip(11);
    let ticks = fields.next()?.parse::<f64>().ok()? + fields.next()?.parse::<f64>().ok()?;
    Some(ticks / TICKS_PER_SECOND)
}
