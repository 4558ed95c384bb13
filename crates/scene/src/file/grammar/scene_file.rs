//! The grammar of a scene file, exactly as written: `format = 1`.
//!
//! Only externally tagged enums and `deny_unknown_fields`, so that every error points at the exact value.

use crate::file::grammar::{
    Acceleration, Angle, ContactLineFile, Density, DynamicViscosity, ExpectFile, KinematicViscosity, Length,
    ShapeFile, SolidFile, Speed, TensionFile, Time,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A whole scene file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SceneFile {
    /// Version of the grammar: 1.
    pub format: u32,
    /// Name of the scene and of its output folder: letters, digits, `-`, `_` and `.`, at most 100, not starting
    /// with `.`.
    pub name: String,
    /// Source of the scene, such as a figure of the paper.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub based_on: Option<String>,
    /// Description of the scene in one or two lines.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub description: Option<String>,
    /// Approximate cost of a run, as free text.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cost: Option<String>,
    /// The simulated box and its grid.
    pub domain: DomainFile,
    /// The liquid and its state at the start.
    pub liquid: LiquidFile,
    /// The solids.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub solid: Vec<SolidFile>,
    /// Surface tension of the liquid, and tensions or contact angles of the solids.
    pub tension: TensionFile,
    /// Properties of the contact line.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub contact_line: Option<ContactLineFile>,
    /// Parameters of the discretisation.
    #[serde(default)]
    pub numerics: NumericsFile,
    /// Duration of the run, and the files that it writes.
    pub output: OutputFile,
    /// Expected results, checked at the end of the run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expect: Option<ExpectFile>,
}

/// `[domain]`: the simulated box and its grid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DomainFile {
    /// Number of dimensions, 2 or 3. The last axis points up; the lower corner of the domain is the origin.
    pub dimension: u32,
    /// Length along each axis, above 0. It is rounded to a whole number of cells.
    pub size: Vec<Length>,
    /// Number of cells along the longest side, 4 to 16384; given instead of `dx`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub resolution: Option<u32>,
    /// Cell size, above 0; given instead of `resolution`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dx: Option<Length>,
    /// Number of cells along the longest side for `--quality draft` and `--quality paper`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub quality: Option<QualityFile>,
    /// Type of each side of the domain.
    #[serde(default)]
    pub walls: WallsFile,
    /// Contact angle at the closed sides, through the liquid: 0 to 180 degrees, 90 degrees by default. At 90
    /// degrees the closed sides are planes of symmetry: no contact line is written on them, and contact-line
    /// friction and hysteresis do not act there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wall_contact_angle: Option<Angle>,
}

/// Number of cells along the longest side for qualities other than `normal`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct QualityFile {
    /// For `--quality draft`; half of the scene's resolution by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub draft: Option<u32>,
    /// For `--quality paper`, which the scene does not have without this key.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub paper: Option<u32>,
}

/// Type of a side of the domain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Wall {
    /// Closed side: impermeable, without friction.
    Slip,
    /// Open side: beyond it is air. Liquid leaves through it, and none enters.
    Open,
}

/// `walls`: types of the sides of the domain.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WallsFile {
    /// Type of all sides that are not named; `slip` by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub all: Option<Wall>,
    /// Lower end of x.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub left: Option<Wall>,
    /// Upper end of x.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub right: Option<Wall>,
    /// Lower end of y (3D only).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub front: Option<Wall>,
    /// Upper end of y (3D only).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub back: Option<Wall>,
    /// Lower end of the last axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bottom: Option<Wall>,
    /// Upper end of the last axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub top: Option<Wall>,
}

/// `[liquid]`: properties of the liquid, gravity, and the bodies of liquid at the start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LiquidFile {
    /// Density, above 0.
    pub density: Density,
    /// Kinematic viscosity, 0 or more. Either this key or `dynamic_viscosity` is required.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub kinematic_viscosity: Option<KinematicViscosity>,
    /// Dynamic viscosity, 0 or more; given instead of `kinematic_viscosity`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dynamic_viscosity: Option<DynamicViscosity>,
    /// Gravitational acceleration along each axis; 0 by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gravity: Option<Vec<Acceleration>>,
    /// Bodies of liquid at the start, at least one. Where bodies overlap, the first one counts.
    #[serde(default)]
    pub body: Vec<BodyFile>,
}

/// `[[liquid.body]]`: a region of liquid at the start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BodyFile {
    /// Shape of the region. Solids and the sides of the domain cut off the part that they overlap.
    pub shape: ShapeFile,
    /// Velocity at the start; 0 by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub velocity: Option<Vec<Speed>>,
    /// Whether solids cut off a part of the body on purpose, as where half a ball of liquid is placed on a
    /// plate; `false` by default. With `false`, `check` and `run` warn if a solid cuts a ball, an ellipsoid or
    /// a perturbed ball by more than a cell.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub displaced: Option<bool>,
}

/// `[numerics]`: parameters of the discretisation.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NumericsFile {
    /// Scheme of a time step; `meniscus` by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scheme: Option<Scheme>,
    /// Courant number: largest displacement of the liquid or of a solid in a step, in cells; 0.01 to 10, 0.7 by
    /// default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cfl: Option<f64>,
    /// Largest step, above 0; not bounded by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_step: Option<Time>,
    /// Relative residual at which a pressure solve ends; 1e-14 to 0.1, 1e-6 by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<f64>,
    /// Largest number of iterations of a pressure solve; 1 to 1000000, 1000 by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_iterations: Option<u32>,
    /// Largest step as a multiple of the explicit capillary limit, 0.36 √(ρ Δ³ / γ); 0.01 to 1000, 5 by
    /// default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub capillary_step: Option<f64>,
    /// Newton's iterations of a step where solids move freely or deform go on for at least so many after the
    /// first, which keeps the angular momentum of those that deform to rounding; without it they end where
    /// nothing moves by a thousandth of a contact's reach.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub newton_iterations: Option<u32>,
    /// Constant step, above 0, without any bound by stability. Only a step that fails is repeated with half the
    /// length, which then grows back by at most a quarter a step.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fixed_step: Option<Time>,
    /// Whether the momentum that the discretisation loses is restored; `true` by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub restore_momentum: Option<bool>,
    /// Number of threads, 1 to 1024; all available ones by default. The result does not depend on it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub threads: Option<u32>,
}

/// Scheme of a time step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Scheme {
    /// One coupled solve per step; capillary forces are gradients of the surface energy.
    #[default]
    Meniscus,
    /// The seven steps of the paper's Section 6. This version does not run it.
    #[schemars(skip)]
    Paper,
}

/// `[output]`: duration of the run, and the files that it writes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OutputFile {
    /// Simulated time of the run, above 0.
    pub duration: Time,
    /// Simulated time between frames, above 0; a hundredth of the duration by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frame_interval: Option<Time>,
    /// Formats of the output; `ply` and `page` by default. `ply` is always written.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub formats: Option<Vec<Format>>,
    /// Number of frames between checkpoints, 1 or more; 20 by default. A checkpoint is also written when the
    /// last one is a minute old.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub checkpoint_every: Option<u32>,
}

/// A format of the output. Formats that this version does not write can be read, so that the error names them;
/// the schema omits them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Format {
    /// Surfaces of each frame as binary PLY; always written.
    Ply,
    /// One self-contained HTML page of the run.
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

impl Format {
    /// All formats, in the order of their definition.
    pub const ALL: [Self; 8] =
        [Self::Ply, Self::Page, Self::Vtk, Self::Obj, Self::Glb, Self::Usd, Self::Vdb, Self::Csv];
}
