//! Values with units as they stand in a scene file, and small helpers of the grammar.

use crate::units::{Dimension, Parsed, parse};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer, StrDeserializer};
use serde::de::{MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::borrow::Cow;
use std::fmt;
use std::marker::PhantomData;

/// Separates message and advice inside a serde message; never part of either.
pub(crate) const HELP_MARK: char = '\u{1f}';

struct UnitVisitor(Dimension);

impl UnitVisitor {
    fn bare<E: serde::de::Error>(&self, number: impl fmt::Display, zero: bool) -> Result<Parsed, E> {
        if zero {
            return Ok(Parsed { value: 0.0, in_cells: false });
        }
        let advice = self.0.advice();
        let unit = self.0.usual();
        Err(E::custom(format!(
            "the number {number} has no unit{HELP_MARK}{advice}; like \"{number} {unit}\""
        )))
    }
}

impl Visitor<'_> for UnitVisitor {
    type Value = Parsed;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} as text with a unit (one of: {})", self.0.name(), self.0.accepted())
    }

    fn visit_str<E: serde::de::Error>(self, text: &str) -> Result<Parsed, E> {
        parse(text, self.0).map_err(|e| E::custom(format!("{}{HELP_MARK}{}", e.message, e.help)))
    }

    fn visit_i64<E: serde::de::Error>(self, v: i64) -> Result<Parsed, E> {
        self.bare(v, v == 0)
    }

    fn visit_u64<E: serde::de::Error>(self, v: u64) -> Result<Parsed, E> {
        self.bare(v, v == 0)
    }

    fn visit_f64<E: serde::de::Error>(self, v: f64) -> Result<Parsed, E> {
        self.bare(v, v == 0.0)
    }
}

fn unit_schema(dimension: Dimension) -> Schema {
    json_schema!({
        "description": format!("{} with its unit, one of: {}", dimension.name(), dimension.accepted()),
        "anyOf": [{ "type": "string", "examples": [format!("1 {}", dimension.si())] }, { "const": 0 }],
    })
}

macro_rules! quantity {
    ($($(#[$doc:meta])* $name:ident),* $(,)?) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct $name(pub f64);

        impl<'de> Deserialize<'de> for $name {
            fn deserialize<De: Deserializer<'de>>(d: De) -> Result<Self, De::Error> {
                d.deserialize_any(UnitVisitor(Dimension::$name)).map(|p| Self(p.value))
            }
        }

        impl Serialize for $name {
            fn serialize<S: Serializer>(&self, s: S) -> Result<S::Ok, S::Error> {
                s.collect_str(&format_args!("{:?} {}", self.0, Dimension::$name.si()))
            }
        }

        impl JsonSchema for $name {
            fn schema_name() -> Cow<'static, str> {
                stringify!($name).into()
            }

            fn json_schema(_: &mut SchemaGenerator) -> Schema {
                unit_schema(Dimension::$name)
            }
        }
    )*};
}

quantity!(
    /// A time, s.
    Time,
    /// A speed, m/s.
    Speed,
    /// A density, kg/m³.
    Density,
    /// A kinematic viscosity, m²/s.
    KinematicViscosity,
    /// A dynamic viscosity or contact-line friction, Pa s.
    DynamicViscosity,
    /// An acceleration, m/s².
    Acceleration,
    /// A surface tension or spring stiffness, N/m.
    Tension,
    /// A pressure or elastic modulus, Pa.
    Pressure,
    /// An angle, rad.
    Angle,
    /// An angular velocity, rad/s.
    AngularVelocity,
    /// A frequency, Hz.
    Frequency,
);

/// A length: m, or multiples of the cell size until the grid is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Length {
    /// The number.
    pub value: f64,
    /// Whether it counts cells instead of metres.
    pub in_cells: bool,
}

impl Length {
    /// A length in metres.
    pub fn metres(value: f64) -> Self {
        Self { value, in_cells: false }
    }

    /// The length in metres on a grid with cells of `dx` metres.
    pub fn resolve(self, dx: f64) -> f64 {
        if self.in_cells { self.value * dx } else { self.value }
    }
}

impl<'de> Deserialize<'de> for Length {
    fn deserialize<De: Deserializer<'de>>(d: De) -> Result<Self, De::Error> {
        d.deserialize_any(UnitVisitor(Dimension::Length))
            .map(|p| Self { value: p.value, in_cells: p.in_cells })
    }
}

impl Serialize for Length {
    fn serialize<S: Serializer>(&self, s: S) -> Result<S::Ok, S::Error> {
        s.collect_str(&format_args!("{:?} {}", self.value, if self.in_cells { "dx" } else { "m" }))
    }
}

impl JsonSchema for Length {
    fn schema_name() -> Cow<'static, str> {
        "Length".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        unit_schema(Dimension::Length)
    }
}

/// Length of one unit of a mesh file: a pure number of metres, or text with a unit (`"1 mm"`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshScale(pub f64);

impl<'de> Deserialize<'de> for MeshScale {
    fn deserialize<De: Deserializer<'de>>(d: De) -> Result<Self, De::Error> {
        struct V;
        impl Visitor<'_> for V {
            type Value = MeshScale;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(
                    "metres per unit of the mesh file (a number), or the length of one unit (\"1 mm\")",
                )
            }

            fn visit_str<E: serde::de::Error>(self, text: &str) -> Result<MeshScale, E> {
                let p = UnitVisitor(Dimension::Length).visit_str(text)?;
                if p.in_cells {
                    return Err(E::custom("the unit of a mesh file cannot be given in cells (dx)"));
                }
                Ok(MeshScale(p.value))
            }

            fn visit_i64<E: serde::de::Error>(self, v: i64) -> Result<MeshScale, E> {
                Ok(MeshScale(v as f64))
            }

            fn visit_f64<E: serde::de::Error>(self, v: f64) -> Result<MeshScale, E> {
                Ok(MeshScale(v))
            }
        }
        d.deserialize_any(V)
    }
}

impl Serialize for MeshScale {
    fn serialize<S: Serializer>(&self, s: S) -> Result<S::Ok, S::Error> {
        s.serialize_f64(self.0)
    }
}

impl JsonSchema for MeshScale {
    fn schema_name() -> Cow<'static, str> {
        "MeshScale".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "Length of one unit of a mesh file: a pure number of metres, or text with a unit.",
            "type": ["number", "string"],
        })
    }
}

/// Either a text, or a table or list: the two forms that some keys have.
#[derive(Clone, Debug, PartialEq)]
pub enum Either<A, B> {
    /// The text form.
    Text(A),
    /// The structured form.
    Rich(B),
}

impl<'de, A: Deserialize<'de>, B: Deserialize<'de>> Deserialize<'de> for Either<A, B> {
    fn deserialize<De: Deserializer<'de>>(d: De) -> Result<Self, De::Error> {
        struct V<A, B>(PhantomData<(A, B)>);
        impl<'de, A: Deserialize<'de>, B: Deserialize<'de>> Visitor<'de> for V<A, B> {
            type Value = Either<A, B>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("text, or a table or list")
            }

            fn visit_str<E: serde::de::Error>(self, text: &str) -> Result<Self::Value, E> {
                A::deserialize(StrDeserializer::new(text)).map(Either::Text)
            }

            fn visit_i64<E: serde::de::Error>(self, v: i64) -> Result<Self::Value, E> {
                A::deserialize(serde::de::value::I64Deserializer::new(v)).map(Either::Text)
            }

            fn visit_f64<E: serde::de::Error>(self, v: f64) -> Result<Self::Value, E> {
                A::deserialize(serde::de::value::F64Deserializer::new(v)).map(Either::Text)
            }

            fn visit_map<M: MapAccess<'de>>(self, map: M) -> Result<Self::Value, M::Error> {
                B::deserialize(MapAccessDeserializer::new(map)).map(Either::Rich)
            }

            fn visit_seq<S: SeqAccess<'de>>(self, seq: S) -> Result<Self::Value, S::Error> {
                B::deserialize(SeqAccessDeserializer::new(seq)).map(Either::Rich)
            }
        }
        d.deserialize_any(V(PhantomData))
    }
}

impl<A: Serialize, B: Serialize> Serialize for Either<A, B> {
    fn serialize<S: Serializer>(&self, s: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Text(a) => a.serialize(s),
            Self::Rich(b) => b.serialize(s),
        }
    }
}

impl<A: JsonSchema, B: JsonSchema> JsonSchema for Either<A, B> {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        format!("{}Or{}", A::schema_name(), B::schema_name()).into()
    }

    fn json_schema(g: &mut SchemaGenerator) -> Schema {
        json_schema!({ "anyOf": [g.subschema_for::<A>(), g.subschema_for::<B>()] })
    }
}

/// A table with free keys in the order of the file (names of solids).
#[derive(Clone, Debug, PartialEq)]
pub struct Named<T>(pub Vec<(String, T)>);

impl<T> Default for Named<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Named<T> {
    fn deserialize<De: Deserializer<'de>>(d: De) -> Result<Self, De::Error> {
        struct V<T>(PhantomData<T>);
        impl<'de, T: Deserialize<'de>> Visitor<'de> for V<T> {
            type Value = Named<T>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a table whose keys are names of solids")
            }

            fn visit_map<M: MapAccess<'de>>(self, mut map: M) -> Result<Self::Value, M::Error> {
                let mut out = Vec::new();
                while let Some(entry) = map.next_entry()? {
                    out.push(entry);
                }
                Ok(Named(out))
            }
        }
        d.deserialize_map(V(PhantomData))
    }
}

impl<T: Serialize> Serialize for Named<T> {
    fn serialize<S: Serializer>(&self, s: S) -> Result<S::Ok, S::Error> {
        s.collect_map(self.0.iter().map(|(k, v)| (k, v)))
    }
}

impl<T: JsonSchema> JsonSchema for Named<T> {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        format!("NamedSolids{}", T::schema_name()).into()
    }

    fn json_schema(g: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": "object", "additionalProperties": g.subschema_for::<T>() })
    }
}

/// A number for messages: six digits.
pub(crate) fn short(value: f64) -> String {
    format!("{value:.5e}").parse::<f64>().map_or_else(|_| value.to_string(), |v| v.to_string())
}
