//! The command line, parsed by `clap`.

use clap::{Args, Parser, Subcommand, ValueEnum};
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
                 4.5 cells of the solid, and swing more than the fit
  left, right    2D: the angle at the outermost points of the line, and where
  base radius    mean distance of the line from its middle
  height         largest distance of the drop from the solid
  wetted area    2D: a length, per metre of depth
  force          of the liquid in the last step (2D: per metre of depth); its
                 parts by pressure and at the line
  centre, depth  in tanks: height of the solid's middle over the undisturbed
                 surface, and depth of its lowest point below it
  touched        when liquid touched the solid, in any frame
  deflection     largest and mean way of the surface from where it was at rest,
                 less the rigid motion of a free solid
  displacement   largest way, rigid motion included
  tip            where the part farthest from what is held is, and its way
  slopes, fold   of a plate's middle line: angles at its ends to its axis at
                 rest, and by how much it turns between them
  curvature      the largest of the middle line, with its sign
  wetted         share of the solid's surface
  ridge          height of the crest along the line over the surface 4.5 cells
                 away; none where the surface is not highest at the line (the
                 solid bends), or the line is at an edge
The last table has means over --window: each step counts by its length.";

const AFTER_HELP: &str = "\
Exit status: 0 done, 1 internal error, 2 wrong usage, 3 scene invalid, 4 input or output failed, \
5 the solver could not go on, 6 an expectation or verification missed, 75 stopped on request (resumable).

First steps (SCENE may be a built-in name or a .toml file):
  meniscus scenes                                     what there is to run
  meniscus run fig12-contact-angle-45-2d              run one: 10 s; pictures and a page in out/
  meniscus measure out/fig12-contact-angle-45-2d      contact angles, radii and heights of a run
  meniscus new fig12-contact-angle-45-2d -o my.toml   a copy to change, called `my`
  meniscus check my.toml                              what a scene asks for, without running it
  meniscus run my.toml --set tension.plate.contact_angle=60deg
  meniscus measure out/my";

/// Surface-tension liquids: simulate, look, measure, verify.
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
    /// Simulate a scene: a .toml file, the name of a built-in scene, or an output folder to run again.
    Run(RunArgs),
    /// The built-in scenes.
    Scenes(JsonFlag),
    /// Write a commented scene file to start from.
    New(NewArgs),
    /// Look at a scene without running it: resolved values, physics in numbers, cost, warnings.
    Check(CheckArgs),
    /// Contact angles, base radii, heights, wetted areas and touches, from stored frames.
    Measure(MeasureArgs),
    /// The validation suite: value, reference, error, bar, pass or fail.
    Verify(VerifyArgs),
    /// Random small scenes under invariants: what breaks one is written with the checkpoint before it.
    Soak(SoakArgs),
    /// Time per phase.
    Bench(BenchArgs),
    /// One self-contained HTML page of a run.
    Page(PageArgs),
    /// Pictures of a run, and a film if ffmpeg is there.
    Render(RenderArgs),
    /// The JSON Schema of scene files, for editors (see docs/scene.md).
    Schema(SchemaArgs),
    /// Version, build and machine.
    Info(JsonFlag),
    /// Completions for a shell.
    Completions {
        /// Which shell.
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

/// Which scene, and what is changed in it.
#[derive(Clone, Debug, Args)]
pub struct SceneArgs {
    /// A .toml file, or the name of a built-in scene.
    #[arg(value_name = "SCENE")]
    pub scene: String,
    /// Change a value of the scene, such as --set domain.resolution=96 (repeatable).
    #[arg(long, value_name = "PATH=VALUE")]
    pub set: Vec<String>,
    /// Resolution.
    #[arg(long, value_enum)]
    pub quality: Option<Quality>,
}

/// `meniscus run`.
#[derive(Clone, Debug, Args)]
pub struct RunArgs {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Output folder; out/NAME, by the name of the scene, without it.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Go on from the last checkpoint of the output folder.
    #[arg(long, conflicts_with = "force")]
    pub resume: bool,
    /// Simulate until this time, such as "0.5 s", instead of the scene's duration.
    #[arg(long, value_name = "TIME")]
    pub until: Option<String>,
    /// Write only these frames, first:last, and end with the last.
    #[arg(long, value_name = "A:B", value_parser = frame_range)]
    pub frames: Option<(u64, u64)>,
    /// Threads; as many as the machine has without it. The result does not depend on it.
    #[arg(long, value_name = "N", env = "MENISCUS_THREADS", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Stop after this time, such as 55m, with a checkpoint (exit status 75).
    #[arg(long, value_name = "TIME", value_parser = wall_time)]
    pub walltime: Option<Duration>,
    /// How progress is reported.
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
    /// Coarse: to see what happens.
    Draft,
    /// What the scene says.
    Normal,
    /// What the paper used.
    Paper,
}

/// `meniscus new`.
#[derive(Debug, Args)]
pub struct NewArgs {
    /// The built-in scene to start from; see `meniscus scenes`.
    #[arg(required_unless_present = "list")]
    pub preset: Option<String>,
    /// The file to write, whose name becomes the name of the scene; standard output without it.
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// List what there is.
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
    /// Warnings count as errors (exit status 3).
    #[arg(long)]
    pub strict: bool,
}

/// `meniscus measure`.
#[derive(Debug, Args)]
#[command(after_help = MEASURE_HELP)]
pub struct MeasureArgs {
    /// The output folder.
    pub dir: PathBuf,
    /// Measure the frame nearest to this time, such as "20 ms"; the last frame without it.
    #[arg(long, value_name = "TIME")]
    pub at: Option<String>,
    /// Take means over this time before the frame, such as "20 ms"; over a tenth of the simulated time without it.
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
    /// Write the results as JSON.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Write the results as an HTML page.
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
}

/// `meniscus soak`.
#[derive(Debug, Args)]
pub struct SoakArgs {
    /// The same seed draws the same scenes.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Go on for so many hours.
    #[arg(long, value_name = "H")]
    pub hours: Option<f64>,
    /// Run so many scenes; 100 without it and --hours.
    #[arg(long, value_name = "N")]
    pub scenes: Option<u64>,
    /// Dimensions of the scenes; four of five are in 2D without it.
    #[arg(long, value_parser = clap::value_parser!(u8).range(2..=3))]
    pub dimension: Option<u8>,
    /// What scenes are drawn from; drop-test: soft solids that fall on wet ground, under the energy law of every step, 60 scenes a
    /// round in 2D and 12 in 3D.
    #[arg(long, value_enum, default_value_t = Set::Random)]
    pub set: Set,
    /// Solids in the scenes; soft: at least one that deforms.
    #[arg(long, value_enum, default_value_t = Solids::Any)]
    pub solids: Solids,
    /// Small and short scenes.
    #[arg(long)]
    pub quick: bool,
    /// Run only this case.
    #[arg(long, value_name = "I")]
    pub case: Option<u64>,
    /// Run only this scene file, under the same invariants.
    #[arg(long, value_name = "FILE", conflicts_with = "case")]
    pub scene: Option<PathBuf>,
    /// With --case or --scene: leave out of the scene what it breaks the invariant without.
    #[arg(long)]
    pub shrink: bool,
    /// With --shrink: the invariant; the first that is broken without it.
    #[arg(long, value_name = "INVARIANT")]
    pub kind: Option<String>,
    /// Where scenes and checkpoints of violations go.
    #[arg(long, value_name = "DIR", default_value = "out/soak")]
    pub out: PathBuf,
    /// Cases at a time, each on one thread; as many as the machine has cores without it.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub jobs: Option<u16>,
    /// A list of known violations, which do not count: on each line the name of a case and the invariants.
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
    /// Random ones from the whole grammar.
    Random,
    /// Soft solids that fall.
    DropTest,
}

/// Solids in drawn scenes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Solids {
    /// Liquid alone.
    None,
    /// Solids that do not deform.
    Rigid,
    /// At least one that deforms.
    Soft,
    /// Any or none.
    Any,
}

/// `meniscus bench`.
#[derive(Debug, Args)]
pub struct BenchArgs {
    /// What to time: pressure, step (both without it), table1 (the paper's table, long).
    pub names: Vec<String>,
    /// Small and short, to see that it works.
    #[arg(long)]
    pub quick: bool,
    /// Threads; as many as the machine has without it.
    #[arg(long, value_name = "N", env = "MENISCUS_THREADS")]
    pub threads: Option<u16>,
    /// Write the results as JSON.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
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
    /// Where the pictures go; the folder render of the output folder without it. There pictures of an earlier call that this one
    /// does not write again are removed.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// 3D: where the camera is, as seen from the middle: azimuth (0 looks along +y, 90 along -x) and elevation in degrees, and the
    /// distance in metres, without which all is fitted into the picture. [default: 25,17]
    #[arg(long, value_name = "AZIMUTH,ELEVATION[,DISTANCE]", allow_hyphen_values = true)]
    pub camera: Option<String>,
    /// 3D: what the liquid looks like: glass (clear) or matte (opaque). [default: glass]
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
    /// Colour behind everything, such as ffffff.
    #[arg(long, value_name = "RRGGBB", value_parser = hex_color)]
    pub background: Option<u32>,
    /// Colour of the liquid; of glass its tint.
    #[arg(long, value_name = "RRGGBB", value_parser = hex_color)]
    pub liquid_color: Option<u32>,
    /// Colour of all solids.
    #[arg(long, value_name = "RRGGBB", value_parser = hex_color)]
    pub solid_color: Option<u32>,
    /// The quantity that colours solids: plain, phi_c (distance to the contact line along the surface, negative where wetted), strain
    /// (largest |stretch - 1|) or displacement. [default: plain]
    #[arg(long, value_name = "VALUES")]
    pub color: Option<String>,
    /// Take every n-th frame.
    #[arg(long, default_value_t = 1)]
    pub every: u32,
}

/// `10:20` → (10, 20); an open end stands for the first or last frame.
fn frame_range(text: &str) -> Result<(u64, u64), String> {
    let (a, b) = text.split_once(':').ok_or("expected first:last, such as 10:20")?;
    let number = |s: &str, open: u64| {
        if s.is_empty() {
            Ok(open)
        } else {
            s.parse::<u64>().map_err(|_| format!("`{s}` is not a frame number"))
        }
    };
    let (a, b) = (number(a, 0)?, number(b, u64::MAX)?);
    if a > b { Err(format!("frame {a} comes after frame {b}")) } else { Ok((a, b)) }
}

/// `55m`, `90s`, `1h30m`, `90` (seconds).
fn wall_time(text: &str) -> Result<Duration, String> {
    let help = "expected a time such as 55m, 90s or 1h30m";
    let (mut seconds, mut number) = (0.0, String::new());
    for c in text.chars().filter(|c| !c.is_whitespace()).chain(['s']) {
        if c.is_ascii_digit() || c == '.' {
            number.push(c);
            continue;
        }
        let factor = match c {
            'd' => 86400.0,
            'h' => 3600.0,
            'm' => 60.0,
            's' => 1.0,
            _ => return Err(help.into()),
        };
        if !number.is_empty() {
            seconds += factor * number.parse::<f64>().map_err(|_| help)?;
            number.clear();
        }
    }
    Duration::try_from_secs_f64(seconds).ok().filter(|d| !d.is_zero()).ok_or_else(|| help.to_string())
}

/// `7` → (7, 7), otherwise as [`frame_range`].
fn picture_range(text: &str) -> Result<(u64, u64), String> {
    match text.parse::<u64>() {
        Ok(one) => Ok((one, one)),
        Err(_) => frame_range(text),
    }
}

/// `ff8000` or `#ff8000` → 0xff8000.
fn hex_color(text: &str) -> Result<u32, String> {
    let digits = text.strip_prefix('#').unwrap_or(text);
    let color = u32::from_str_radix(digits, 16).ok().filter(|_| digits.len() == 6);
    color.ok_or_else(|| "expected six hexadecimal digits for red, green and blue, such as ff8000".to_owned())
}

fn picture_size(text: &str) -> Result<(u32, u32), String> {
    let help = "expected width x height in pixels, such as 640x360";
    let (w, h) = text.split_once('x').ok_or(help)?;
    let side = |s: &str| s.trim().parse::<u32>().ok().filter(|n| (16..=8192).contains(n)).ok_or(help);
    Ok((side(w)?, side(h)?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn values() {
        assert_eq!(wall_time("55m"), Ok(Duration::from_secs(3300)));
        assert_eq!(wall_time("1h30m"), Ok(Duration::from_secs(5400)));
        assert_eq!(wall_time("0.5"), Ok(Duration::from_millis(500)));
        assert!(wall_time("soon").is_err() && wall_time("").is_err());
        assert_eq!(frame_range("3:7"), Ok((3, 7)));
        assert_eq!(frame_range(":7"), Ok((0, 7)));
        assert!(frame_range("7:3").is_err() && frame_range("7").is_err());
        assert_eq!(picture_size("640x360"), Ok((640, 360)));
        assert!(picture_size("0x360").is_err());
        assert_eq!((picture_range("7"), picture_range("3:7")), (Ok((7, 7)), Ok((3, 7))));
        assert_eq!(hex_color("#ff8000"), Ok(0xff8000));
        assert!(hex_color("red").is_err() && hex_color("fff").is_err());
    }
}
