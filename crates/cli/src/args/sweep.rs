//! Arguments of `meniscus sweep`.

use super::run::SceneArgs;
use crate::values::{relative_tolerance, wall_time};
use clap::Args;
use std::path::PathBuf;
use std::time::Duration;

const SWEEP_HELP: &str = "\
Values of --vary (PATH and units as in --set):
  PATH=A:B:N            N values from A to B: tension.plate.contact_angle=\"60:120:3 deg\"
  PATH=V1,V2,…          a list: domain.dx=\"0.8,0.4 mm\"
  PATH=A:B              with --find: the range that is searched
Several --vary make all combinations of their values. SCENE may be the folder
of a sweep, which then goes on.

Examples (docs/sweep.md has more):
  meniscus sweep my.toml --vary tension.plate.contact_angle=60:120:3deg --jobs 2
  meniscus sweep my.toml --vary tension.plate.contact_angle=60:120:3deg --slurm
  meniscus sweep out/my-sweep --collect
  meniscus sweep my.toml --find floats.ball --vary solid.ball.density=1:4g/cm^3

The same command again goes on where it was stopped or killed. The exit status is
that of `meniscus run`, the gravest of all cases; with --find 0 if the value was
found.";

/// `meniscus sweep`.
#[derive(Debug, Args)]
#[command(after_help = SWEEP_HELP)]
pub struct SweepArgs {
    /// The scene, or the folder of a sweep.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Values of a parameter of the scene (repeatable).
    #[arg(long, value_name = "PATH=VALUES")]
    pub vary: Vec<String>,
    /// Folder of the cases. Default: out/NAME-sweep, with --find out/NAME-find.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Number of cases that run at the same time, each in a process of its own.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub jobs: u16,
    /// Threads of each case. Default: those of the machine, shared by the jobs. Results do not depend on it.
    #[arg(long, value_name = "N", env = "MENISCUS_THREADS", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Run only the case with this number, from 0, and end with its exit status.
    #[arg(long, value_name = "I", conflicts_with_all = ["slurm", "collect", "find"])]
    pub case: Option<usize>,
    /// Run nothing: write the cases, and a script that runs them as a Slurm array.
    #[arg(long, conflicts_with_all = ["collect", "find"])]
    pub slurm: bool,
    /// Run nothing: write table and page of the cases that have run.
    #[arg(long, conflicts_with = "find")]
    pub collect: bool,
    /// Name of an expectation of the scene, such as floats.ball: find the value at which it changes from met to missed.
    #[arg(long, value_name = "EXPECT")]
    pub find: Option<String>,
    /// With --find: relative width of the interval in which the value is. [default: 0.02]
    #[arg(long, value_name = "X", requires = "find", value_parser = relative_tolerance)]
    pub tolerance: Option<f64>,
    /// Choose the resolution with which all cases together take about this time, such as 2h, by the estimate of `meniscus check`.
    #[arg(long, value_name = "TIME", value_parser = wall_time, conflicts_with_all = ["quality", "collect", "case"])]
    pub budget: Option<Duration>,
    /// Stop with checkpoints after this wall time, such as 55m (exit status 75).
    #[arg(long, value_name = "TIME", value_parser = wall_time)]
    pub walltime: Option<Duration>,
    /// Report errors only.
    #[arg(long, short)]
    pub quiet: bool,
}
