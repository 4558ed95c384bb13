//! A session of a run in two or three dimensions.

use crate::frame::{Ledger, Snapshot};
use meniscus_numerics::Vector;
use meniscus_scene::build::AnySetup;
use meniscus_scene::output::Folder;
use meniscus_scene::output::frame::{FrameParts, NotFinite};
use meniscus_scene::output::summary::Summary;
use meniscus_scene::run::{
    self, Advance, Event, ExistingRun, Job, Observer, Opened, Outcome, RunError, Session, Stop,
};

/// A session of either dimension.
pub enum AnySession {
    /// Two dimensions.
    D2(Box<Session<2>>),
    /// Three dimensions.
    D3(Box<Session<3>>),
}

/// An acceleration as a function of time, s; none if it failed.
pub type Acceleration = Box<dyn FnMut(f64) -> Option<Vec<f64>> + Send>;

/// All optional parts of frames.
const ALL_PARTS: FrameParts = FrameParts { elements: true, fields: true };

/// An expression with the session of either dimension.
macro_rules! with_either {
    ($any:expr, $session:ident => $value:expr) => {
        match $any {
            AnySession::D2($session) => $value,
            AnySession::D3($session) => $value,
        }
    };
}

/// Collects warnings.
#[derive(Default)]
pub struct Warnings(pub Vec<String>);

impl Observer for Warnings {
    fn notify(&mut self, event: &Event) {
        if let Event::Warning { message } = event {
            self.0.push(message.clone());
        }
    }
}

impl AnySession {
    /// Opens a folder. The second value is the summary of a run that is complete already.
    pub fn open(
        setup: &AnySetup,
        job: &Job,
        folder: &Folder,
        existing: ExistingRun,
        warnings: &mut Warnings,
    ) -> Result<(Self, Option<Summary>), RunError> {
        match setup {
            AnySetup::D2(setup) => Ok(match run::open(setup, job, folder, existing, warnings)? {
                Opened::Session(session) => (Self::D2(session), None),
                Opened::AlreadyFinished(summary) => {
                    (Self::D2(Box::new(run::reopen(setup, job, folder, warnings)?)), Some(*summary))
                }
            }),
            AnySetup::D3(setup) => Ok(match run::open(setup, job, folder, existing, warnings)? {
                Opened::Session(session) => (Self::D3(session), None),
                Opened::AlreadyFinished(summary) => {
                    (Self::D3(Box::new(run::reopen(setup, job, folder, warnings)?)), Some(*summary))
                }
            }),
        }
    }

    /// See [`Session::begin`].
    pub fn begin(&mut self, warnings: &mut Warnings) -> Result<(), RunError> {
        with_either!(self, session => session.begin(warnings))
    }

    /// See [`Session::advance`].
    pub fn advance(
        &mut self,
        stop: &dyn Fn() -> Option<Stop>,
        warnings: &mut Warnings,
    ) -> Result<Advance, RunError> {
        with_either!(self, session => session.advance(stop, warnings))
    }

    /// See [`Session::end`].
    pub fn end(
        &mut self,
        left: Result<Advance, RunError>,
        warnings: &mut Warnings,
    ) -> Result<Outcome, RunError> {
        with_either!(self, session => session.end(left, warnings))
    }

    /// See [`Session::set_job`].
    pub fn set_job(&mut self, job: Job) -> Result<(), RunError> {
        with_either!(self, session => session.set_job(job))
    }

    /// See [`Session::sync_series`].
    pub fn sync_series(&mut self) -> Result<(), RunError> {
        with_either!(self, session => session.sync_series())
    }

    /// Time, s.
    pub fn time(&self) -> f64 {
        with_either!(self, session => session.simulation().state.time)
    }

    /// Number of steps done.
    pub fn steps(&self) -> u64 {
        with_either!(self, session => session.simulation().state.step)
    }

    /// Whether every frame of the job was reached.
    pub fn is_complete(&self) -> bool {
        with_either!(self, session => session.next_frame() > session.job().last_frame())
    }

    /// End of the job, s.
    pub fn end_time(&self) -> f64 {
        with_either!(self, session => session.job().schedule.end())
    }

    /// Time between frames of the job, s.
    pub fn job_frame_interval(&self) -> f64 {
        with_either!(self, session => session.job().frame_interval)
    }

    /// Number of the frame whose time is the present one.
    pub fn present_frame(&self) -> Option<u64> {
        with_either!(self, session => {
            let last = session.next_frame().checked_sub(1)?;
            let is_now = session.job().schedule.is_frame_time(session.simulation().state.time, last);
            is_now.then_some(last)
        })
    }

    /// The frame of the present state.
    pub fn snapshot(&mut self) -> Result<Snapshot, NotFinite> {
        let number = self.present_frame();
        with_either!(self, session => {
            let (content, simulation) = (session.frame(ALL_PARTS)?, session.simulation());
            let line = session.contact_line();
            let angle = |solid: usize| line.angle_statistics(u32::try_from(solid).ok()).map(|(mean, _)| mean);
            Ok(Snapshot {
                angles: (0..content.solids.len()).map(angle).collect(),
                content,
                number,
                step: Some(simulation.state.step),
                ledger: Some(Ledger::from(simulation.diagnostics())),
            })
        })
    }

    /// The summary of the present state.
    pub fn summary(&self) -> Summary {
        with_either!(self, session => session.present_summary())
    }

    /// Sets gravity before each step to that of a function at the time of its start; where it fails gravity stays.
    pub fn set_gravity(&mut self, mut of: Acceleration) {
        with_either!(self, session => session.before_each_step(Box::new(move |simulation| {
            if let Some(g) = of(simulation.state.time) {
                simulation.set_gravity(Vector::from_fn(|a, _| g.get(a).copied().unwrap_or(0.0)));
            }
        })))
    }
}
