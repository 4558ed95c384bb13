//! Tensions, patterns of the contact angle and the contact line, as written in a scene file.

use crate::file::grammar::{Angle, DynamicViscosity, Either, Length, Named, ShapeFile, Tension};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Error as _, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::borrow::Cow;
use std::fmt;

/// `[tension]`: `liquid_air` and one key per solid.
#[derive(Clone, Debug, PartialEq)]
pub struct TensionFile {
    /// Surface tension of the liquid, N/m.
    pub liquid_air: Tension,
    /// Wetting of the solids, by name.
    pub solids: Vec<(String, SolidTensionFile)>,
}

impl<'de> Deserialize<'de> for TensionFile {
    fn deserialize<De: Deserializer<'de>>(d: De) -> Result<Self, De::Error> {
        struct V;
        impl<'de> Visitor<'de> for V {
            type Value = TensionFile;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a table with `liquid_air` and one key per solid")
            }

            fn visit_map<M: MapAccess<'de>>(self, mut map: M) -> Result<TensionFile, M::Error> {
                let mut liquid_air = None;
                let mut solids = Vec::new();
                while let Some(key) = map.next_key::<String>()? {
                    if key == "liquid_air" {
                        liquid_air = Some(map.next_value()?);
                    } else {
                        solids.push((key, map.next_value()?));
                    }
                }
                let liquid_air = liquid_air.ok_or_else(|| M::Error::missing_field("liquid_air"))?;
                Ok(TensionFile { liquid_air, solids })
            }
        }
        d.deserialize_map(V)
    }
}

impl Serialize for TensionFile {
    fn serialize<S: Serializer>(&self, s: S) -> Result<S::Ok, S::Error> {
        use serde::ser::SerializeMap as _;
        let mut map = s.serialize_map(Some(1 + self.solids.len()))?;
        map.serialize_entry("liquid_air", &self.liquid_air)?;
        for (name, value) in &self.solids {
            map.serialize_entry(name, value)?;
        }
        map.end()
    }
}

impl JsonSchema for TensionFile {
    fn schema_name() -> Cow<'static, str> {
        "Tensions".into()
    }

    fn json_schema(g: &mut SchemaGenerator) -> Schema {
        let mut liquid_air = g.subschema_for::<Tension>();
        liquid_air.insert("description".into(), "Surface tension of the liquid, above 0.".into());
        let mut solid = g.subschema_for::<SolidTensionFile>();
        solid.insert("description".into(), "Wetting of a solid; contact angle 90 degrees by default.".into());
        json_schema!({
            "description": "`[tension]`: surface tension of the liquid, and wetting of the solids.",
            "type": "object",
            "properties": { "liquid_air": liquid_air },
            "required": ["liquid_air"],
            "additionalProperties": solid,
        })
    }
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
