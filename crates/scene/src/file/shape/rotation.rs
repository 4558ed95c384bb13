//! Rotations of shapes.

use crate::error::SceneError;
use crate::file::text::{Angle, Either, Si};
use crate::file::validator::Validator;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;

/// A rotation: an angle (2D) or `{ axis, angle }` (3D); `angle` 0 is none.
#[derive(Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(from = "Either<Angle, AxisAngle>", into = "Either<Angle, AxisAngle>")]
#[schemars(inline)]
pub struct Rotation {
    /// Axis, of unit length; none in 2D.
    pub axis: Vec<f64>,
    /// Angle, rad, right-handed about the axis.
    pub angle: f64,
}

/// A rotation about an axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct AxisAngle {
    /// Direction of the axis: three pure numbers.
    axis: Vec<f64>,
    /// Angle of the rotation, right-handed about the axis.
    #[serde(with = "Si::<Angle>")]
    angle: f64,
}

impl From<Either<Angle, AxisAngle>> for Rotation {
    fn from(written: Either<Angle, AxisAngle>) -> Self {
        match written {
            Either::Text(angle) => Self { axis: Vec::new(), angle: angle.0 },
            Either::Rich(AxisAngle { axis, angle }) => Self { axis, angle },
        }
    }
}

impl From<Rotation> for Either<Angle, AxisAngle> {
    fn from(Rotation { axis, angle }: Rotation) -> Self {
        if axis.is_empty() { Self::Text(Angle(angle)) } else { Self::Rich(AxisAngle { axis, angle }) }
    }
}

/// The same text in 2D as in 3D, as it enters the identity of a scene.
impl fmt::Debug for Rotation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let axis = self.unit_axis();
        f.debug_struct("Rotation").field("axis", &axis).field("angle", &self.angle).finish()
    }
}

impl Default for Rotation {
    fn default() -> Self {
        Self::NONE
    }
}

impl Rotation {
    /// No rotation.
    pub const NONE: Self = Self { axis: Vec::new(), angle: 0.0 };

    /// Whether nothing is rotated.
    pub fn is_none(&self) -> bool {
        *self == Self::NONE
    }

    /// The axis; (0, 0, 1) in 2D.
    pub fn unit_axis(&self) -> [f64; 3] {
        <[f64; 3]>::try_from(self.axis.as_slice()).unwrap_or([0.0, 0.0, 1.0])
    }

    /// The rotation matrix by rows; in 2D its upper left block.
    pub fn matrix(&self) -> [[f64; 3]; 3] {
        let (s, c) = self.angle.sin_cos();
        let [x, y, z] = self.unit_axis();
        let t = 1.0 - c;
        [
            [t * x * x + c, t * x * y - s * z, t * x * z + s * y],
            [t * x * y + s * z, t * y * y + c, t * y * z - s * x],
            [t * x * z - s * y, t * y * z + s * x, t * z * z + c],
        ]
    }

    /// Checks the form for the number of dimensions; makes the axis one of unit length.
    ///
    /// # Errors
    /// [`SceneError`] at the rotation or its axis.
    pub(in crate::file) fn validate(&mut self, path: &str, v: &Validator) -> Result<(), SceneError> {
        let axis = format!("{path}.axis");
        let has_axis = v.source.has(&axis);
        if v.dim == 2 && has_axis {
            let help = "give the angle only, such as \"30 deg\"";
            return Err(v.error(path, "a rotation in 2 dimensions takes no axis", help));
        }
        if v.dim == 3 && has_axis {
            v.direction(&axis, &mut self.axis, 3)?;
        } else if v.dim == 3 && v.source.has(path) {
            let help = "give an axis and an angle, such as { axis = [0, 0, 1], angle = \"30 deg\" }";
            return Err(v.error(path, "a rotation in 3 dimensions needs an axis", help));
        }
        if self.angle == 0.0 && self.unit_axis() == [0.0, 0.0, 1.0] {
            *self = Self::NONE;
        }
        Ok(())
    }
}
