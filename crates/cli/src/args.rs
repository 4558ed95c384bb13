//! The command line, parsed by `clap`.

use crate::values::{
    export_format, frame_range, hex_color, picture_range, picture_size, scale_factor, wall_time,
};
use clap::{Args, Parser, Subcommand, ValueEnum};
use meniscus_scene::output::frame::Format;
use std::path::PathBuf;
use std::time::Duration;

/// The help text of `meniscus measure` about its columns.
pub const MEASURE_HELP: &str = "\
Columns (docs/measure.md tells more, and the keys of --json):
  drop           number, the largest first; those under 8 cells are only counted
  on             the solid, or the side of the domain, that the drop touches
  angle, fit     contact angle through the liquid, as a goniometer sees it: of a
                 circle or ellipse (3D: sphere, spheroid) fitted to the surface
                 away from the line; ± its uncertainty
  residual       root mean square distance of the surface from the fit, in cells
  angle at line  mean ± standard deviation (least to largest) of the angles
                 stored along the contact line; they follow the surface within
                 4.5 cells of the solid, and fluctuate more than the fit
  left, right    2D: angle and position of the outermost points of the line
  base radius    mean distance of the contact line from its centre
  height         largest distance of the drop from the solid
  wetted area    2D: a length, per metre of depth
  force          of the liquid on the solid in the last step (2D: per metre of
                 depth), and its parts from pressure and contact line
  centre, depth  in tanks: height of the solid's centre above the undisturbed
                 surface, and depth of its lowest point below it
  touched        times from when to when liquid touched the solid, by frames
  deflection     largest and mean displacement of the surface from its rest
                 position, without the rigid motion of a free solid
  displacement   largest displacement, rigid motion included
  tip            position and displacement of the part of the solid that is
                 farthest from its fixed or moved parts
  slopes, fold   of the midline of a plate: angles of its ends to its axis at
                 rest, and the angle by which it turns between them
  curvature      largest curvature of the midline, with its sign
  wetted         wetted share of the solid's surface
  ridge          height of the surface along the contact line above that 4.5
                 cells away; none if the surface is not highest at the line
                 (the solid bends), or if the line is at an edge
The last table has time averages over --window.";

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
  meniscus measure out/my";

/// Simulates liquids with surface tension in contact with rigid and deformable solids.
#[derive(Debug, Parser)]
#[command(name = "meniscus", version, about, after_help = AFTER_HELP, max_term_width = 110)]
#[command(arg_required_else_help = true)]
pub struct Cli {
    /// What to do.
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
    /// Check a scene without running it: resolved values, dimensionless numbers, estimated cost, warnings.
    Check(CheckArgs),
    /// Measure contact angles, base radii, heights, wetted areas and contact times in stored frames.
    Measure(MeasureArgs),
    /// Run the validation suite: value, reference, error, tolerance, pass or fail.
    Verify(VerifyArgs),
    /// Run small random scenes and check invariants; scenes that violate one are written with the checkpoint before.
    Soak(SoakArgs),
    /// Measure the run time of the phases of a time step.
    Bench(BenchArgs),
    /// Write a self-contained HTML page of a run.
    Page(PageArgs),
    /// Render pictures of a run, and a film if ffmpeg is installed.
    Render(RenderArgs),
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

/// Which scene, and what is changed in it.
#[derive(Clone, Debug, Args)]
pub struct SceneArgs {
    /// A .toml file, or the name of a built-in scene.
    #[arg(value_name = "SCENE")]
    pub scene: String,
    /// Change a value of the scene, such as --set domain.resolution=96 (repeatable).
    #[arg(long, value_name = "PATH=VALUE")]
    pub set: Vec<String>,
    /// Resolution of the grid.
    #[arg(long, value_enum)]
    pub quality: Option<Quality>,
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
    #[arg(long, value_name = "TIME")]
    pub until: Option<String>,
    /// Write only the frames first:last, and end the run with the last of them.
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
    /// Coarse, for a quick look.
    Draft,
    /// The resolution given in the scene.
    Normal,
    /// The resolution used in the paper.
    Paper,
}

/// `meniscus new`.
#[derive(Debug, Args)]
pub struct NewArgs {
    /// The built-in scene to start from; see `meniscus scenes`.
    #[arg(required_unless_present = "list")]
    pub preset: Option<String>,
    /// File to write; its name becomes the name of the scene. Default: standard output.
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// List the built-in scenes.
    #[arg(long)]
    pub list: bool,
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

/// `meniscus measure`.
#[derive(Debug, Args)]
#[command(after_help = MEASURE_HELP)]
pub struct MeasureArgs {
    /// The output folder.
    pub dir: PathBuf,
    /// Measure the frame nearest to this time, such as "20 ms". Default: the last frame.
    #[arg(long, value_name = "TIME")]
    pub at: Option<String>,
    /// Average over this time before the frame, such as "20 ms". Default: a tenth of the simulated time.
    #[arg(long, value_name = "TIME")]
    pub window: Option<String>,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
}

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
    /// Write the results as JSON. This file and the pages are written anew after each case.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Keep the results that the file of --json already has, and run the other cases. They must be of the same version; two programs of
    /// one version are told apart only if MENISCUS_COMMIT named the commit when they were compiled.
    #[arg(long, requires = "json")]
    pub resume: bool,
    /// Write the results as an HTML page.
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
    /// Write the results as a page of Markdown.
    #[arg(long, value_name = "FILE")]
    pub markdown: Option<PathBuf>,
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
    /// Threads; as many as the machine has without it.
    #[arg(long, value_name = "N", env = "MENISCUS_THREADS")]
    pub threads: Option<u16>,
    /// Write the results as JSON.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// With table1 or precision alone: print the tables as a page of Markdown, and the rows to standard error as they come.
    #[arg(long)]
    pub markdown: bool,
}

/// `meniscus page`.
#[derive(Debug, Args)]
pub struct PageArgs {
    /// The output folder.
    pub dir: PathBuf,
    /// Take every n-th frame.
    #[arg(long, default_value_t = 1)]
    pub every: u32,
    /// Largest size of the page, megabytes.
    #[arg(long, default_value_t = 20.0)]
    pub max_mb: f64,
}

/// `meniscus render`.
#[derive(Debug, Args)]
pub struct RenderArgs {
    /// The output folder.
    pub dir: PathBuf,
    /// Width x height of the pictures in pixels.
    #[arg(long, value_name = "WxH", default_value = "640x360", value_parser = picture_size)]
    pub size: (u32, u32),
    /// Only these frames: one, or first:last.
    #[arg(long, alias = "frame", value_name = "N|A:B", value_parser = picture_range)]
    pub frames: Option<(u64, u64)>,
    /// Folder for the pictures. Default: the subfolder render of the output folder, where pictures of earlier calls that are not
    /// overwritten are removed.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// 3D: position of the camera relative to the centre of the scene: azimuth (0 looks along +y, 90 along -x) and elevation in
    /// degrees, and optionally the distance in metres. Without a distance everything fits into the picture. [default: 25,17]
    #[arg(long, value_name = "AZIMUTH,ELEVATION[,DISTANCE]", allow_hyphen_values = true)]
    pub camera: Option<String>,
    /// 3D: appearance of the liquid: glass (clear) or matte (opaque). [default: glass]
    #[arg(long, value_name = "STYLE")]
    pub style: Option<String>,
    /// Draw no floor (3D).
    #[arg(long)]
    pub no_floor: bool,
    /// Draw no edges of the domain.
    #[arg(long)]
    pub no_box: bool,
    /// Draw no contact line.
    #[arg(long)]
    pub no_line: bool,
    /// Colour of the background, such as ffffff.
    #[arg(long, value_name = "RRGGBB", value_parser = hex_color)]
    pub background: Option<u32>,
    /// Colour of the liquid (with the style glass: its tint).
    #[arg(long, value_name = "RRGGBB", value_parser = hex_color)]
    pub liquid_color: Option<u32>,
    /// Colour of all solids.
    #[arg(long, value_name = "RRGGBB", value_parser = hex_color)]
    pub solid_color: Option<u32>,
    /// Quantity shown as the colour of the solids: plain, phi_c (distance to the contact line along the surface, negative where
    /// wetted), strain (largest |stretch - 1|) or displacement. [default: plain]
    #[arg(long, value_name = "VALUES")]
    pub color: Option<String>,
    /// Take every n-th frame.
    #[arg(long, default_value_t = 1)]
    pub every: u32,
}

const EXPORT_HELP: &str = "\
Formats (docs/formats.md tells which program reads which, and with what):
  vtk   surfaces and contact lines for ParaView (.vtp), run.pvd with the times
  obj   surfaces and contact lines as Wavefront OBJ
  glb   each frame as one binary glTF file, for slides and the web
  csv   tables of the contact line: position, angle, speed, force
  ply   as stored, such as with another --scale
Stored frames have surfaces and contact lines. Elements of deformable solids
(.vtu) and fields on the grid (.vti) are written by a run whose scene has
output.formats = [\"vtk\", \"vti\"].";

/// `meniscus export`.
#[derive(Debug, Args)]
#[command(after_help = EXPORT_HELP)]
pub struct ExportArgs {
    /// The output folder of a run.
    pub dir: PathBuf,
    /// The format: ply, vtk, obj, glb or csv.
    #[arg(long, value_name = "FORMAT", value_parser = export_format)]
    pub to: Format,
    /// Only these frames: one, or first:last.
    #[arg(long, value_name = "N|A:B", value_parser = picture_range)]
    pub frames: Option<(u64, u64)>,
    /// Take every n-th frame.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    pub every: u32,
    /// Folder for the files. Default: export/FORMAT in the output folder, where files of an earlier export are removed.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Multiply all positions by this factor, such as 100 for centimetres. Attributes keep their units.
    #[arg(long, value_name = "S", default_value_t = 1.0, value_parser = scale_factor)]
    pub scale: f64,
    /// Turn the frames so that this axis points up. Default: z in 3D, y in 2D, as in the scene. (GLB files always have y up.)
    #[arg(long, value_enum)]
    pub up: Option<UpAxis>,
}

/// The axis that points up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum UpAxis {
    /// The second one.
    Y,
    /// The third one.
    Z,
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
