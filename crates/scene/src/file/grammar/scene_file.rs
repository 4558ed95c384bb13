//! The grammar of a scene file, exactly as written: `format = 1`.
//!
//! Only externally tagged enums and `deny_unknown_fields`, so that every error points at the exact value.

use super::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A whole scene file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SceneFile {
    /// Version of the grammar: 1.
    pub format: u32,
    /// Name of the scene and of its output folder: letters, digits, `-`, `_`, `.`.
    pub name: String,
    /// Where the scene comes from, such as a figure of the paper.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub based_on: Option<String>,
    /// What it shows, in a line or two.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub description: Option<String>,
    /// What it takes to run, in words.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cost: Option<String>,
    /// The box that is simulated.
    pub domain: DomainFile,
    /// The liquid.
    pub liquid: LiquidFile,
    /// The solids.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub solid: Vec<SolidFile>,
    /// The tensions of the interfaces.
    pub tension: TensionFile,
    /// The contact line.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub contact_line: Option<ContactLineFile>,
    /// Choices of the discretisation.
    #[serde(default)]
    pub numerics: NumericsFile,
    /// How long, how often, in which formats.
    pub output: OutputFile,
    /// What is checked at the end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expect: Option<ExpectFile>,
}

/// `[domain]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DomainFile {
    /// 2 or 3; the last axis is up, the lower corner is the origin.
    pub dimension: u32,
    /// Size along each axis.
    pub size: Vec<Length>,
    /// Cells along the longest side; instead of `dx`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub resolution: Option<u32>,
    /// Size of a cell; instead of `resolution`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dx: Option<Length>,
    /// Cells along the longest side for `--quality draft` and `--quality paper`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub quality: Option<QualityFile>,
    /// What each side is.
    #[serde(default)]
    pub walls: WallsFile,
    /// Angle at which the liquid meets the closed sides, through the liquid. At 90 degrees, as without this key, they are
    /// mirrors: no contact line is seen on them, and it has neither friction nor hysteresis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wall_contact_angle: Option<Angle>,
}

/// Cells along the longest side for other qualities than `normal`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct QualityFile {
    /// For `--quality draft`; without it half of the scene's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub draft: Option<u32>,
    /// For `--quality paper`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub paper: Option<u32>,
}

/// What a side of the domain is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Wall {
    /// Impermeable, without friction.
    Slip,
    /// Air: liquid that passes the side leaves; none comes in.
    Open,
}

/// `walls`: `all`, and any side that differs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WallsFile {
    /// Every side that is not named; slip without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub all: Option<Wall>,
    /// Lower x.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub left: Option<Wall>,
    /// Upper x.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub right: Option<Wall>,
    /// Lower y (3D).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub front: Option<Wall>,
    /// Upper y (3D).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub back: Option<Wall>,
    /// Lower end of the last axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bottom: Option<Wall>,
    /// Upper end of the last axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub top: Option<Wall>,
}

/// `[liquid]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LiquidFile {
    /// Density.
    pub density: Density,
    /// Kinematic viscosity; or `dynamic_viscosity`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub kinematic_viscosity: Option<KinematicViscosity>,
    /// Dynamic viscosity, instead of `kinematic_viscosity`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dynamic_viscosity: Option<DynamicViscosity>,
    /// Gravity along each axis; none without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gravity: Option<Vec<Acceleration>>,
    /// The bodies of liquid at the start.
    #[serde(default)]
    pub body: Vec<BodyFile>,
}

/// `[[liquid.body]]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BodyFile {
    /// What it fills.
    pub shape: ShapeFile,
    /// Start velocity; at rest without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub velocity: Option<Vec<Speed>>,
    /// Solids are meant to cut off what they overlap of it at the start, as where half a ball is laid on a plate: without this key
    /// `check` and `run` warn of a ball or an ellipsoid that a solid cuts by more than a cell.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub displaced: Option<bool>,
}

/// `[numerics]`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NumericsFile {
    /// The scheme; `meniscus` without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scheme: Option<Scheme>,
    /// Largest distance the liquid may move in a step, in cells; 0.7 without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cfl: Option<f64>,
    /// Largest step; none without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_step: Option<Time>,
    /// Relative residual of the solves; 1e-6 without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<f64>,
    /// Most iterations of a solve; 1000 without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_iterations: Option<u32>,
    /// Largest step as a multiple of the explicit capillary limit; 5 without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub capillary_step: Option<f64>,
    /// Newton's iterations of a step where solids deform go on for at least so many after the first, which keeps their angular momentum
    /// to rounding; without it they end where nothing moves by a thousandth of a contact's reach.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub newton_iterations: Option<u32>,
    /// The same step length always, whatever stability asks for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fixed_step: Option<Time>,
    /// Give back the momentum that the discretisation loses; yes without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub restore_momentum: Option<bool>,
    /// Threads; as many as there are without it. The result does not depend on it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub threads: Option<u32>,
}

/// How a step is done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Scheme {
    /// One coupled solve a step, energy-gradient capillarity.
    #[default]
    Meniscus,
    /// The seven steps of the paper's Section 6, which this version does not have.
    #[schemars(skip)]
    Paper,
}

/// `[output]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OutputFile {
    /// Simulated time.
    pub duration: Time,
    /// Time between frames; a hundredth of the duration without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frame_interval: Option<Time>,
    /// Formats of the frames; `ply` is always written.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub formats: Option<Vec<Format>>,
    /// Frames between checkpoints; 20 without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub checkpoint_every: Option<u32>,
}

/// A format of frames. Those that this version does not write are read, so that they are refused by name; the schema does not
/// offer them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Format {
    /// Surfaces, binary PLY; always written.
    Ply,
    /// One self-contained HTML page.
    Page,
    /// VTK XML with a `.pvd`.
    #[schemars(skip)]
    Vtk,
    /// Wavefront OBJ.
    #[schemars(skip)]
    Obj,
    /// Binary glTF.
    #[schemars(skip)]
    Glb,
    /// USD text.
    #[schemars(skip)]
    Usd,
    /// OpenVDB level sets.
    #[schemars(skip)]
    Vdb,
    /// Tables of vertices.
    #[schemars(skip)]
    Csv,
}
