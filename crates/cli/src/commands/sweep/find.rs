//! `meniscus sweep --find`: the value of a parameter at which a check changes from met to missed.
//!
//! Bisection: of an interval at whose ends the check has different outcomes the half is kept for which that is so, until its width is at
//! most the tolerance times the larger of the ends. Every value is a case of its own; one that is finished is not run again, so a
//! search that was killed goes on. Limit: one change in the range is found, even if there are more.

use super::outcome::Outcome;
use super::plan::{Plan, SweepFolder};
use super::runner::{Ended, Runner};
use super::vary::{Interval, Vary, find_check, rounded};
use crate::commands::{print, save};
use crate::failure::{Failure, MISSED, Result, STOPPED, USAGE};
use crate::scenes;
use meniscus_scene::expect;
use meniscus_scene::file::Scene;
use serde_json::json;

/// Most halvings of the range.
const MAX_HALVINGS: usize = 40;

/// The search for the value of a parameter at which a check changes.
pub struct Search<'a> {
    /// The range.
    pub interval: Interval,
    /// Name of the check.
    pub check: String,
    /// Relative width of the interval at the end.
    pub tolerance: f64,
    /// Loads the scene with a setting.
    pub load: &'a dyn Fn(&str) -> Result<Scene>,
}

/// How a check came out at a value.
struct Probe {
    value: f64,
    met: bool,
    measured: Option<f64>,
}

impl Search<'_> {
    /// The plan of the search.
    pub fn plan(&self, name: &str) -> Plan {
        let Interval { path, from, to, .. } = &self.interval;
        let values = [*from, *to].map(|value| self.interval.text(value)).to_vec();
        Plan::new(name, vec![Vary { path: path.clone(), values }], Some(self.check.clone()))
    }

    /// Checks the scene at the ends of the range and between them, before anything runs.
    ///
    /// # Errors
    /// A failure of status 2 if the scene has no such check, or the error of the scene.
    pub fn check_ends(&self) -> Result<()> {
        let Interval { from, to, .. } = self.interval;
        [from, to, rounded(0.5 * (from + to))].iter().try_for_each(|value| self.scene(*value).map(drop))
    }

    /// Searches; returns the exit status. `tell` is called with each case that has ended.
    ///
    /// # Errors
    /// A failure of status 6 if the check does not change between the ends, that of a case that fails otherwise.
    pub fn run(
        &self,
        folder: &SweepFolder,
        runner: &Runner<'_>,
        tell: &mut dyn FnMut(&Ended, &str),
    ) -> Result<u8> {
        let Interval { from, to, .. } = self.interval;
        let mut probes: Vec<Probe> = Vec::new();
        let mut values = vec![from, to];
        loop {
            let done = probes.len();
            for (case, value) in values.iter().enumerate().skip(done) {
                folder.keep_scene(case, &[self.setting(*value)], &self.scene(*value)?)?;
            }
            let new: Vec<usize> = (done..values.len()).collect();
            let ended = runner.run(&new, &mut |end| tell(end, &self.setting(values[end.case])))?;
            if let Some(status) = unfinished(&ended) {
                return Ok(status);
            }
            for case in new {
                probes.push(self.probe(folder, case, values[case])?);
            }
            let [met, missed] = self.bracket(&probes)?;
            let width = (met.value - missed.value).abs();
            let is_narrow = width <= self.tolerance * met.value.abs().max(missed.value.abs());
            let middle = rounded(0.5 * (met.value + missed.value));
            if is_narrow || values.len() >= MAX_HALVINGS + 2 || middle == met.value || middle == missed.value
            {
                self.report(folder, met, missed, &probes)?;
                return Ok(0);
            }
            values.push(middle);
        }
    }

    fn setting(&self, value: f64) -> String {
        format!("{}={}", self.interval.path, self.interval.text(value))
    }

    fn scene(&self, value: f64) -> Result<Scene> {
        let scene = (self.load)(&self.setting(value))?;
        scenes::check_runnable(&scene)?;
        self.place(&scene)?;
        Ok(scene)
    }

    /// The place of the check among those of a scene.
    fn place(&self, scene: &Scene) -> Result<usize> {
        let found = find_check(&expect::names(&scene.expect), &self.check);
        found.map_err(|(message, help)| Failure::new(USAGE, message).help(help))
    }

    fn probe(&self, folder: &SweepFolder, case: usize, value: f64) -> Result<Probe> {
        let place = self.place(&folder.load_scene(case)?)?;
        let outcome = Outcome::read(folder, case)?;
        let check = outcome.as_ref().and_then(|outcome| outcome.checks.get(place));
        let (_, verdict) = check.ok_or_else(|| Failure::new(1, format!("case {case} has no outcome")))?;
        Ok(Probe { value, met: verdict.pass, measured: verdict.value })
    }

    /// The values next to the change, where the check is met and where it is missed.
    fn bracket<'p>(&self, probes: &'p [Probe]) -> Result<[&'p Probe; 2]> {
        let [first, last] = [&probes[0], &probes[1]];
        if first.met == last.met {
            let outcome = if first.met { "met" } else { "missed" };
            let [from, to] = [first, last].map(|p| self.told(p));
            let message = format!("the check `{}` is {outcome} at both ends: {from}, {to}", self.check);
            return Err(Failure::new(MISSED, message).help("give a range in which it changes"));
        }
        // The range is halved, so the latest value of each outcome is the nearest.
        let latest = |met: bool| probes.iter().rev().find(|probe| probe.met == met);
        let found = latest(true).zip(latest(false)).map(|(met, missed)| [met, missed]);
        Ok(found.unwrap_or([first, last]))
    }

    /// A value and what was measured there.
    fn told(&self, probe: &Probe) -> String {
        let measured = probe.measured.map_or_else(|| "not measured".to_owned(), super::table::short);
        format!("{measured} at {}", self.interval.text(probe.value))
    }

    fn report(&self, folder: &SweepFolder, met: &Probe, missed: &Probe, probes: &[Probe]) -> Result<()> {
        let (threshold, half) = (0.5 * (met.value + missed.value), 0.5 * (met.value - missed.value).abs());
        let relative = 100.0 * half / threshold.abs();
        let Interval { path, unit, .. } = &self.interval;
        let text = |probe: &Probe| self.interval.text(probe.value);
        let told = format!(
            "threshold {path} = {} ± {} ({relative:.1} %): `{}` is met at {}, missed at {}",
            self.interval.text(super::vary::rounded_to(threshold, 6)),
            self.interval.text(super::vary::rounded_to(half, 2)),
            self.check,
            text(met),
            text(missed)
        );
        print(&format!("{told}\n"))?;
        let probe = |p: &Probe| json!({ "value": p.value, "met": p.met, "measured": p.measured });
        let document = json!({
            "result": told, "path": path, "unit": unit, "check": self.check, "met_at": met.value, "missed_at": missed.value,
            "threshold": threshold, "uncertainty": half, "tolerance": self.tolerance,
            "cases": probes.iter().map(probe).collect::<Vec<_>>(),
        });
        save(&folder.file("find.json"), &format!("{document:#}\n"))
    }
}

/// The sentence with the result of a search, if it has come to its end.
pub fn result(folder: &SweepFolder) -> Option<String> {
    let text = std::fs::read_to_string(folder.file("find.json")).ok()?;
    let document: serde_json::Value = serde_json::from_str(&text).ok()?;
    Some(document["result"].as_str()?.to_owned())
}

/// The exit status of cases of which one did not finish.
fn unfinished(ended: &[Ended]) -> Option<u8> {
    let failed = ended.iter().map(|end| end.status).filter(|status| ![0, MISSED].contains(status));
    failed.reduce(|worst, status| if worst == STOPPED { worst } else { status })
}
