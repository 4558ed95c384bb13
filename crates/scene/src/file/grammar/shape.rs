//! Shapes as written in a scene file.

use crate::file::grammar::{Angle, Either, Length, MeshScale};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A shape of liquid or of a solid. Points and vectors have one entry for each dimension of the scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum ShapeFile {
    /// A ball (2D: a disc).
    Ball(BallFile),
    /// A box, given by two corners or by centre and size.
    Box(BoxFile),
    /// The half space on the side of a plane that the normal points away from.
    HalfSpace(HalfSpaceFile),
    /// A circular cylinder (3D only).
    Cylinder(CylinderFile),
    /// All points within a radius of a line segment.
    Capsule(CapsuleFile),
    /// An ellipsoid (2D: an ellipse).
    Ellipsoid(EllipsoidFile),
    /// A ball with the radius `r = R (1 + amplitude P_mode(cos θ))`, with θ from the last axis; in 2D `r = R (1
    /// + amplitude cos(mode θ))`, with θ from the first axis.
    PerturbedBall(PerturbedBallFile),
    /// The region below a cosine wave along x; for liquid only.
    Wave(WaveFile),
    /// A flat outline with a thickness (3D only).
    Extrusion(ExtrusionFile),
    /// The union of shapes: all points within any of them.
    Union(Vec<ShapeFile>),
    /// The union of shapes with fillets where they meet.
    SmoothUnion(SmoothUnionFile),
    /// All points of the shape `of` that are not in the shape `minus`.
    Difference(DifferenceFile),
    /// A cow.
    Cow(CowFile),
    /// A closed surface, or a volume mesh of triangles (2D) or tetrahedra (3D), from a file.
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

/// `box`: `lower` and `upper`, or `center`, `size` and optionally `rotation`.
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
    /// Angle of the rotation, right-handed about the axis.
    pub angle: Angle,
}

/// `half_space`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HalfSpaceFile {
    /// A point of the plane.
    pub point: Vec<Length>,
    /// Normal of the plane, out of the half space: pure numbers.
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
    /// Radius R of the unperturbed ball.
    pub radius: Length,
    /// Mode number, 2 to 64.
    pub mode: u32,
    /// Amplitude over the radius: a pure number, -0.9 to 0.9.
    pub amplitude: f64,
}

/// `wave`: the region where the last coordinate is below `level + amplitude cos(2π x / wavelength + phase)`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WaveFile {
    /// Mean height.
    pub level: Length,
    /// Amplitude, 0 or more.
    pub amplitude: Length,
    /// Wavelength.
    pub wavelength: Length,
    /// Phase at x = 0; 0 by default, which is a crest.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub phase: Option<Angle>,
}

/// `extrusion`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ExtrusionFile {
    /// Name of an outline, or a list of at least three points of a plane.
    pub outline: Either<OutlineName, Vec<Vec<Length>>>,
    /// Size of a named outline; required with a name, not allowed with a list of points.
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
    /// A square; the size is its side.
    #[serde(rename = "square")]
    Square,
    /// An equilateral triangle; the size is its side.
    #[serde(rename = "triangle")]
    Triangle,
    /// Four petals; the size is the diameter of the circle through their tips.
    #[serde(rename = "petals-4")]
    Petals4,
    /// Six petals; the size is the diameter of the circle through their tips.
    #[serde(rename = "petals-6")]
    Petals6,
    /// A cross of five squares joined by bridges; the size is the distance of opposite ends.
    #[serde(rename = "cross")]
    Cross,
    /// A leaf; the size is the distance of its two tips, and its width is half of it.
    #[serde(rename = "leaf")]
    Leaf,
}

/// `smooth_union`: a union with fillets where parts meet.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SmoothUnionFile {
    /// The parts, at least one, none of them unbounded.
    pub parts: Vec<ShapeFile>,
    /// Width of the fillets: parts that are farther apart than this do not affect each other.
    pub width: Length,
}

/// `cow`: a cow with body, head, legs, horns, ears and tail. It faces along x, and its up direction is the last
/// axis; in 2D it is a side view. Its thinnest parts are a twentieth of its length thick.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CowFile {
    /// Point between the feet, at the height of their soles.
    pub at: Vec<Length>,
    /// Length from rump to muzzle. The height is 0.85 of it, the width 0.35.
    pub length: Length,
    /// Rotation about `at`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotation: Option<RotationFile>,
}

/// `difference`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DifferenceFile {
    /// Shape from which `minus` is subtracted.
    pub of: Box<ShapeFile>,
    /// Subtracted shape.
    pub minus: Box<ShapeFile>,
}

/// `mesh`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeshFile {
    /// Path of the file, relative to the scene file. Closed surfaces (2D: closed lines) are `.obj`, `.ply` and
    /// `.stl` (3D only). Volume meshes, whose elements a deformable solid keeps, are `.msh` (Gmsh 2.2, 4.1),
    /// `.node` with `.ele` (TetGen, Triangle) and `.vtk`. Built-in files are `builtin:duck.obj` and
    /// `builtin:leaf.msh`.
    pub file: String,
    /// Length of one unit of the file, above 0; 1 m by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scale: Option<MeshScale>,
    /// Translation after scaling and rotation; 0 by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub translate: Option<Vec<Length>>,
    /// Rotation about the origin of the file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotation: Option<RotationFile>,
}
