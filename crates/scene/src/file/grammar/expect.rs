//! `[expect]`: what is checked at the end of a run.

use crate::file::{Angle, Frequency, Length, RepairsFile, Speed, Time};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `[expect]`. Every key that is given is checked.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ExpectFile {
    /// Worst relative change of the liquid's volume.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub volume_drift: Option<MaxFile>,
    /// Relative error of momentum.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub momentum_error: Option<MaxFile>,
    /// Growth of the total energy over its start, relative to the largest kind of energy there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub energy_growth: Option<MaxFile>,
    /// Largest repairs of the run that are accepted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub repairs: Option<RepairsFile>,
    /// Largest speed at the end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_speed: Option<MaxSpeedFile>,
    /// Period of the oscillation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub period: Option<PeriodFile>,
    /// Frequency of the oscillation; instead of `period`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frequency: Option<FrequencyFile>,
    /// Contact angle on solids at the end.
    #[serde(default, skip_serializing_if = "Vec::is_empty", with = "one_or_many")]
    #[schemars(with = "crate::file::Either<ContactAngleFile, Vec<ContactAngleFile>>")]
    pub contact_angle: Vec<ContactAngleFile>,
    /// Connected components of the liquid at the end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drops: Option<DropsFile>,
    /// How far the liquid reaches at the end.
    #[serde(default, skip_serializing_if = "Vec::is_empty", with = "one_or_many")]
    #[schemars(with = "crate::file::Either<ReachFile, Vec<ReachFile>>")]
    pub reach: Vec<ReachFile>,
    /// Solids that the liquid carries at the end: wetted in part, and nothing else holds them up.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub floats: Vec<String>,
    /// Solids that are wholly under the liquid's surface at the end.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sinks: Vec<String>,
    /// How much of solids is wetted at the end.
    #[serde(default, skip_serializing_if = "Vec::is_empty", with = "one_or_many")]
    #[schemars(with = "crate::file::Either<WettedFile, Vec<WettedFile>>")]
    pub wetted: Vec<WettedFile>,
    /// Where solids are at the end.
    #[serde(default, skip_serializing_if = "Vec::is_empty", with = "one_or_many")]
    #[schemars(with = "crate::file::Either<PositionFile, Vec<PositionFile>>")]
    pub position: Vec<PositionFile>,
    /// How far solids that deform are bent at the end.
    #[serde(default, skip_serializing_if = "Vec::is_empty", with = "one_or_many")]
    #[schemars(with = "crate::file::Either<DeflectionFile, Vec<DeflectionFile>>")]
    pub deflection: Vec<DeflectionFile>,
}

/// An upper bound of a pure number.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MaxFile {
    /// The bound.
    pub max: f64,
}

/// An upper bound of a speed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MaxSpeedFile {
    /// The bound.
    pub max: Speed,
}

/// A period. It is measured from the kinetic energy, which peaks twice in each.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PeriodFile {
    /// Mode number, for the record.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mode: Option<u32>,
    /// Expected period.
    pub value: Time,
    /// Accepted relative deviation.
    pub tolerance: f64,
}

/// A frequency, measured like a period.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FrequencyFile {
    /// Mode number, for the record.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mode: Option<u32>,
    /// Expected frequency.
    pub value: Frequency,
    /// Accepted relative deviation.
    pub tolerance: f64,
}

/// A contact angle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ContactAngleFile {
    /// Name of the solid; `walls` for the closed sides of the domain, if no solid is called so.
    pub solid: String,
    /// Expected angle; without it Young's, which follows from the tensions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub value: Option<Angle>,
    /// Accepted deviation.
    pub tolerance: Angle,
}

/// A number of drops: `count`, or bounds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DropsFile {
    /// Exactly so many.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub count: Option<u32>,
    /// At least so many.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub min: Option<u32>,
    /// At most so many.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max: Option<u32>,
}

/// How far the liquid reaches towards a side of the domain.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ReachFile {
    /// Towards which side.
    pub side: Side,
    /// Expected coordinate along that side's axis.
    pub value: Length,
    /// Accepted deviation.
    pub tolerance: Length,
}

/// The wetted share of a solid's surface, 0 to 1: one bound, or both.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WettedFile {
    /// Name of the solid.
    pub solid: String,
    /// At least so much.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub min: Option<f64>,
    /// At most so much.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max: Option<f64>,
}

/// The largest way of a part of a solid that deforms from where it started (of one that moves freely, from where it would be
/// had it moved as a rigid one; of one whose held parts go as told, from where they would have carried it): one bound, or both.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DeflectionFile {
    /// Name of the solid.
    pub solid: String,
    /// At least so far.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub min: Option<Length>,
    /// At most so far.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max: Option<Length>,
}

/// Where a solid's centre of mass is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PositionFile {
    /// Name of the solid.
    pub solid: String,
    /// Expected centre of mass.
    pub value: Vec<Length>,
    /// Accepted distance from it.
    pub tolerance: Length,
    /// Only the distance along this direction counts (pure numbers), where nothing holds the solid in others.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub along: Option<Vec<f64>>,
}

/// A side of the domain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// Lower x.
    Left,
    /// Upper x.
    Right,
    /// Lower y (3D).
    Front,
    /// Upper y (3D).
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
