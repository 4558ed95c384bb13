//! Solids, as written in a scene file.

use crate::file::grammar::{Density, KeyframeFile, Length, ShapeFile, Speed};
use crate::file::material::MaterialFile;
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
