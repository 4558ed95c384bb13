//! Arguments of the commands that read a scene.

use crate::values::{frame_range, wall_time};
use clap::{Args, ValueEnum};
use std::path::PathBuf;
use std::time::Duration;

/// Which scene, and what is changed in it.
#[derive(Clone, Debug, Args)]
pub struct SceneArgs {
    /// A .toml file, the name of a built-in scene, or the output folder of a run.
    #[arg(value_name = "SCENE")]
    pub scene: String,
    /// Change a value of the scene, such as --set domain.resolution=96 or --set tension.plate.contact_angle=60deg (repeatable);
    /// docs/scene.md lists the keys.
    #[arg(long, value_name = "PATH=VALUE")]
    pub set: Vec<String>,
    /// Resolution of the grid. Default: normal.
    #[arg(long, value_enum)]
    pub quality: Option<Quality>,
    /// Cells along the longest side, in place of a quality; a command chooses them.
    #[arg(skip)]
    pub cells: Option<u32>,
}

/// `meniscus run`.
#[derive(Clone, Debug, Args)]
pub struct RunArgs {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Output folder. Default: out/NAME, with the name of the scene.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Resume from the last checkpoint in the output folder.
    #[arg(long, conflicts_with = "force")]
    pub resume: bool,
    /// Simulate until this time, such as "0.5 s", instead of the scene's duration.
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    pub until: Option<String>,
    /// Write only the frames first:last, counted from 0, and end the run with the last of them.
    #[arg(long, value_name = "A:B", value_parser = frame_range)]
    pub frames: Option<(u64, u64)>,
    /// Number of threads. Default: all of the machine. Results do not depend on it.
    #[arg(long, value_name = "N", env = "MENISCUS_THREADS", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Stop with a checkpoint after this wall time, such as 55m (exit status 75).
    #[arg(long, value_name = "TIME", value_parser = wall_time)]
    pub walltime: Option<Duration>,
    /// Format of the progress reports.
    #[arg(long, value_enum, default_value_t = LogFormat::Text)]
    pub log: LogFormat,
    /// Report errors and missed expectations only.
    #[arg(long, short)]
    pub quiet: bool,
    /// Replace an earlier run in the output folder.
    #[arg(long)]
    pub force: bool,
}

/// How progress is reported.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum LogFormat {
    /// A bar on a terminal, lines elsewhere.
    Text,
    /// One JSON object per line.
    Json,
}

/// Resolution of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Quality {
    /// Coarse, for a quick look: domain.quality.draft of the scene, or half the resolution.
    Draft,
    /// The resolution given in the scene.
    Normal,
    /// domain.quality.paper of the scene: in scenes after a figure of the paper the resolution of that figure.
    Paper,
}

/// `meniscus check`.
#[derive(Debug, Args)]
pub struct CheckArgs {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
    /// Treat warnings as errors (exit status 3).
    #[arg(long)]
    pub strict: bool,
}
