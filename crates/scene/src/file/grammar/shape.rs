//! Shapes as written in a scene file.

use crate::file::{Angle, Either, Length, MeshScale};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A shape, of liquid or solid. Points and vectors have as many entries as the scene has dimensions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum ShapeFile {
    /// A ball (2D: a disc).
    Ball(BallFile),
    /// A box, by corners or by centre and size.
    Box(BoxFile),
    /// Everything on the side of a plane that the normal points away from.
    HalfSpace(HalfSpaceFile),
    /// A circular cylinder (3D).
    Cylinder(CylinderFile),
    /// All points nearer than the radius to a segment.
    Capsule(CapsuleFile),
    /// An ellipsoid (2D: an ellipse).
    Ellipsoid(EllipsoidFile),
    /// A ball with radius `r = R (1 + amplitude P_mode(cos θ))`, θ from the last axis (2D: `cos mode θ`).
    PerturbedBall(PerturbedBallFile),
    /// Everything below a cosine wave along x.
    Wave(WaveFile),
    /// A flat outline of some thickness (3D).
    Extrusion(ExtrusionFile),
    /// What any of the shapes fills.
    Union(Vec<ShapeFile>),
    /// What shapes fill that melt into each other.
    SmoothUnion(SmoothUnionFile),
    /// What `of` fills and `minus` does not.
    Difference(DifferenceFile),
    /// A cow.
    Cow(CowFile),
    /// A closed surface, or a volume of triangles (2D) or tetrahedra (3D), from a file.
    Mesh(MeshFile),
}

/// `ball`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BallFile {
    /// Centre.
    pub center: Vec<Length>,
    /// Radius.
    pub radius: Length,
}

/// `box`: `lower` and `upper`, or `center`, `size` and perhaps `rotation`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoxFile {
    /// Lower corner.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lower: Option<Vec<Length>>,
    /// Upper corner.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub upper: Option<Vec<Length>>,
    /// Centre.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub center: Option<Vec<Length>>,
    /// Edge lengths.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub size: Option<Vec<Length>>,
    /// Rotation about the centre.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotation: Option<RotationFile>,
}

/// A rotation: an angle (2D) or `{ axis, angle }` (3D).
pub type RotationFile = Either<Angle, AxisAngleFile>;

/// A rotation about an axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AxisAngleFile {
    /// Direction of the axis: three pure numbers.
    pub axis: Vec<f64>,
    /// Angle, right-handed.
    pub angle: Angle,
}

/// `half_space`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HalfSpaceFile {
    /// A point of the plane.
    pub point: Vec<Length>,
    /// Direction out of the filled side: pure numbers.
    pub normal: Vec<f64>,
}

/// `cylinder`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CylinderFile {
    /// Centre.
    pub center: Vec<Length>,
    /// Direction of the axis: pure numbers.
    pub axis: Vec<f64>,
    /// Radius.
    pub radius: Length,
    /// Length along the axis.
    pub height: Length,
}

/// `capsule`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CapsuleFile {
    /// One end of the segment.
    pub a: Vec<Length>,
    /// The other end.
    pub b: Vec<Length>,
    /// Radius.
    pub radius: Length,
}

/// `ellipsoid`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EllipsoidFile {
    /// Centre.
    pub center: Vec<Length>,
    /// Half axes.
    pub radii: Vec<Length>,
    /// Rotation about the centre.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotation: Option<RotationFile>,
}

/// `perturbed_ball`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PerturbedBallFile {
    /// Centre.
    pub center: Vec<Length>,
    /// Radius of the ball.
    pub radius: Length,
    /// Mode number, 2 or more.
    pub mode: u32,
    /// Amplitude as a fraction of the radius: a pure number.
    pub amplitude: f64,
}

/// `wave`: filled where the last coordinate is below `level + amplitude cos(2π x / wavelength + phase)`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WaveFile {
    /// Mean height.
    pub level: Length,
    /// Amplitude.
    pub amplitude: Length,
    /// Wavelength.
    pub wavelength: Length,
    /// Phase at x = 0; a crest without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub phase: Option<Angle>,
}

/// `extrusion`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ExtrusionFile {
    /// A named outline or a list of points in the plane.
    pub outline: Either<OutlineName, Vec<Vec<Length>>>,
    /// Size of a named outline across; needed with a name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub size: Option<Length>,
    /// Thickness.
    pub thickness: Length,
    /// Centre.
    pub center: Vec<Length>,
    /// Rotation about the centre.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotation: Option<RotationFile>,
}

/// A named outline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum OutlineName {
    /// A square.
    #[serde(rename = "square")]
    Square,
    /// An equilateral triangle.
    #[serde(rename = "triangle")]
    Triangle,
    /// Four petals.
    #[serde(rename = "petals-4")]
    Petals4,
    /// Six petals.
    #[serde(rename = "petals-6")]
    Petals6,
    /// A cross.
    #[serde(rename = "cross")]
    Cross,
    /// A leaf.
    #[serde(rename = "leaf")]
    Leaf,
}

/// `smooth_union`: as a union, with fillets where two parts meet.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SmoothUnionFile {
    /// The parts.
    pub parts: Vec<ShapeFile>,
    /// Width of the fillets: parts that are farther apart than this do not change each other.
    pub width: Length,
}

/// `cow`: body, head, legs, horns and tail. It looks along x, and up is the last axis; in 2D it is seen from the side. Its
/// thinnest parts are a twentieth of its length thick.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CowFile {
    /// The point that it stands at: between its feet, on their height.
    pub at: Vec<Length>,
    /// From its rump to its muzzle; it is 0.85 times as high and 0.4 times as wide.
    pub length: Length,
    /// Rotation about `at`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotation: Option<RotationFile>,
}

/// `difference`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DifferenceFile {
    /// The shape that is cut.
    pub of: Box<ShapeFile>,
    /// The shape that is taken away.
    pub minus: Box<ShapeFile>,
}

/// `mesh`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeshFile {
    /// Path, relative to the scene file. Closed surfaces (2D: closed lines): `.obj`, `.ply`, `.stl` (3D). Volumes, whose
    /// elements a solid that deforms takes over: `.msh` (Gmsh 2.2, 4.1), `.node` with `.ele` (TetGen, Triangle), `.vtk`.
    /// `builtin:duck.obj` and `builtin:leaf.msh` come with the program.
    pub file: String,
    /// Metres per unit of the file; 1 without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scale: Option<MeshScale>,
    /// Moved by, after scale and rotation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub translate: Option<Vec<Length>>,
    /// Rotation about the file's origin.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotation: Option<RotationFile>,
}
