//! The keys in which an extrusion is written.

use super::rotation::Rotation;
use super::spec::{Outline, OutlineName};
use crate::file::text::{Either, HELP_MARK, Length, Quantity, Si, read_as};
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

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
