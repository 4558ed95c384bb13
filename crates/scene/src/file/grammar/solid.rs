//! Solids, as written in a scene file.

use crate::file::grammar::{AngularVelocity, Density, Length, Pressure, ShapeFile, Speed, Tension, Time};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `[[solid]]`: a solid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SolidFile {
    /// Name, used in `[tension]`, `[expect]` and file names. It has the characters of a scene's name, and is
    /// not `liquid_air`.
    pub name: String,
    /// Density, above 0; required unless the solid is fixed or kinematic.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub density: Option<Density>,
    /// Shape at the start.
    pub shape: ShapeFile,
    /// Mesh of the solid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mesh: Option<SolidMeshFile>,
    /// Material, which also determines whether the solid moves and deforms.
    pub material: MaterialFile,
    /// Velocity at the start of a solid that moves freely or deforms; 0 by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub velocity: Option<Vec<Speed>>,
    /// Collisions with other solids and with the closed sides of the domain.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub collision: Option<CollisionFile>,
    /// Shapes within which the vertices of a deformable solid are fixed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub fixed: Vec<ShapeFile>,
    /// Parts of a deformable solid with prescribed motion.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub moved: Vec<MovedFile>,
}

/// A part of a deformable solid with prescribed motion: a velocity, or keyframes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MovedFile {
    /// Shape that contains the vertices of the part at the start.
    pub shape: ShapeFile,
    /// Constant velocity.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub velocity: Option<Vec<Speed>>,
    /// Displacements at given times: linear in between, constant before and after, 0 at time 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub keyframes: Option<Vec<KeyframeFile>>,
}

/// Coefficients of collisions. For two solids the geometric mean of their coefficients applies, at a side of
/// the domain that of the solid.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CollisionFile {
    /// Restitution of a rigid solid: speed after an impact over that before it; 0 to 1, 0.3 by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub restitution: Option<f64>,
    /// Coefficient of Coulomb friction, 0 or more; 0.3 by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction: Option<f64>,
}

/// Mesh of a solid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SolidMeshFile {
    /// Length of the edges of the mesh, above 0; `dx / 1.5` by default. Not allowed with a volume mesh from a
    /// file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub edge: Option<Length>,
}

/// Material of a solid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum MaterialFile {
    /// Rigid: moves freely, or is fixed.
    Rigid(RigidFile),
    /// Rigid, with prescribed motion.
    Kinematic(KinematicFile),
    /// Deformable: masses and springs, as in the paper.
    Springs(SpringsFile),
    /// Deformable: compressible neo-Hookean solid.
    NeoHookean(ElasticFile),
    /// Deformable: corotated linear elasticity.
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
    /// Whether the solid is fixed; `false` by default.
    #[serde(default)]
    pub fixed: bool,
}

/// `kinematic`: prescribed motion by velocities or by keyframes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct KinematicFile {
    /// Constant velocity; 0 by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub velocity: Option<Vec<Speed>>,
    /// Constant angular velocity, one entry in 2D and three in 3D; 0 by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub angular_velocity: Option<Vec<AngularVelocity>>,
    /// Displacements at given times: linear in between, constant before and after.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub keyframes: Option<Vec<KeyframeFile>>,
}

/// Prescribed displacement at one time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct KeyframeFile {
    /// Time; it increases from one keyframe to the next.
    pub time: Time,
    /// Displacement from the position at the start.
    pub translate: Vec<Length>,
}

/// `springs`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpringsFile {
    /// Stiffness of each spring, above 0.
    pub stiffness: Tension,
    /// Damping ratio of the lowest elastic mode: damping over critical damping; 0 to 100, 0 by default.
    #[serde(default)]
    pub damping_ratio: f64,
}

/// `neo_hookean`, `corotated`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ElasticFile {
    /// Young's modulus, above 0.
    pub young_modulus: Pressure,
    /// Poisson's ratio, -0.99 to 0.499.
    pub poisson_ratio: f64,
    /// Damping ratio of the lowest elastic mode: damping over critical damping; 0 to 100, 0 by default.
    #[serde(default)]
    pub damping_ratio: f64,
}

/// `shell`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ShellFile {
    /// Young's modulus, above 0.
    pub young_modulus: Pressure,
    /// Poisson's ratio, -0.99 to 0.499.
    pub poisson_ratio: f64,
    /// Thickness.
    pub thickness: Length,
    /// Damping ratio of the lowest elastic mode: damping over critical damping; 0 to 100, 0 by default.
    #[serde(default)]
    pub damping_ratio: f64,
}

/// `rod`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RodFile {
    /// Young's modulus, above 0.
    pub young_modulus: Pressure,
    /// Radius of the cross-section.
    pub radius: Length,
    /// Damping ratio of the lowest elastic mode: damping over critical damping; 0 to 100, 0 by default.
    #[serde(default)]
    pub damping_ratio: f64,
}
