//! Shapes in SI units.

use crate::file::grammar::OutlineName;
use std::path::PathBuf;

/// A shape. Lengths are in m; directions have unit length.
#[derive(Clone, Debug, PartialEq)]
pub enum ShapeSpec {
    /// A ball.
    Ball {
        /// Centre, m.
        center: Vec<f64>,
        /// Radius, m.
        radius: f64,
    },
    /// A box.
    Box {
        /// Centre, m.
        center: Vec<f64>,
        /// Half the edge lengths, m.
        half_size: Vec<f64>,
        /// Rotation about the centre.
        rotation: Rotation,
    },
    /// The half-space on the side opposite to the normal.
    HalfSpace {
        /// A point of the plane, m.
        point: Vec<f64>,
        /// Unit normal out of the half-space.
        normal: Vec<f64>,
    },
    /// A circular cylinder, 3D.
    Cylinder {
        /// Centre, m.
        center: Vec<f64>,
        /// Unit direction of the axis.
        axis: Vec<f64>,
        /// Radius, m.
        radius: f64,
        /// Length along the axis, m.
        height: f64,
    },
    /// All points within the radius of a segment.
    Capsule {
        /// One end, m.
        a: Vec<f64>,
        /// The other end, m.
        b: Vec<f64>,
        /// Radius, m.
        radius: f64,
    },
    /// An ellipsoid.
    Ellipsoid {
        /// Centre, m.
        center: Vec<f64>,
        /// Half axes, m.
        radii: Vec<f64>,
        /// Rotation about the centre.
        rotation: Rotation,
    },
    /// A ball with radius `radius (1 + amplitude P_mode(cos θ))`, θ from the last axis; in 2D
    /// `radius (1 + amplitude cos(mode θ))`.
    PerturbedBall {
        /// Centre, m.
        center: Vec<f64>,
        /// Radius, m.
        radius: f64,
        /// Mode number.
        mode: u32,
        /// Amplitude relative to the radius.
        amplitude: f64,
    },
    /// The region where the last coordinate is below `level + amplitude cos(2π x / wavelength + phase)`.
    Wave {
        /// Mean height, m.
        level: f64,
        /// Amplitude, m.
        amplitude: f64,
        /// Wavelength, m.
        wavelength: f64,
        /// Phase, rad.
        phase: f64,
    },
    /// A flat outline with a thickness, 3D.
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
    /// Union.
    Union(Vec<ShapeSpec>),
    /// Union with fillets.
    SmoothUnion {
        /// The parts.
        parts: Vec<ShapeSpec>,
        /// Width of the fillets, m.
        width: f64,
    },
    /// The part of `of` outside `minus`.
    Difference {
        /// The first shape.
        of: Box<ShapeSpec>,
        /// The subtracted shape.
        minus: Box<ShapeSpec>,
    },
    /// A cow.
    Cow {
        /// The point between its feet, m.
        at: Vec<f64>,
        /// Its length, m.
        length: f64,
        /// Rotation about that point.
        rotation: Rotation,
    },
    /// A closed surface or a volume from a file.
    Mesh {
        /// Absolute path of an existing file.
        path: PathBuf,
        /// Metres per unit of the file.
        scale: f64,
        /// Translation, m, applied after scale and rotation.
        translate: Vec<f64>,
        /// Rotation about the file's origin.
        rotation: Rotation,
    },
}

/// An outline in the plane.
#[derive(Clone, Debug, PartialEq)]
pub enum Outline {
    /// A named outline and its size across, m.
    Named(OutlineName, f64),
    /// A polygon, m.
    Points(Vec<[f64; 2]>),
}

/// A rotation; `angle` 0 is none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rotation {
    /// Unit axis; (0, 0, 1) in 2D.
    pub axis: [f64; 3],
    /// Angle, rad, right-handed.
    pub angle: f64,
}

impl Rotation {
    /// No rotation.
    pub const NONE: Self = Self { axis: [0.0, 0.0, 1.0], angle: 0.0 };

    /// The rotation matrix by rows; in 2D its upper left block.
    pub fn matrix(&self) -> [[f64; 3]; 3] {
        let (s, c) = self.angle.sin_cos();
        let [x, y, z] = self.axis;
        let t = 1.0 - c;
        [
            [t * x * x + c, t * x * y - s * z, t * x * z + s * y],
            [t * x * y + s * z, t * y * y + c, t * y * z - s * x],
            [t * x * z - s * y, t * y * z + s * x, t * z * z + c],
        ]
    }
}

impl ShapeSpec {
    /// The mesh file of this shape, if it holds volume elements.
    pub fn volume_file(&self) -> Option<&std::path::Path> {
        let Self::Mesh { path, .. } = self else { return None };
        let ending = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase)?;
        VOLUME_EXTENSIONS.contains(&ending.as_str()).then_some(path)
    }
}

/// Extensions of files with volume elements.
pub(crate) const VOLUME_EXTENSIONS: [&str; 4] = ["msh", "node", "ele", "vtk"];
