//! Shapes of liquid and of solids.

use super::extrusion_form::Outline;
use super::rotation::Rotation;
use super::{box_form, extrusion_form};
use crate::file::text::{Angle, Length, MeshScale, Si};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// A shape of liquid or of a solid. Points and vectors have one entry for each dimension of the scene.
// In memory all numbers are in m and rad, and directions have unit length.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[schemars(rename = "Shape")]
pub enum ShapeSpec {
    /// A ball (2D: a disc).
    Ball {
        /// Centre.
        #[serde(with = "Si::<Vec<Length>>")]
        center: Vec<f64>,
        /// Radius.
        #[serde(with = "Si::<Length>")]
        radius: f64,
    },
    /// A box, given by two corners or by centre and size.
    #[serde(with = "box_form")]
    #[schemars(with = "box_form::BoxKeys")]
    Box {
        /// Centre, m.
        center: Vec<f64>,
        /// Half the edge lengths, m.
        half_size: Vec<f64>,
        /// Rotation about the centre.
        rotation: Rotation,
    },
    /// The half space on the side of a plane that the normal points away from.
    HalfSpace {
        /// A point of the plane.
        #[serde(with = "Si::<Vec<Length>>")]
        point: Vec<f64>,
        /// Normal of the plane, out of the half space: pure numbers.
        normal: Vec<f64>,
    },
    /// A circular cylinder (3D only).
    Cylinder {
        /// Centre.
        #[serde(with = "Si::<Vec<Length>>")]
        center: Vec<f64>,
        /// Direction of the axis: pure numbers.
        axis: Vec<f64>,
        /// Radius.
        #[serde(with = "Si::<Length>")]
        radius: f64,
        /// Length along the axis.
        #[serde(with = "Si::<Length>")]
        height: f64,
    },
    /// All points within a radius of a line segment.
    Capsule {
        /// One end of the segment.
        #[serde(with = "Si::<Vec<Length>>")]
        a: Vec<f64>,
        /// The other end.
        #[serde(with = "Si::<Vec<Length>>")]
        b: Vec<f64>,
        /// Radius.
        #[serde(with = "Si::<Length>")]
        radius: f64,
    },
    /// An ellipsoid (2D: an ellipse).
    Ellipsoid {
        /// Centre.
        #[serde(with = "Si::<Vec<Length>>")]
        center: Vec<f64>,
        /// Half axes.
        #[serde(with = "Si::<Vec<Length>>")]
        radii: Vec<f64>,
        /// Rotation about the centre.
        #[serde(default, skip_serializing_if = "Rotation::is_none")]
        rotation: Rotation,
    },
    /// A ball with the radius `r = R (1 + amplitude P_mode(cos θ))`, with θ from the last axis; in 2D `r = R (1
    /// + amplitude cos(mode θ))`, with θ from the first axis.
    PerturbedBall {
        /// Centre.
        #[serde(with = "Si::<Vec<Length>>")]
        center: Vec<f64>,
        /// Radius R of the unperturbed ball.
        #[serde(with = "Si::<Length>")]
        radius: f64,
        /// Mode number, 2 to 64.
        mode: u32,
        /// Amplitude over the radius: a pure number, -0.9 to 0.9.
        amplitude: f64,
    },
    /// The region below a cosine wave along x, where the last coordinate is below `level + amplitude cos(2π x /
    /// wavelength + phase)`; for liquid only.
    Wave {
        /// Mean height.
        #[serde(with = "Si::<Length>")]
        level: f64,
        /// Amplitude, 0 or more.
        #[serde(with = "Si::<Length>")]
        amplitude: f64,
        /// Wavelength.
        #[serde(with = "Si::<Length>")]
        wavelength: f64,
        /// Phase at x = 0; 0 by default, which is a crest.
        #[serde(default, with = "Si::<Angle>")]
        phase: f64,
    },
    /// A flat outline with a thickness (3D only).
    #[serde(with = "extrusion_form")]
    #[schemars(with = "extrusion_form::ExtrusionKeys")]
    Extrusion {
        /// The outline.
        outline: Outline,
        /// Thickness, m.
        thickness: f64,
        /// Centre, m.
        center: Vec<f64>,
        /// Rotation about the centre.
        rotation: Rotation,
    },
    /// The union of shapes: all points within any of them.
    Union(Vec<ShapeSpec>),
    /// The union of shapes with fillets where they meet.
    SmoothUnion {
        /// The parts, at least one, none of them unbounded.
        parts: Vec<ShapeSpec>,
        /// Width of the fillets: parts that are farther apart than this do not affect each other.
        #[serde(with = "Si::<Length>")]
        width: f64,
    },
    /// All points of the shape `of` that are not in the shape `minus`.
    Difference {
        /// Shape from which `minus` is subtracted.
        of: Box<ShapeSpec>,
        /// Subtracted shape.
        minus: Box<ShapeSpec>,
    },
    /// A cow with body, head, legs, horns, ears and tail. It faces along x, and its up direction is the last axis; in
    /// 2D it is a side view. Its thinnest parts are a twentieth of its length thick.
    Cow {
        /// Point between the feet, at the height of their soles.
        #[serde(with = "Si::<Vec<Length>>")]
        at: Vec<f64>,
        /// Length from rump to muzzle. The height is 0.85 of it, the width 0.35.
        #[serde(with = "Si::<Length>")]
        length: f64,
        /// Rotation about `at`.
        #[serde(default, skip_serializing_if = "Rotation::is_none")]
        rotation: Rotation,
    },
    /// A closed surface, or a volume mesh of triangles (2D) or tetrahedra (3D), from a file.
    Mesh {
        /// Path of the file, relative to the scene file. Closed surfaces (2D: closed lines) are `.obj`, `.ply` and
        /// `.stl` (3D only). Volume meshes, whose elements a deformable solid keeps, are `.msh` (Gmsh 2.2, 4.1),
        /// `.node` with `.ele` (TetGen, Triangle) and `.vtk`. Built-in files are `builtin:box-net.msh`,
        /// `builtin:duck.obj` and `builtin:leaf.msh`.
        #[serde(rename = "file")]
        path: PathBuf,
        /// Length of one unit of the file, above 0; 1 m by default.
        #[serde(default = "one", with = "Si::<MeshScale>")]
        scale: f64,
        /// Translation after scaling and rotation; 0 by default.
        #[serde(default, skip_serializing_if = "Vec::is_empty", with = "Si::<Vec<Length>>")]
        translate: Vec<f64>,
        /// Rotation about the origin of the file.
        #[serde(default, skip_serializing_if = "Rotation::is_none")]
        rotation: Rotation,
    },
}

fn one() -> f64 {
    1.0
}

/// Extensions of files with volume elements.
pub(crate) const VOLUME_EXTENSIONS: [&str; 4] = ["msh", "node", "ele", "vtk"];

impl ShapeSpec {
    /// This shape and all its parts, recursively.
    pub fn parts(&self) -> Vec<&Self> {
        let within: Vec<&Self> = match self {
            Self::Union(list) | Self::SmoothUnion { parts: list, .. } => list.iter().collect(),
            Self::Difference { of, minus } => vec![of, minus],
            _ => Vec::new(),
        };
        std::iter::once(self).chain(within.into_iter().flat_map(Self::parts)).collect()
    }

    /// The mesh file of this shape, if it holds volume elements.
    pub fn volume_file(&self) -> Option<&Path> {
        let Self::Mesh { path, .. } = self else { return None };
        let ending = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase)?;
        VOLUME_EXTENSIONS.contains(&ending.as_str()).then_some(path)
    }
}
