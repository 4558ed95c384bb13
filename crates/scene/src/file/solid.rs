//! Solids, their tensions and the contact line, as written in a scene file.

use super::{
    Angle, AngularVelocity, Density, DynamicViscosity, Either, Length, Named, Pressure, ShapeFile, Speed,
    Tension, Time,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `[[solid]]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SolidFile {
    /// Name, used in `[tension]` and in file names.
    pub name: String,
    /// Density; needed unless the solid does not move freely.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub density: Option<Density>,
    /// Shape.
    pub shape: ShapeFile,
    /// How it is meshed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mesh: Option<SolidMeshFile>,
    /// What it is made of.
    pub material: MaterialFile,
    /// Start velocity; at rest without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub velocity: Option<Vec<Speed>>,
    /// How it collides with other solids and the domain's closed sides.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub collision: Option<CollisionFile>,
    /// Vertices inside these shapes do not move.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub fixed: Vec<ShapeFile>,
}

/// How a solid collides. Of two solids the geometric mean of both counts; a side of the domain has the solid's own.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CollisionFile {
    /// Speed after a hit over that before it, 0 to 1; 0.3 without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub restitution: Option<f64>,
    /// Coulomb's coefficient of friction; 0.3 without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction: Option<f64>,
}

/// How a solid is meshed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SolidMeshFile {
    /// Edge length; dx / 1.5 without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub edge: Option<Length>,
}

/// What a solid is made of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum MaterialFile {
    /// Does not deform.
    Rigid(RigidFile),
    /// Moves as prescribed.
    Kinematic(KinematicFile),
    /// Mass and springs, as in the paper.
    Springs(SpringsFile),
    /// Compressible neo-Hookean solid.
    NeoHookean(ElasticFile),
    /// Corotated linear elasticity.
    Corotated(ElasticFile),
    /// A thin sheet.
    Shell(ShellFile),
    /// A thin thread.
    Rod(RodFile),
}

/// `rigid`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RigidFile {
    /// Does not move at all.
    #[serde(default)]
    pub fixed: bool,
}

/// `kinematic`: a velocity, or keyframes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct KinematicFile {
    /// Constant velocity.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub velocity: Option<Vec<Speed>>,
    /// Constant angular velocity: one entry in 2D, three in 3D.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub angular_velocity: Option<Vec<AngularVelocity>>,
    /// Displacement at given times, linear in between.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub keyframes: Option<Vec<KeyframeFile>>,
}

/// Where a kinematic solid is at a time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct KeyframeFile {
    /// Time.
    pub time: Time,
    /// Displacement from the start.
    pub translate: Vec<Length>,
}

/// `springs`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpringsFile {
    /// Spring stiffness.
    pub stiffness: Tension,
    /// Fraction of critical damping; 0 without it.
    #[serde(default)]
    pub damping_ratio: f64,
}

/// `neo_hookean`, `corotated`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ElasticFile {
    /// Young modulus.
    pub young_modulus: Pressure,
    /// Poisson ratio, above -1 and below 0.5.
    pub poisson_ratio: f64,
    /// Fraction of critical damping; 0 without it.
    #[serde(default)]
    pub damping_ratio: f64,
}

/// `shell`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ShellFile {
    /// Young modulus.
    pub young_modulus: Pressure,
    /// Poisson ratio, above -1 and below 0.5.
    pub poisson_ratio: f64,
    /// Thickness.
    pub thickness: Length,
    /// Fraction of critical damping; 0 without it.
    #[serde(default)]
    pub damping_ratio: f64,
}

/// `rod`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RodFile {
    /// Young modulus.
    pub young_modulus: Pressure,
    /// Radius of the section.
    pub radius: Length,
    /// Fraction of critical damping; 0 without it.
    #[serde(default)]
    pub damping_ratio: f64,
}

/// Tensions of a solid: both interface energies, or the contact angle.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SolidTensionFile {
    /// Liquid–solid tension.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub liquid_solid: Option<Tension>,
    /// Solid–air tension.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub solid_air: Option<Tension>,
    /// Contact angle through the liquid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub contact_angle: Option<Angle>,
}

/// `[contact_line]`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ContactLineFile {
    /// Off: the traditional two-way coupling, for comparison; on without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub enabled: Option<bool>,
    /// The paper's R; 3 dx without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub radius: Option<Length>,
    /// Contact-line friction, or a table of it per solid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction: Option<Either<DynamicViscosity, Named<DynamicViscosity>>>,
    /// The line rests between these angles.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hysteresis: Option<HysteresisFile>,
}

/// The angles between which a contact line rests.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HysteresisFile {
    /// The line advances above this angle.
    pub advancing: Angle,
    /// The line recedes below this angle.
    pub receding: Angle,
}
