//! Runs cases of a sweep, each in a process of its own, so that none can end the others.
//!
//! Such a process is `meniscus run SCENE --resume`. A request to stop is handed on to all of them, once for each signal. A case that
//! another process still writes is waited for: after this program was killed, those that it had started go on to their end.

use super::outcome::Outcome;
use super::plan::SweepFolder;
use crate::failure::{Failure, MISSED, Result, STOPPED};
use crate::own_program;
use meniscus_scene::output::Folder;
use meniscus_scene::run::Stop;
use std::collections::{BTreeSet, VecDeque};
use std::ffi::OsString;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::Duration;

/// Time between looks at the processes.
const LOOK: Duration = Duration::from_millis(20);

/// How cases are run.
pub struct Runner<'a> {
    /// The folder of the sweep.
    pub folder: &'a SweepFolder,
    /// Number of processes at the same time.
    pub jobs: usize,
    /// Threads of each.
    pub threads: usize,
    /// Words that start this program (`own_program`).
    pub program: Vec<OsString>,
    /// Tells of a request to stop.
    pub stop: &'a dyn Fn() -> Option<Stop>,
}

/// How a case ended.
#[derive(Clone, Debug)]
pub struct Ended {
    /// Its number.
    pub case: usize,
    /// Its exit status, that of `meniscus run`.
    pub status: u8,
}

impl Ended {
    /// Whether the case has neither finished nor stopped on request.
    pub fn has_failed(&self) -> bool {
        ![0, MISSED, STOPPED].contains(&self.status)
    }
}

/// A process that runs a case.
struct Running {
    case: usize,
    process: Child,
    /// Requests to stop that it has got.
    told: usize,
}

impl Runner<'_> {
    /// Threads of each of so many processes at the same time, which share those of the machine.
    pub fn threads_of_each(jobs: usize) -> usize {
        let machine = std::thread::available_parallelism().map_or(1, usize::from);
        (machine / jobs.max(1)).max(1)
    }

    /// Runs these cases and calls `tell` with the end of each. Cases that are finished already are only told. After a request to stop no
    /// case is begun; those that run end with a checkpoint.
    ///
    /// # Errors
    /// A failure if no process can be started.
    pub fn run(&self, cases: &[usize], tell: &mut dyn FnMut(&Ended)) -> Result<Vec<Ended>> {
        let (mut waiting, mut running) = (VecDeque::from(cases.to_vec()), Vec::new());
        let (mut ended, mut warned): (Vec<Ended>, BTreeSet<usize>) = (Vec::new(), BTreeSet::new());
        while !(waiting.is_empty() && running.is_empty()) {
            let requests = self.requests();
            if requests > 0 {
                let stopped = waiting.drain(..).map(|case| Ended { case, status: STOPPED });
                ended.extend(stopped);
                running.iter_mut().for_each(|r| hand_on(r, requests));
            }
            for _ in 0..waiting.len() {
                if running.len() >= self.jobs {
                    break;
                }
                let Some(case) = waiting.pop_front() else { break };
                if let Some(outcome) = Outcome::read(self.folder, case)? {
                    close(&mut ended, Ended { case, status: outcome.status() }, tell);
                } else if self.is_busy(case) {
                    waiting.push_back(case);
                    if warned.insert(case) {
                        eprintln!("case {case} is still being written by another process: waiting for it");
                    }
                } else {
                    running.push(Running { case, process: self.start(case)?, told: 0 });
                }
            }
            for end in self.collect_ended(&mut running)? {
                // Another process may have locked the folder after the look at it.
                match end.has_failed() && self.is_busy(end.case) {
                    true => waiting.push_back(end.case),
                    false => close(&mut ended, end, tell),
                }
            }
            std::thread::sleep(LOOK);
        }
        ended.sort_by_key(|e| e.case);
        Ok(ended)
    }

    /// Number of requests to stop.
    fn requests(&self) -> usize {
        match (self.stop)() {
            None => 0,
            Some(Stop::AtOnce) => 2,
            Some(_) => 1,
        }
    }

    fn is_busy(&self, case: usize) -> bool {
        Folder::at(&self.folder.run(case)).is_busy()
    }

    fn start(&self, case: usize) -> Result<Child> {
        let log_path = self.folder.log(case);
        let log = std::fs::File::create(&log_path).map_err(Failure::file("write", &log_path))?;
        let other = log.try_clone().map_err(Failure::file("write", &log_path))?;
        let mut command = own_program::command(&self.program);
        command.arg("run").arg(self.folder.scene(case)).arg("--out").arg(self.folder.run(case));
        command.args(["--resume", "--quiet", "--threads", &self.threads.to_string()]);
        command.env("NO_COLOR", "1").stdin(Stdio::null()).stdout(log).stderr(other);
        // Ctrl-C goes to this program only, which hands it on.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        command.spawn().map_err(|e| Failure::new(1, format!("cannot start a process for case {case}: {e}")))
    }

    /// Takes the cases whose process has ended from those that run.
    fn collect_ended(&self, running: &mut Vec<Running>) -> Result<Vec<Ended>> {
        let (mut ended, mut at) = (Vec::new(), 0);
        while at < running.len() {
            match running[at].process.try_wait() {
                Ok(None) => at += 1,
                Ok(Some(status)) => {
                    let case = running.remove(at).case;
                    ended.push(Ended { case, status: self.status(case, status)? });
                }
                Err(e) => {
                    return Err(Failure::new(1, format!("cannot wait for case {}: {e}", running[at].case)));
                }
            }
        }
        Ok(ended)
    }

    /// The exit status of a case: that of its checks if it is finished, else that of its process; 1 if a signal ended it unasked.
    fn status(&self, case: usize, process: ExitStatus) -> Result<u8> {
        if let Some(outcome) = Outcome::read(self.folder, case)? {
            return Ok(outcome.status());
        }
        Ok(match process.code().map(u8::try_from) {
            // A process that has no handler of signals yet ends at once.
            None if self.requests() > 0 => STOPPED,
            None | Some(Ok(0) | Err(_)) => 1,
            Some(Ok(code)) => code,
        })
    }
}

fn close(ended: &mut Vec<Ended>, end: Ended, tell: &mut dyn FnMut(&Ended)) {
    tell(&end);
    ended.push(end);
}

/// Hands requests to stop on to a process that has not got them.
fn hand_on(running: &mut Running, requests: usize) {
    while running.told < requests {
        running.told += 1;
        terminate(&mut running.process);
    }
}

/// Asks a process to end with a checkpoint.
#[cfg(unix)]
fn terminate(process: &mut Child) {
    // The standard library can only kill; the shell's own `kill` is everywhere.
    let _ = Command::new("sh").arg("-c").arg(format!("kill -TERM {}", process.id())).status();
}

#[cfg(not(unix))]
fn terminate(process: &mut Child) {
    let _ = process.kill();
}
