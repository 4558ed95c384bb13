//! The folder of a sweep: its plan, the scenes of its cases, and the folders of their runs.

use super::vary::Vary;
use crate::failure::{Failure, OUTPUT, Result};
use meniscus_scene::file::{LoadOptions, Scene};
use meniscus_scene::output::atomic_file::{create_folder, write_atomically};
use serde::{Deserialize, Serialize};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Version of the plan's file.
const VERSION: u32 = 1;

/// Start of a line with a setting at the top of a case's scene.
const SET: &str = "# --set ";

/// The plan of a sweep: the scene and the values of its cases. It is the file `sweep.json` of the folder.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    version: u32,
    /// Name of the scene.
    pub name: String,
    /// The parameters with their values; with `find` one parameter with the ends of its range.
    pub vary: Vec<Vary>,
    /// The check of `[expect]` that a search is about.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub find: Option<String>,
}

impl Plan {
    /// A plan of this version.
    pub fn new(name: &str, vary: Vec<Vary>, find: Option<String>) -> Self {
        Self { version: VERSION, name: name.to_owned(), vary, find }
    }

    /// Values of the parameters of every case; the last parameter changes from case to case.
    pub fn cases(&self) -> Vec<Vec<String>> {
        self.vary.iter().fold(vec![Vec::new()], |cases, vary| {
            let with = |case: &Vec<String>| {
                let case = case.clone();
                vary.values.iter().map(move |value| [case.clone(), vec![value.clone()]].concat())
            };
            cases.iter().flat_map(with).collect()
        })
    }

    /// The settings of a case.
    pub fn sets(&self, values: &[String]) -> Vec<String> {
        self.vary.iter().zip(values).map(|(vary, value)| format!("{}={value}", vary.path)).collect()
    }
}

/// The folder of a sweep.
#[derive(Clone, Debug)]
pub struct SweepFolder {
    root: PathBuf,
}

impl SweepFolder {
    /// The folder at a path; nothing is read or written.
    pub fn at(root: &Path) -> Self {
        Self { root: root.to_path_buf() }
    }

    /// The folder itself.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// A file of the folder.
    pub fn file(&self, name: &str) -> PathBuf {
        self.root.join(name)
    }

    /// The scene of a case.
    pub fn scene(&self, case: usize) -> PathBuf {
        self.root.join(format!("case_{case:04}.toml"))
    }

    /// The output folder of a case.
    pub fn run(&self, case: usize) -> PathBuf {
        self.root.join(format!("case_{case:04}"))
    }

    /// What the program that runs a case says.
    pub fn log(&self, case: usize) -> PathBuf {
        self.root.join(format!("case_{case:04}.log"))
    }

    /// Whether there is a plan.
    pub fn holds_a_plan(&self) -> bool {
        self.file("sweep.json").is_file()
    }

    /// The plan.
    ///
    /// # Errors
    /// A failure of status 4 if it cannot be read.
    pub fn plan(&self) -> Result<Plan> {
        let path = self.file("sweep.json");
        let text = std::fs::read_to_string(&path).map_err(Failure::file("read", &path))?;
        let plan = serde_json::from_str(&text).ok().filter(|plan: &Plan| plan.version == VERSION);
        plan.ok_or_else(|| {
            Failure::new(OUTPUT, format!("`{}` is not the plan of a sweep of this version", path.display()))
        })
    }

    /// Writes the plan, unless it is there.
    ///
    /// # Errors
    /// A failure of status 4 if the folder has another one.
    pub fn keep_plan(&self, plan: &Plan) -> Result<()> {
        create_folder(&self.root)?;
        if self.holds_a_plan() {
            return if self.plan()? == *plan { Ok(()) } else { Err(self.other()) };
        }
        let text = serde_json::to_string_pretty(plan).unwrap_or_default() + "\n";
        Ok(write_atomically(&self.file("sweep.json"), |file| file.write_all(text.as_bytes()))?)
    }

    /// Writes the scene of a case behind its settings, unless it is there.
    ///
    /// # Errors
    /// A failure of status 4 if the folder has another one.
    pub fn keep_scene(&self, case: usize, sets: &[String], scene: &Scene) -> Result<()> {
        let sets: String = sets.iter().map(|set| format!("{SET}{set}\n")).collect();
        let (path, text) = (self.scene(case), sets + &scene.to_toml()?);
        match std::fs::read_to_string(&path) {
            Ok(old) if old == text => Ok(()),
            Ok(_) => Err(self.other()),
            Err(_) => Ok(write_atomically(&path, |file| file.write_all(text.as_bytes()))?),
        }
    }

    /// The scene of a case, as it was written.
    ///
    /// # Errors
    /// The error of the scene.
    pub fn load_scene(&self, case: usize) -> Result<Scene> {
        Ok(Scene::load(&self.scene(case), &LoadOptions::default())?)
    }

    /// Values of the parameters of all cases whose scenes are there, up to the first that is not.
    pub fn written_cases(&self, plan: &Plan) -> Vec<Vec<String>> {
        let sets = |case: usize| {
            let text = std::fs::read_to_string(self.scene(case)).ok()?;
            let lines = text.lines().map_while(|line| line.strip_prefix(SET));
            let value = |set: &str| set.split_once('=').map(|(_, value)| value.to_owned());
            let values: Vec<String> = lines.filter_map(value).collect();
            (values.len() == plan.vary.len()).then_some(values)
        };
        (0..).map_while(sets).collect()
    }

    fn other(&self) -> Failure {
        let message = format!("the folder `{}` contains another sweep", self.root.display());
        Failure::new(OUTPUT, message)
            .help("its scene or its values differ: choose another folder with --out DIR, or remove this one")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_parameter_changes_from_case_to_case() {
        let vary = ["a=1,2", "b=x,y,z"].map(|text| Vary::parse(text).unwrap()).to_vec();
        let plan = Plan::new("n", vary, None);
        let cases = plan.cases();
        assert_eq!(cases.len(), 6);
        assert_eq!(
            (plan.sets(&cases[0]), plan.sets(&cases[4])),
            (vec!["a=1".to_owned(), "b=x".into()], vec!["a=2".to_owned(), "b=y".into()],)
        );
    }
}
