//! Solids, their tensions and the contact line, as written in a scene file.

use crate::file::{
    Angle, AngularVelocity, Density, DynamicViscosity, Either, Length, Named, Pressure, ShapeFile, Speed,
    Tension, Time,
};
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

/// Wetting of a solid, by one of these: both tensions, the contact angle, or a gradient of it. An image
/// overrides them, and patches override both.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SolidTensionFile {
    /// Tension of the liquid–solid interface, 0 or more; requires `solid_air`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub liquid_solid: Option<Tension>,
    /// Tension of the solid–air interface, 0 or more; requires `liquid_solid`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub solid_air: Option<Tension>,
    /// Contact angle, through the liquid: 0 to 180 degrees.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub contact_angle: Option<Angle>,
    /// Contact angle that varies between two points.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gradient: Option<GradientFile>,
    /// Image of the contact angle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub image: Option<WettingImageFile>,
    /// Parts of the surface with a contact angle of their own. Where patches overlap, the last one counts.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub patches: Vec<PatchFile>,
}

/// `gradient`: the cosine of the contact angle is linear along the line through two points, and constant beyond
/// them. The points are given for the position of the solid at the start; the pattern moves with the solid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GradientFile {
    /// Start of the gradient.
    pub from: AngleAtFile,
    /// End of the gradient.
    pub to: AngleAtFile,
}

/// A contact angle at a point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AngleAtFile {
    /// The point, where the solid is at the start.
    pub point: Vec<Length>,
    /// Contact angle there, 0 to 180 degrees.
    pub contact_angle: Angle,
}

/// `image`: the grey value of a pixel gives the contact angle. The image is projected along the vertical axis;
/// in 2D its middle row lies along x. Cosines are interpolated between the centres of the pixels. Where pixels
/// are transparent, the angle without the image applies.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WettingImageFile {
    /// Path of a `.png` file, relative to the scene file.
    pub file: String,
    /// Position of the lower left corner, seen from above, where the solid is at the start: x and y (2D: x).
    pub lower: Vec<Length>,
    /// Position of the upper right corner; each entry is larger than that of `lower`.
    pub upper: Vec<Length>,
    /// Contact angle of black pixels, 0 to 180 degrees.
    pub black: Angle,
    /// Contact angle of white pixels, 0 to 180 degrees.
    pub white: Angle,
}

/// The part of a solid's surface within a shape, with a contact angle of its own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PatchFile {
    /// The shape, where the solid is at the start. It may extend beyond the solid.
    pub shape: ShapeFile,
    /// Contact angle there, 0 to 180 degrees.
    pub contact_angle: Angle,
}

/// `[contact_line]`: properties of the contact line.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ContactLineFile {
    /// Whether contact lines exert forces; `true` by default. With `false` liquid and solids are coupled by
    /// pressure alone, as in traditional two-way coupling, and all contact angles are 90 degrees; for
    /// comparison.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub enabled: Option<bool>,
    /// Line radius, the paper's R, above 0: distance from the line over which its force is spread along a
    /// deformable solid. By default the force acts at the line.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub radius: Option<Length>,
    /// Whether deformable solids are subject to the tensions of their own surface, `liquid_solid` where it is
    /// wetted and `solid_air` where it is dry, so that three tensions balance at the line (Neumann). Both
    /// tensions must be given. `false` by default: only the balance along the solid holds (Young), and the
    /// tensions are the least that give the contact angle and are not negative.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub neumann: Option<bool>,
    /// Contact-line friction, a force per length and speed, 0 or more: one value, or a table by solid; 0 by
    /// default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction: Option<Either<DynamicViscosity, Named<DynamicViscosity>>>,
    /// Range of contact angles at which the line rests; none by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hysteresis: Option<HysteresisFile>,
}

/// Range of contact angles at which the contact line rests: `advancing` and `receding`, or `above` and `below`,
/// which are relative to Young's angle at each point. Where the contact angle varies over a solid, `above` and
/// `below` are required.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HysteresisFile {
    /// Advancing angle, above which the line advances; 0 to 180 degrees.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub advancing: Option<Angle>,
    /// Receding angle, below which the line recedes; 0 degrees to the advancing angle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub receding: Option<Angle>,
    /// Advancing angle minus Young's angle, 0 to 180 degrees.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub above: Option<Angle>,
    /// Young's angle minus the receding angle, 0 to 180 degrees.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub below: Option<Angle>,
}
