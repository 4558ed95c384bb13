//! `[expect]`: what is checked at the end of a run.

use super::repairs::RepairsFile;
use crate::file::grammar::{Angle, Either, Frequency, Length, Speed, Time};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `[expect]`: expected results. Every key that is given is checked at the end of the run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ExpectFile {
    /// Largest volume error of the run: differences between measured and target volumes, summed over the
    /// components, over the volume of the liquid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub volume_drift: Option<MaxFile>,
    /// Largest momentum error of the run: momentum that does not come from gravity, over that of all the liquid
    /// at its largest root mean square speed. It is not defined, and the check fails, where solids are fixed,
    /// kinematic or anchored.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub momentum_error: Option<MaxFile>,
    /// Largest growth of the total energy since the start, over the largest of the kinetic, surface, elastic
    /// and potential energy at the start. Energy that left through open sides is included.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub energy_growth: Option<MaxFile>,
    /// Largest accepted repairs of the run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub repairs: Option<RepairsFile>,
    /// Largest velocity component of the liquid at the end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_speed: Option<MaxSpeedFile>,
    /// Period of an oscillation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub period: Option<PeriodFile>,
    /// Frequency of an oscillation; given instead of `period`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frequency: Option<FrequencyFile>,
    /// Mean contact angle on solids at the end.
    #[serde(default, skip_serializing_if = "Vec::is_empty", with = "one_or_many")]
    #[schemars(with = "Either<ContactAngleFile, Vec<ContactAngleFile>>")]
    pub contact_angle: Vec<ContactAngleFile>,
    /// Number of drops, that is connected components of the liquid, at the end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drops: Option<DropsFile>,
    /// Extent of the liquid towards sides of the domain at the end.
    #[serde(default, skip_serializing_if = "Vec::is_empty", with = "one_or_many")]
    #[schemars(with = "Either<ReachFile, Vec<ReachFile>>")]
    pub reach: Vec<ReachFile>,
    /// Solids that float at the end: partly wetted, by less than 98 % of their surface, and carried by the
    /// liquid alone.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub floats: Vec<String>,
    /// Solids that are submerged at the end: at least 98 % of their surface is wetted.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sinks: Vec<String>,
    /// Wetted fraction of solids at the end.
    #[serde(default, skip_serializing_if = "Vec::is_empty", with = "one_or_many")]
    #[schemars(with = "Either<WettedFile, Vec<WettedFile>>")]
    pub wetted: Vec<WettedFile>,
    /// Position of solids at the end.
    #[serde(default, skip_serializing_if = "Vec::is_empty", with = "one_or_many")]
    #[schemars(with = "Either<PositionFile, Vec<PositionFile>>")]
    pub position: Vec<PositionFile>,
    /// Deflection of deformable solids at the end.
    #[serde(default, skip_serializing_if = "Vec::is_empty", with = "one_or_many")]
    #[schemars(with = "Either<DeflectionFile, Vec<DeflectionFile>>")]
    pub deflection: Vec<DeflectionFile>,
}

/// An upper bound, 0 or more.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MaxFile {
    /// The bound.
    pub max: f64,
}

/// An upper bound of a speed, 0 or more.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MaxSpeedFile {
    /// The bound.
    pub max: Speed,
}

/// A period, measured from the maxima of the kinetic energy, of which each period has two.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PeriodFile {
    /// Mode number, for information only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mode: Option<u32>,
    /// Expected period, above 0.
    pub value: Time,
    /// Accepted relative deviation, above 0.
    pub tolerance: f64,
}

/// A frequency, measured as the inverse of a period.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FrequencyFile {
    /// Mode number, for information only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mode: Option<u32>,
    /// Expected frequency, above 0.
    pub value: Frequency,
    /// Accepted relative deviation, above 0.
    pub tolerance: f64,
}

/// An expected contact angle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ContactAngleFile {
    /// Name of the solid, or `walls` for the closed sides of the domain if no solid has this name.
    pub solid: String,
    /// Expected angle, 0 to 180 degrees; Young's angle by default. Required where the angle varies over the
    /// solid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub value: Option<Angle>,
    /// Accepted deviation, above 0.
    pub tolerance: Angle,
}

/// An expected number of drops: `count`, or `min`, `max` or both.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DropsFile {
    /// Exact number.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub count: Option<u32>,
    /// Smallest accepted number.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub min: Option<u32>,
    /// Largest accepted number.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max: Option<u32>,
}

/// An expected extent of the liquid towards a side of the domain.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ReachFile {
    /// Side of the domain.
    pub side: Side,
    /// Expected coordinate of the liquid's outermost point towards this side, along the axis of the side.
    pub value: Length,
    /// Accepted deviation, above 0.
    pub tolerance: Length,
}

/// An expected wetted fraction of a solid's surface, 0 to 1: `min`, `max` or both.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WettedFile {
    /// Name of the solid.
    pub solid: String,
    /// Smallest accepted fraction.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub min: Option<f64>,
    /// Largest accepted fraction.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max: Option<f64>,
}

/// An expected deflection of a deformable solid: `min`, `max` or both. The deflection is the largest
/// displacement of a point of the solid from its place at the start, less the rigid motion of the anchored
/// parts, or of the whole solid if it has none.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DeflectionFile {
    /// Name of the solid.
    pub solid: String,
    /// Smallest accepted deflection, 0 or more.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub min: Option<Length>,
    /// Largest accepted deflection, 0 or more.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max: Option<Length>,
}

/// An expected centre of mass of a solid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PositionFile {
    /// Name of the solid.
    pub solid: String,
    /// Expected centre of mass.
    pub value: Vec<Length>,
    /// Accepted distance from it, above 0.
    pub tolerance: Length,
    /// Direction along which alone the distance is measured, for a solid that is free to move in others: pure
    /// numbers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub along: Option<Vec<f64>>,
}

/// A side of the domain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// Lower end of x.
    Left,
    /// Upper end of x.
    Right,
    /// Lower end of y (3D only).
    Front,
    /// Upper end of y (3D only).
    Back,
    /// Lower end of the last axis.
    Bottom,
    /// Upper end of the last axis.
    Top,
}

/// A table, or a list of such tables.
mod one_or_many {
    use serde::de::value::MapAccessDeserializer;
    use serde::de::{Deserialize, Deserializer, MapAccess, SeqAccess, Visitor};
    use serde::ser::{Serialize, Serializer};
    use std::fmt;
    use std::marker::PhantomData;

    pub fn serialize<T: Serialize, S: Serializer>(list: &[T], s: S) -> Result<S::Ok, S::Error> {
        match list {
            [one] => one.serialize(s),
            many => many.serialize(s),
        }
    }

    pub fn deserialize<'de, T: Deserialize<'de>, De: Deserializer<'de>>(d: De) -> Result<Vec<T>, De::Error> {
        struct V<T>(PhantomData<T>);
        impl<'de, T: Deserialize<'de>> Visitor<'de> for V<T> {
            type Value = Vec<T>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a table or a list of tables")
            }

            fn visit_map<M: MapAccess<'de>>(self, map: M) -> Result<Vec<T>, M::Error> {
                Ok(vec![T::deserialize(MapAccessDeserializer::new(map))?])
            }

            fn visit_seq<S: SeqAccess<'de>>(self, mut seq: S) -> Result<Vec<T>, S::Error> {
                let mut out = Vec::new();
                while let Some(item) = seq.next_element()? {
                    out.push(item);
                }
                Ok(out)
            }
        }
        d.deserialize_any(V(PhantomData))
    }
}
