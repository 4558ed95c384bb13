//! Outlines in the plane, and the keys in which an extrusion is written.

use super::rotation::Rotation;
use crate::error::SceneError;
use crate::file::text::{Either, HELP_MARK, Length, Quantity, Si, read_as};
use crate::file::validator::Validator;
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// An outline in the plane.
#[derive(Clone, Debug, PartialEq)]
pub enum Outline {
    /// A named outline and its size across, m.
    Named(OutlineName, f64),
    /// The corners of a polygon, m, each with two entries.
    Points(Vec<Vec<f64>>),
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

/// A flat outline with a thickness (3D only).
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Extrusion")]
pub struct ExtrusionKeys {
    /// Name of an outline, or a list of at least three points of a plane.
    outline: Either<OutlineName, Vec<Vec<Length>>>,
    /// Size of a named outline; required with a name, not allowed with a list of points.
    #[serde(default, skip_serializing_if = "Option::is_none", with = "Si::<Option<Length>>")]
    size: Option<f64>,
    /// Thickness.
    #[serde(with = "Si::<Length>")]
    thickness: f64,
    /// Centre.
    #[serde(with = "Si::<Vec<Length>>")]
    center: Vec<f64>,
    /// Rotation about the centre.
    #[serde(default, skip_serializing_if = "Rotation::is_none")]
    rotation: Rotation,
}

impl Outline {
    pub(super) fn validate(&self, at: &dyn Fn(&str) -> String, v: &Validator) -> Result<(), SceneError> {
        let points = match self {
            Self::Named(_, size) => return v.positive(&at("size"), "the size", *size),
            Self::Points(points) => points,
        };
        if v.source.has(&at("size")) {
            let message = "an outline given as a list of points takes no `size`";
            return Err(v.error(&at("size"), message, "remove `size`"));
        }
        if let Some((i, point)) = points.iter().enumerate().find(|(_, point)| point.len() != 2) {
            let message = format!("found {} entries in this point of the outline", point.len());
            return Err(v.error(&at(&format!("outline.{i}")), message, "give 2 entries"));
        }
        if points.len() < 3 {
            let help = "give three points or more";
            return Err(v.error(&at("outline"), "the outline has fewer than three points", help));
        }
        Ok(())
    }
}

/// Writes an extrusion.
pub fn serialize<S: Serializer>(
    outline: &Outline,
    thickness: &f64,
    center: &[f64],
    rotation: &Rotation,
    s: S,
) -> Result<S::Ok, S::Error> {
    let (outline, size) = match outline {
        Outline::Named(name, size) => (Either::Text(*name), Some(*size)),
        Outline::Points(points) => (Either::Rich(Quantity::of(points)), None),
    };
    let (center, rotation) = (center.to_vec(), rotation.clone());
    ExtrusionKeys { outline, size, thickness: *thickness, center, rotation }.serialize(s)
}

/// Reads the outline, the thickness, the centre and the rotation.
pub fn deserialize<'de, D: Deserializer<'de>>(d: D) -> Result<(Outline, f64, Vec<f64>, Rotation), D::Error> {
    read_as(d, |keys: ExtrusionKeys| {
        let outline = match (keys.outline, keys.size) {
            (Either::Text(name), Some(size)) => Outline::Named(name, size),
            (Either::Text(_), None) => {
                return Err(format!("a named outline needs a size{HELP_MARK}add `size = \"1 cm\"`"));
            }
            (Either::Rich(points), _) => Outline::Points(points.number()),
        };
        Ok((outline, keys.thickness, keys.center, keys.rotation))
    })
}
