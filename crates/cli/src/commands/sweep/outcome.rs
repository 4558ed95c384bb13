//! The outcome of a case of a sweep, read from its folder.

use super::plan::SweepFolder;
use crate::failure::{MISSED, Result};
use meniscus_scene::expect;
use meniscus_scene::file::Scene;
use meniscus_scene::output::Folder;
use meniscus_scene::output::summary::{FINISHED, Summary, Verdict};
use meniscus_scene::output::time_series::TimeSeries;

/// A finished case.
pub struct Outcome {
    /// Its summary.
    pub summary: Summary,
    /// Its checks by name: those of `[expect]`, and after them the invariants, whose name is their quantity.
    pub checks: Vec<(String, Verdict)>,
}

impl Outcome {
    /// The outcome of a case; `None` unless its run is finished. Checks are evaluated from the files of the run, since a run that was
    /// killed at its very end has not written them.
    ///
    /// # Errors
    /// A failure if a file of a finished run cannot be read.
    pub fn read(folder: &SweepFolder, case: usize) -> Result<Option<Self>> {
        let run = Folder::at(&folder.run(case));
        let Some(summary) = Summary::read(&run.summary()).ok().filter(|s| s.exit_reason == FINISHED) else {
            return Ok(None);
        };
        let scene = folder.load_scene(case)?;
        Self::of(&scene, &run, summary).map(Some)
    }

    fn of(scene: &Scene, run: &Folder, summary: Summary) -> Result<Self> {
        let verdicts = expect::evaluate(scene, &summary, &TimeSeries::read(&run.series())?);
        let names = expect::names(&scene.expect);
        let name = |i: usize, verdict: &Verdict| names.get(i).unwrap_or(&verdict.quantity).clone();
        let checks = verdicts.into_iter().enumerate().map(|(i, v)| (name(i, &v), v)).collect();
        Ok(Self { summary, checks })
    }

    /// Whether all checks are met.
    pub fn is_met(&self) -> bool {
        self.checks.iter().all(|(_, verdict)| verdict.pass)
    }

    /// The exit status of such a run.
    pub fn status(&self) -> u8 {
        if self.is_met() { 0 } else { MISSED }
    }
}
