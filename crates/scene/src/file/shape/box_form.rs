//! The two forms in which a box is written.

use super::rotation::Rotation;
use crate::file::text::{HELP_MARK, Length, Si, read_as};
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// A box: `lower` and `upper`, or `center`, `size` and optionally `rotation`.
#[derive(Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Box")]
pub struct BoxKeys {
    /// Lower corner.
    #[serde(default, skip_serializing_if = "Option::is_none", with = "Si::<Option<Vec<Length>>>")]
    lower: Option<Vec<f64>>,
    /// Upper corner.
    #[serde(default, skip_serializing_if = "Option::is_none", with = "Si::<Option<Vec<Length>>>")]
    upper: Option<Vec<f64>>,
    /// Centre.
    #[serde(default, skip_serializing_if = "Option::is_none", with = "Si::<Option<Vec<Length>>>")]
    center: Option<Vec<f64>>,
    /// Edge lengths.
    #[serde(default, skip_serializing_if = "Option::is_none", with = "Si::<Option<Vec<Length>>>")]
    size: Option<Vec<f64>>,
    /// Rotation about the centre.
    #[serde(default, skip_serializing_if = "Rotation::is_none")]
    rotation: Rotation,
}

/// Writes a box by its centre and size, m.
pub fn serialize<S: Serializer>(
    center: &[f64],
    half_size: &[f64],
    rotation: &Rotation,
    s: S,
) -> Result<S::Ok, S::Error> {
    let size = half_size.iter().map(|h| 2.0 * h).collect();
    let rotation = rotation.clone();
    BoxKeys { center: Some(center.to_vec()), size: Some(size), rotation, ..BoxKeys::default() }.serialize(s)
}

/// Reads either form as centre, half size and rotation.
pub fn deserialize<'de, D: Deserializer<'de>>(d: D) -> Result<(Vec<f64>, Vec<f64>, Rotation), D::Error> {
    read_as(d, |keys: BoxKeys| match (keys.lower, keys.upper, keys.center, keys.size) {
        (Some(lower), Some(upper), None, None) => {
            let each = |of: fn(f64, f64) -> f64| lower.iter().zip(&upper).map(|(l, u)| of(*l, *u)).collect();
            Ok((each(|l, u| 0.5 * (l + u)), each(|l, u| 0.5 * (u - l)), keys.rotation))
        }
        (None, None, Some(center), Some(size)) => {
            Ok((center, size.iter().map(|s| 0.5 * s).collect(), keys.rotation))
        }
        _ => Err(format!(
            "these keys do not define the box{HELP_MARK}give `lower` and `upper`, or `center` and `size` \
             (optionally with `rotation`)"
        )),
    })
}
