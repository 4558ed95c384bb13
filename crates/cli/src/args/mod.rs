//! The command line, parsed by `clap`.

mod output;
mod run;
mod sweep;
mod verification;

pub use output::{ExportArgs, MeasureArgs, PageArgs, RenderArgs, UpAxis, ViewArgs, Wetted};
pub use run::{CheckArgs, LogFormat, Quality, RunArgs, SceneArgs};
pub use sweep::SweepArgs;
pub use verification::{BenchArgs, ChosenScheme, Set, SoakArgs, Solids, VerifyArgs};

use clap::{Args, Parser, Subcommand};
use std::path::PathBuf;

const AFTER_HELP: &str = "\
Exit status: 0 done, 1 internal error, 2 wrong usage, 3 scene invalid, 4 input or output failed, \
5 the solver could not continue, 6 an expectation or validation check failed, 75 stopped on request (resumable).

First steps (SCENE may be a built-in name or a .toml file):
  meniscus scenes                                     list the built-in scenes
  meniscus run fig12-contact-angle-45-2d              run one (10 s); pictures and a page in out/
  meniscus measure out/fig12-contact-angle-45-2d      its contact angles, radii and heights
  meniscus new fig12-contact-angle-45-2d -o my.toml   write a copy to change, named `my`
  meniscus check my.toml                              check a scene without running it
  meniscus run my.toml --set tension.plate.contact_angle=60deg
  meniscus measure out/my
Many runs at once, or a threshold:  meniscus sweep --help";

/// Simulates liquids with surface tension in contact with rigid and deformable solids.
#[derive(Debug, Parser)]
#[command(name = "meniscus", version, after_help = AFTER_HELP, max_term_width = 110)]
#[command(arg_required_else_help = true)]
pub struct Cli {
    /// The command that runs.
    #[command(subcommand)]
    pub command: Command,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Simulate a scene: a .toml file, the name of a built-in scene, or the output folder of an earlier run.
    Run(RunArgs),
    /// List the built-in scenes.
    Scenes(ScenesArgs),
    /// Write a commented scene file to start from.
    New(NewArgs),
    /// Check a scene without running it: its grid, dimensionless numbers, estimated cost, warnings.
    Check(CheckArgs),
    /// Measure contact angles, base radii, heights, wetted areas and contact times in stored frames.
    Measure(MeasureArgs),
    /// Run the validation suite, which compares results with theory, experiments and other programs.
    Verify(VerifyArgs),
    /// Run small random scenes and check invariants; scenes that violate one are written with the checkpoint before.
    Soak(SoakArgs),
    /// Measure the time that pressure solves and time steps take, and the errors of long steps.
    Bench(BenchArgs),
    /// Write a self-contained HTML page of a run.
    Page(PageArgs),
    /// Show a scene before its run, or a run while it goes on, in the browser; the scene is read again as its file is saved.
    View(ViewArgs),
    /// Render pictures of a run, and a film if ffmpeg is installed.
    Render(RenderArgs),
    /// Run a scene with many values of its parameters, or find the value at which a check of it changes.
    Sweep(SweepArgs),
    /// Convert the stored frames of a run to another format, for ParaView, Blender and other programs.
    Export(ExportArgs),
    /// Print the JSON Schema of scene files, for editors (see docs/scene.md).
    Schema(SchemaArgs),
    /// Print version, build and machine.
    Info(JsonFlag),
    /// Print completions for a shell.
    Completions {
        /// Name of the shell.
        shell: clap_complete::Shell,
    },
}

/// `meniscus schema`.
#[derive(Debug, Args)]
pub struct SchemaArgs {
    /// Print the reference of the grammar, docs/scene.md.
    #[arg(long, hide = true)]
    pub markdown: bool,
}

/// `--json`.
#[derive(Debug, Args)]
pub struct JsonFlag {
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
}

/// `meniscus scenes`.
#[derive(Debug, Args)]
pub struct ScenesArgs {
    /// Print JSON.
    #[arg(long, conflicts_with = "markdown")]
    pub json: bool,
    /// Print a page of Markdown with a table of the scenes.
    #[arg(long)]
    pub markdown: bool,
}

/// `meniscus new`.
#[derive(Debug, Args)]
pub struct NewArgs {
    /// The built-in scene to start from; see `meniscus scenes`.
    #[arg(value_name = "NAME", required_unless_present = "list")]
    pub preset: Option<String>,
    /// File to write; its name becomes the name of the scene. Default: standard output.
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// List the built-in scenes.
    #[arg(long)]
    pub list: bool,
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }
}
