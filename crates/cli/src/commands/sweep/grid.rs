//! A sweep over all combinations of values: its folder, its cases, and their table.

use super::plan::{Plan, SweepFolder};
use super::table::Table;
use super::vary::Vary;
use super::{find, page};
use crate::args::SceneArgs;
use crate::commands::save;
use crate::failure::{Failure, Result, USAGE};
use crate::scenes;
use std::path::{Path, PathBuf};

/// Most cases of a sweep.
const MAX_CASES: usize = 10_000;

/// The file of the table.
pub(super) const TABLE: &str = "sweep.csv";
/// The file of the page.
pub(super) const PAGE: &str = "index.html";

/// A sweep whose plan and scenes are written.
pub struct Sweep {
    folder: SweepFolder,
    plan: Plan,
}

impl Sweep {
    /// Checks the scenes of all combinations of values, then writes them and the plan into the folder `out`, by default
    /// `out/NAME-sweep`. A folder that holds the same sweep is left as it is.
    ///
    /// # Errors
    /// A failure of status 2 for wrong values, 3 for a wrong scene, 4 if the folder holds another sweep or cannot be written.
    pub fn new(scene: &SceneArgs, vary: Vec<Vary>, out: Option<&Path>) -> Result<Self> {
        check(&vary)?;
        let name = scenes::load(scene, &[])?.scene.name;
        let folder = out.map_or_else(|| Path::new("out").join(format!("{name}-sweep")), PathBuf::from);
        let (folder, plan) = (SweepFolder::at(&folder), Plan::new(&name, vary, None));
        let mut loaded = Vec::new();
        for values in plan.cases() {
            let sets = plan.sets(&values);
            let scene = scenes::load(scene, &sets)?.scene;
            scenes::check_runnable(&scene)?;
            loaded.push((sets, scene));
        }
        folder.keep_plan(&plan)?;
        for (case, (sets, scene)) in loaded.iter().enumerate() {
            folder.keep_scene(case, sets, scene)?;
        }
        Ok(Self { folder, plan })
    }

    /// The folder.
    pub fn folder(&self) -> &SweepFolder {
        &self.folder
    }

    /// The plan.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Writes `sweep.csv` and `index.html`, and returns the table.
    ///
    /// # Errors
    /// A failure if a file cannot be read or written.
    pub fn collect(&self) -> Result<Table> {
        write_table(&self.folder, &self.plan, &self.plan.cases())
    }
}

/// Refuses a parameter that is given twice, and too many cases.
fn check(vary: &[Vary]) -> Result<()> {
    let usage = |message: String, help: &str| Err(Failure::new(USAGE, message).help(help));
    if let Some((_, twice)) =
        vary.iter().enumerate().find(|(i, v)| vary[..*i].iter().any(|w| w.path == v.path))
    {
        return usage(format!("`{}` is varied twice", twice.path), "give all its values in one --vary");
    }
    let count = vary.iter().try_fold(1usize, |n, v| n.checked_mul(v.values.len()));
    if count.is_none_or(|n| n > MAX_CASES) {
        return usage(format!("there are more than {MAX_CASES} cases"), "give fewer values");
    }
    Ok(())
}

/// Writes the table and the page of cases with these values.
pub(super) fn write_table(folder: &SweepFolder, plan: &Plan, cases: &[Vec<String>]) -> Result<Table> {
    let table = Table::of(folder, plan, cases)?;
    save(&folder.file(TABLE), &table.csv())?;
    let title = match &plan.find {
        Some(check) => format!("{}: where {check} changes", plan.name),
        None => format!("{}: {} cases", plan.name, cases.len()),
    };
    let mut notes: Vec<String> =
        plan.vary.iter().map(|vary| format!("{}: {}", vary.path, vary.values.join(", "))).collect();
    notes.extend(find::result(folder));
    save(&folder.file(PAGE), &page::page(folder, &title, &notes, &table))?;
    Ok(table)
}
