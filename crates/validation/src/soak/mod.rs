//! The soak: random small scenes under invariants.
//!
//! A case is a scene that a seed and a number name (`draw/`), a scene file like any other, and is run as `meniscus run` would,
//! in a process of its own, step by step under the invariants of [`judge::invariants`]. What breaks one is written with the
//! checkpoint before it.

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

/// What a case is drawn from; the same wish and number give the same scene.
#[derive(Clone, Debug, PartialEq)]
pub struct CaseOptions {
    /// The set.
    pub set: CaseSet,
    /// The seed.
    pub seed: u64,
    /// 2 or 3; either without it.
    pub dimension: Option<usize>,
    /// The class; any without it.
    pub class: Option<Class>,
    /// Small and short scenes.
    pub quick: bool,
}

/// Sets of scenes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CaseSet {
    /// Random ones from the whole grammar.
    Random,
    /// The drop test (`drops.rs`): soft solids that fall, under the energy law of every step as well.
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

/// Classes of scenes, after the solids in them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Class {
    /// Liquid alone.
    Liquid,
    /// Rigid solids.
    Rigid,
    /// At least one solid that deforms.
    Soft,
}

impl Class {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Liquid, Self::Rigid, Self::Soft];

    /// That of a scene.
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

/// A scene to run under the invariants.
#[derive(Clone, Debug, PartialEq)]
pub enum Subject {
    /// A drawn one.
    Case(CaseOptions, u64),
    /// A scene file, under the invariants of a set.
    File(PathBuf, CaseSet),
}

impl Subject {
    /// The set whose invariants hold for it.
    pub fn set(&self) -> CaseSet {
        match self {
            Self::Case(wish, _) => wish.set,
            Self::File(_, set) => *set,
        }
    }
}

/// An invariant that a run broke.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Violation {
    /// Name of the invariant.
    pub kind: String,
    /// The step that broke it.
    pub step: u64,
    /// Simulated time, s.
    pub time: f64,
    /// What was found.
    pub value: f64,
    /// The worst that was found until the end of the run.
    pub worst: f64,
    /// What is allowed.
    pub bar: f64,
    /// More in words.
    pub words: String,
}

impl Violation {
    /// One of which there are only words.
    pub fn described(kind: &str, step: u64, time: f64, words: String) -> Self {
        Self { kind: kind.into(), step, time, value: 0.0, worst: 0.0, bar: 0.0, words }
    }
}

/// How the energy went from step to step.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EnergyLaw {
    /// Steps that were compared with the one before.
    pub steps: u64,
    /// Those in which the energy rose by more than is allowed.
    pub rises: u64,
    /// Sum of these rises over the scale of the energy.
    pub sum: f64,
    /// The largest rise in a step over the scale.
    pub largest: f64,
    /// The step of it.
    pub step: u64,
    /// Its time, s.
    pub time: f64,
    /// What each kind of energy changed by in it, over the scale: kinetic, elastic, of barriers, of the surface, of gravity.
    pub terms: [f64; 5],
}

impl EnergyLaw {
    /// The largest rise with what it is made of, in words.
    pub fn words(&self) -> String {
        let terms: Vec<String> = judge::energy::ENERGY_TERMS
            .iter()
            .zip(self.terms)
            .map(|(name, change)| format!("{name} {change:+.2e}"))
            .collect();
        format!(
            "in {} of {} steps, by {:.2e} together; the largest: {}",
            self.rises,
            self.steps,
            self.sum,
            terms.join(", ")
        )
    }
}

/// What came of a case.
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
    /// What the solids are, in words.
    pub solids: Vec<String>,
    /// Why earlier draws of the case were refused.
    pub refused: Vec<String>,
    /// Steps done.
    pub steps: u64,
    /// Simulated time, s.
    pub time: f64,
    /// Processor time of the run, s.
    pub seconds: f64,
    /// The longest step, s.
    pub slowest_step: f64,
    /// The step that half of all are shorter than, s.
    pub median_step: f64,
    /// Peak memory, bytes, where it can be told.
    pub memory: Option<u64>,
    /// What the run was repeated for, if it was.
    pub repeated: Option<String>,
    /// Why it was ended early without breaking anything.
    pub cut: Option<String>,
    /// How the energy went from step to step, in a set where that must hold.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub energy_law: Option<EnergyLaw>,
    /// The first violation of every kind, in the order in which they appeared.
    pub violations: Vec<Violation>,
}

impl Outcome {
    /// That of a scene that has not begun.
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
