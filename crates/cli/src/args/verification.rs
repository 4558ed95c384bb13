//! Arguments of the commands that test and time the program.

use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// `meniscus verify`.
#[derive(Debug, Args)]
pub struct VerifyArgs {
    /// Only these cases.
    pub names: Vec<String>,
    /// List the cases.
    #[arg(long)]
    pub list: bool,
    /// Coarse and short: minutes, not hours.
    #[arg(long)]
    pub quick: bool,
    /// Scheme of the simulations. That of the paper runs the cases that need nothing else.
    #[arg(long, value_enum, default_value_t = ChosenScheme::Meniscus)]
    pub scheme: ChosenScheme,
    /// Number of cases that run at the same time; they share the cores. Two small cases on one thread each take less time than one
    /// after the other on two.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..))]
    pub jobs: u16,
    /// Write the results as JSON. This file and those of --html and --markdown are written anew after each case.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Keep the results that the file of --json already has, and run the other cases. They must be of the same version; two programs of
    /// one version are told apart only if MENISCUS_COMMIT named the commit when they were compiled.
    #[arg(long, requires = "json")]
    pub resume: bool,
    /// Add a line for each case to this file, with its seconds, and the error and the bar of the check that is nearest to its bar.
    /// Lines of the same version are replaced. The pages of --html and --markdown draw the history.
    #[arg(long, value_name = "FILE")]
    pub history: Option<PathBuf>,
    /// Write the results as an HTML page.
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
    /// Write the results as a page of Markdown.
    #[arg(long, value_name = "FILE")]
    pub markdown: Option<PathBuf>,
}

/// A scheme of time steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ChosenScheme {
    /// The scheme of Meniscus.
    Meniscus,
    /// The seven steps of the paper, with its errata corrected.
    Paper,
}

/// `meniscus soak`.
#[derive(Debug, Args)]
pub struct SoakArgs {
    /// Seed of the random scenes: the same seed gives the same scenes.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Start no new scene after this number of hours.
    #[arg(long, value_name = "H")]
    pub hours: Option<f64>,
    /// Number of scenes. Default: 100, or no limit with --hours.
    #[arg(long, value_name = "N")]
    pub scenes: Option<u64>,
    /// Number of dimensions of the scenes. Default: four of five scenes are 2D.
    #[arg(long, value_parser = clap::value_parser!(u8).range(2..=3))]
    pub dimension: Option<u8>,
    /// Set of scenes. The drop test checks the energy in every step; it has 60 different scenes in 2D and 12 in 3D, and then repeats
    /// them with other values.
    #[arg(long, value_enum, default_value_t = Set::Random)]
    pub set: Set,
    /// Kind of solids in the scenes.
    #[arg(long, value_enum, default_value_t = Solids::Any)]
    pub solids: Solids,
    /// Use small and short scenes.
    #[arg(long)]
    pub quick: bool,
    /// Run only the scene with this number.
    #[arg(long, value_name = "I")]
    pub case: Option<u64>,
    /// Run only this scene file, and check the same invariants.
    #[arg(long, value_name = "FILE", conflicts_with = "case")]
    pub scene: Option<PathBuf>,
    /// With --case or --scene: remove from the scene what is not needed to violate the invariant.
    #[arg(long)]
    pub shrink: bool,
    /// With --shrink: name of the invariant. Default: the first one that is violated.
    #[arg(long, value_name = "INVARIANT")]
    pub kind: Option<String>,
    /// Folder for the scenes and checkpoints of violations.
    #[arg(long, value_name = "DIR", default_value = "out/soak")]
    pub out: PathBuf,
    /// Number of scenes run at the same time, each on one thread. Default: the number of cores.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub jobs: Option<u16>,
    /// File with known violations, which do not count: on each line the name of a scene and the violated invariants.
    #[arg(long, value_name = "FILE")]
    pub known: Option<PathBuf>,
    /// Write the results as JSON.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Run the case in this process, for the one that started it.
    #[arg(long, hide = true)]
    pub child: bool,
}

/// Sets of scenes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Set {
    /// Random scenes with all features of the scene format.
    Random,
    /// Soft solids that fall on wet ground.
    DropTest,
}

/// Solids in drawn scenes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Solids {
    /// No solids.
    None,
    /// Rigid solids only.
    Rigid,
    /// At least one deformable solid.
    Soft,
    /// Any solids or none.
    Any,
}

/// `meniscus bench`.
#[derive(Debug, Args)]
pub struct BenchArgs {
    /// Benchmarks to run: `pressure` solves, whole `step`s, `table1` of the paper, or `precision` (errors and cost of steps of several lengths). Without a name pressure and step run; the other two take long.
    pub names: Vec<String>,
    /// Small and short, to see that it works.
    #[arg(long)]
    pub quick: bool,
    /// With step: time this scene alone: drop, body, crown-splash or drop-large of the benchmark, else one of `meniscus scenes` or a file.
    #[arg(long, value_name = "SCENE")]
    pub scene: Vec<String>,
    /// With step: number of timed steps of each scene [default: 8, with --quick 3].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub steps: Option<u32>,
    /// With step: the work of each phase beside the bandwidth and the peak rate of the machine, on one thread and on all.
    #[arg(long)]
    pub roofline: bool,
    /// Number of threads. Default: all of the machine.
    #[arg(long, value_name = "N", env = "MENISCUS_THREADS")]
    pub threads: Option<u16>,
    /// Write the results as JSON.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// With precision alone: keep the runs that the file of --json already has, which must be of the same version, and make the others. The
    /// file is written anew after each run.
    #[arg(long, requires = "json")]
    pub resume: bool,
    /// With table1 or precision alone: print the tables as a page of Markdown, and the rows to standard error as they come.
    #[arg(long)]
    pub markdown: bool,
}
