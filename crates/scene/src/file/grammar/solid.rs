//! Solids, their tensions and the contact line, as written in a scene file.

use crate::file::{
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
    /// Vertices inside these shapes go as told.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub moved: Vec<MovedFile>,
}

/// A part of a solid that deforms which goes as told: with a velocity, or by keyframes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MovedFile {
    /// What holds it, where the solid starts.
    pub shape: ShapeFile,
    /// Constant velocity.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub velocity: Option<Vec<Speed>>,
    /// Displacement at given times, linear in between.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub keyframes: Option<Vec<KeyframeFile>>,
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
    /// A thin sheet. This version does not run it.
    #[schemars(skip)]
    Shell(ShellFile),
    /// A thin thread. This version does not run it.
    #[schemars(skip)]
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

/// Tensions of a solid: both interface energies, the contact angle, or a gradient of it; where the angle varies, an image
/// over that, and patches over both.
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
    /// The cosine of the contact angle varies from one place to another.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gradient: Option<GradientFile>,
    /// A picture of the contact angle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub image: Option<WettingImageFile>,
    /// Parts of the surface with an angle of their own; where they overlap the later one counts.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub patches: Vec<PatchFile>,
}

/// `gradient`: the cosine of the angle is linear between two places, and constant before and beyond. Places are those of the
/// solid at its start: it takes them along.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GradientFile {
    /// Where it starts.
    pub from: AngleAtFile,
    /// Where it ends.
    pub to: AngleAtFile,
}

/// A contact angle and its place.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AngleAtFile {
    /// The place, where the solid starts.
    pub point: Vec<Length>,
    /// The angle there.
    pub contact_angle: Angle,
}

/// `image`: grey values tell the contact angle, seen along the vertical axis (2D: its middle row, along x). Cosines are
/// interpolated between the pixels' middles; clear pixels show what is below.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WettingImageFile {
    /// Path of a `.png`, relative to the scene file.
    pub file: String,
    /// Where its lower left corner lies, seen from above: x and y (2D: x), where the solid starts.
    pub lower: Vec<Length>,
    /// Where its upper right corner lies.
    pub upper: Vec<Length>,
    /// Contact angle of black.
    pub black: Angle,
    /// Contact angle of white.
    pub white: Angle,
}

/// A part of a solid's surface with an angle of its own: what lies within a shape.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PatchFile {
    /// The shape, where the solid starts; it may reach beyond the solid.
    pub shape: ShapeFile,
    /// The angle there.
    pub contact_angle: Angle,
}

/// `[contact_line]`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ContactLineFile {
    /// Off: the traditional two-way coupling, for comparison; on without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub enabled: Option<bool>,
    /// The paper's R: distance from the line along solids that deform over which its pull is spread; without it the line pulls
    /// where it is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub radius: Option<Length>,
    /// On: solids that deform feel the tensions of their own surface, `liquid_solid` where it is wetted and `solid_air` where
    /// it is dry, and at the line three tensions balance (Neumann); off without it: Young's balance along the solid only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub neumann: Option<bool>,
    /// Contact-line friction, or a table of it per solid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction: Option<Either<DynamicViscosity, Named<DynamicViscosity>>>,
    /// The line rests between these angles.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hysteresis: Option<HysteresisFile>,
}

/// The angles between which a contact line rests: `advancing` and `receding`, or `above` and `below` Young's angle of the
/// place, which is how patterns have it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HysteresisFile {
    /// The line advances above this angle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub advancing: Option<Angle>,
    /// The line recedes below this angle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub receding: Option<Angle>,
    /// The line advances this much above Young's angle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub above: Option<Angle>,
    /// The line recedes this much below Young's angle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub below: Option<Angle>,
}
