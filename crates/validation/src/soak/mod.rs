//! The soak: random small scenes checked against invariants.
//!
//! A case is a scene generated from a seed and a number (`draw/`). It is a scene file like any other and runs as with `meniscus run`, in
//! its own process, checked at every step against the invariants of [`judge::invariants`]. A scene that breaks one is written with the
//! checkpoint before the violation.

mod cpu_time;
mod draw;
pub mod judge;
pub mod launcher;
pub mod report;
pub mod rerun;
mod run;
mod scheduled;
#[cfg(test)]
mod tests;

pub use judge::energy::EnergyMonitor;
pub use run::run;

use meniscus_scene::file::{Material, Scene};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Options of the random cases; the same options and number give the same scene.
#[derive(Clone, Debug, PartialEq)]
pub struct CaseOptions {
    /// The set of scenes.
    pub set: CaseSet,
    /// The seed.
    pub seed: u64,
    /// 2 or 3; both if none.
    pub dimension: Option<usize>,
    /// The class; any if none.
    pub class: Option<Class>,
    /// Small and short scenes.
    pub quick: bool,
}

/// Sets of scenes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CaseSet {
    /// Random scenes from the whole grammar.
    Random,
    /// The drop test (`draw/drop_test.rs`): falling deformable solids, also checked against the energy law of every step.
    DropTest,
}

impl CaseSet {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Random => "random",
            Self::DropTest => "drop-test",
        }
    }
}

/// Classes of scenes by their solids.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Class {
    /// Liquid alone.
    Liquid,
    /// Rigid solids.
    Rigid,
    /// At least one deformable solid.
    Soft,
}

impl Class {
    /// All classes.
    pub const ALL: [Self; 3] = [Self::Liquid, Self::Rigid, Self::Soft];

    /// The class of a scene.
    pub fn of(scene: &Scene) -> Self {
        match scene.solids.iter().any(|s| s.material.deforms()) {
            true => Self::Soft,
            false if scene.solids.is_empty() => Self::Liquid,
            false => Self::Rigid,
        }
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Liquid => "liquid",
            Self::Rigid => "rigid",
            Self::Soft => "soft",
        }
    }
}

/// A scene to check.
#[derive(Clone, Debug, PartialEq)]
pub enum Subject {
    /// A random case.
    Case(CaseOptions, u64),
    /// A scene file, checked against the invariants of a set.
    File(PathBuf, CaseSet),
}

impl Subject {
    /// The set whose invariants apply.
    pub fn set(&self) -> CaseSet {
        match self {
            Self::Case(wish, _) => wish.set,
            Self::File(_, set) => *set,
        }
    }
}

/// A violated invariant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Violation {
    /// Name of the invariant.
    pub kind: String,
    /// The step of the violation.
    pub step: u64,
    /// Simulated time, s.
    pub time: f64,
    /// The value found.
    pub value: f64,
    /// The worst value until the end of the run.
    pub worst: f64,
    /// The bound.
    pub bar: f64,
    /// Further description.
    pub words: String,
}

impl Violation {
    /// A violation with a description only.
    pub fn described(kind: &str, step: u64, time: f64, words: String) -> Self {
        Self { kind: kind.into(), step, time, value: 0.0, worst: 0.0, bar: 0.0, words }
    }
}

/// Statistics of the energy from step to step.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EnergyLaw {
    /// Steps that were compared with the previous one.
    pub steps: u64,
    /// Steps in which the energy rose by more than the bound.
    pub rises: u64,
    /// Sum of these rises over the scale of the energy.
    pub sum: f64,
    /// The largest rise in a step over the scale.
    pub largest: f64,
    /// The step of the largest rise.
    pub step: u64,
    /// Its time, s.
    pub time: f64,
    /// Changes of the kinds of energy in it, over the scale: kinetic, elastic, barriers, surface, gravity.
    pub terms: [f64; 5],
}

impl EnergyLaw {
    /// Description of the largest rise with its parts.
    pub fn words(&self) -> String {
        let terms: Vec<String> = judge::energy::ENERGY_TERMS
            .iter()
            .zip(self.terms)
            .map(|(name, change)| format!("{name} {change:+.2e}"))
            .collect();
        format!(
            "rises in {} of {} steps, {:.2e} in total; the largest rise: {}",
            self.rises,
            self.steps,
            self.sum,
            terms.join(", ")
        )
    }
}

/// Outcome of a case.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Name of the scene.
    pub name: String,
    /// Number of the case; 0 for a scene file.
    pub case: u64,
    /// 2 or 3.
    pub dimension: usize,
    /// The class of the scene.
    pub class: Class,
    /// Descriptions of the solids.
    pub solids: Vec<String>,
    /// Reasons why earlier attempts of the case were refused.
    pub refused: Vec<String>,
    /// Number of steps.
    pub steps: u64,
    /// Simulated time, s.
    pub time: f64,
    /// Processor time of the run, s.
    pub seconds: f64,
    /// The longest step, s.
    pub slowest_step: f64,
    /// Median duration of a step, s.
    pub median_step: f64,
    /// Peak memory, bytes, if known.
    pub memory: Option<u64>,
    /// Kind of the repetition, if the run was repeated.
    pub repeated: Option<String>,
    /// Why the run ended early without a violation.
    pub cut: Option<String>,
    /// The energy law, in a set where it must hold.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub energy_law: Option<EnergyLaw>,
    /// The first violation of every kind, in order of appearance.
    pub violations: Vec<Violation>,
}

impl Outcome {
    /// The outcome of a scene before its run.
    pub fn at_start(scene: &Scene, case: u64, refused: Vec<String>) -> Self {
        Self {
            name: scene.name.clone(),
            case,
            dimension: scene.domain.dimension,
            class: Class::of(scene),
            solids: scene
                .solids
                .iter()
                .map(|s| material(&s.material, s.fixed.len() + s.moved.len()).into())
                .collect(),
            refused,
            steps: 0,
            time: 0.0,
            seconds: 0.0,
            slowest_step: 0.0,
            median_step: 0.0,
            memory: None,
            repeated: None,
            cut: None,
            energy_law: None,
            violations: Vec::new(),
        }
    }
}

fn material(material: &Material, held: usize) -> &'static str {
    match (material, held) {
        (Material::Rigid { fixed: true }, _) => "fixed",
        (Material::Rigid { .. }, _) => "free",
        (Material::Kinematic { .. }, _) => "kinematic",
        (_, 0) => "soft free",
        _ => "soft held",
    }
}
