//! Arguments of the commands that read the output of a run.

use super::SceneArgs;
use crate::values::{export_format, hex_color, picture_range, picture_size, picture_target, scale_factor};
use clap::{Args, ValueEnum};
use meniscus_scene::output::frame::Format;
use std::path::PathBuf;

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

/// `meniscus measure`.
#[derive(Debug, Args)]
#[command(after_help = MEASURE_HELP)]
pub struct MeasureArgs {
    /// The output folder of a run, such as out/my-scene.
    pub dir: PathBuf,
    /// Measure the frame nearest to this time, such as "20 ms". Default: the last frame.
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    pub at: Option<String>,
    /// Average over this time before the frame, such as "20 ms". Default: a tenth of the simulated time.
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    pub window: Option<String>,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
}

/// `meniscus page`.
#[derive(Debug, Args)]
pub struct PageArgs {
    /// The output folder of a run, such as out/my-scene.
    pub dir: PathBuf,
    /// Take every n-th frame.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub every: u32,
    /// Largest size of the page in megabytes; frames are left out until it fits.
    #[arg(long, value_name = "MB", default_value_t = 20.0)]
    pub max_mb: f64,
}

/// `meniscus view`.
#[derive(Debug, Args)]
pub struct ViewArgs {
    /// The output folder of a run, or the scene, that the page shows.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Output folder of another run, drawn over the first.
    #[arg(long, value_name = "DIR")]
    pub with: Option<PathBuf>,
    /// Port of 127.0.0.1 for the browser. Default: any free one.
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    pub port: u16,
}

/// `meniscus render`.
#[derive(Debug, Args)]
pub struct RenderArgs {
    /// The output folder of a run, such as out/my-scene.
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
    /// 3D: position of the camera relative to the centre of the scene, or to the target: azimuth (0 looks along +y, 90 along -x) and elevation in
    /// degrees, and optionally the distance in metres. Without a distance everything fits into the picture. [default: 25,17]
    #[arg(long, value_name = "AZIMUTH,ELEVATION[,DISTANCE]", allow_hyphen_values = true)]
    pub camera: Option<String>,
    /// 3D: point in the middle of the picture, in metres. Default: the centre of what is shown.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = picture_target)]
    pub target: Option<[f64; 3]>,
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
    /// Make pictures without a background, for compositing: PNG with an alpha channel. No film is made.
    #[arg(long, conflicts_with = "background")]
    pub transparent: bool,
    /// Colour of the liquid (with the style glass: its tint).
    #[arg(long, value_name = "RRGGBB", value_parser = hex_color)]
    pub liquid_color: Option<u32>,
    /// Colour of all solids.
    #[arg(long, value_name = "RRGGBB", value_parser = hex_color)]
    pub solid_color: Option<u32>,
    /// Quantity shown as the colour of the solids: plain, phi_c (distance to the contact line along the surface, negative where
    /// wetted), strain (largest |stretch - 1|), displacement or young (Young's angle, of solids with a pattern). [default: plain]
    #[arg(long, value_name = "VALUES")]
    pub color: Option<String>,
    /// Take every n-th frame.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub every: u32,
}

const EXPORT_HELP: &str = "\
Formats (docs/formats.md has their content, docs/into.md the way into programs):
  vtk   surfaces and contact lines for ParaView (.vtp), run.pvd with the times
  obj   surfaces and contact lines as Wavefront OBJ
  glb   each frame as one binary glTF file, for slides and the web
  usd   each frame as USD text with materials, and run.usda, which plays them
  csv   tables of the contact line: position, angle, speed, force
  ply   as a run stores them, for example with another --scale
Stored frames have surfaces and contact lines. Elements of deformable solids
(.vtu) and fields on the grid (.vti, .vdb) are written by a run whose scene
has output.formats = [\"vtk\", \"vti\", \"vdb\"].";

/// `meniscus export`.
#[derive(Debug, Args)]
#[command(after_help = EXPORT_HELP)]
pub struct ExportArgs {
    /// The output folder of a run.
    pub dir: PathBuf,
    /// The format: ply, vtk, obj, glb, usd or csv.
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
    /// Treatment of the faces of the liquid's surface that lie on a solid.
    #[arg(long, value_enum, default_value_t = Wetted::Keep)]
    pub wetted: Wetted,
}

/// Treatment of the faces of the liquid's surface that lie on a solid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Wetted {
    /// They are written as they are.
    Keep,
    /// They are moved half a cell into the solid, so that a path tracer sees no gap of air between liquid and solid.
    Sink,
    /// They are left out; the surface is then open where the liquid lies on a solid.
    Remove,
}

/// The axis that points up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum UpAxis {
    /// The second axis.
    Y,
    /// The third axis.
    Z,
}
