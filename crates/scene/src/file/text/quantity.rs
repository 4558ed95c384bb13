//! Values with units as they stand in a scene file, and the numbers in SI units that they are read as.

use crate::units::{Dimension, Parsed, parse};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::Visitor;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::borrow::Cow;
use std::fmt;
use std::marker::PhantomData;

/// Separates message and advice inside a serde message; never part of either.
pub(crate) const HELP_MARK: char = '\u{1f}';

/// Name by which the deserializer of scenes knows lengths, whose text may count cells.
pub(super) const LENGTH: &str = "Length";

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

impl<'de> Visitor<'de> for UnitVisitor {
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

    /// A length in cells, which the deserializer has made a length in m.
    fn visit_newtype_struct<De: Deserializer<'de>>(self, metres: De) -> Result<Parsed, De::Error> {
        f64::deserialize(metres).map(|value| Parsed { value, in_cells: false })
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
        #[derive(Clone, Copy, PartialEq)]
        pub struct $name(pub f64);

        /// The number alone, as it enters the identity of a scene.
        impl fmt::Debug for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                fmt::Debug::fmt(&self.0, f)
            }
        }

        impl<'de> Deserialize<'de> for $name {
            fn deserialize<De: Deserializer<'de>>(d: De) -> Result<Self, De::Error> {
                let visitor = UnitVisitor(Dimension::$name);
                let read = match Dimension::$name {
                    Dimension::Length => d.deserialize_newtype_struct(LENGTH, visitor),
                    _ => d.deserialize_any(visitor),
                };
                read.map(|parsed| Self(parsed.value))
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

        impl Quantity for $name {
            type Number = f64;

            fn number(self) -> f64 {
                self.0
            }

            fn of(number: &f64) -> Self {
                Self(*number)
            }
        }
    )*};
}

/// A quantity as written, or a list or an option of one, and what it is in SI units.
pub trait Quantity: Sized + Serialize + for<'de> Deserialize<'de> {
    /// Its number: of m, s, kg, rad and what they make.
    type Number;
    /// The number in SI units.
    fn number(self) -> Self::Number;
    /// The quantity of a number in SI units.
    fn of(number: &Self::Number) -> Self;
}

impl<Q: Quantity> Quantity for Option<Q> {
    type Number = Option<Q::Number>;

    fn number(self) -> Self::Number {
        self.map(Q::number)
    }

    fn of(number: &Self::Number) -> Self {
        number.as_ref().map(Q::of)
    }
}

impl<Q: Quantity> Quantity for Vec<Q> {
    type Number = Vec<Q::Number>;

    fn number(self) -> Self::Number {
        self.into_iter().map(Q::number).collect()
    }

    fn of(number: &Self::Number) -> Self {
        number.iter().map(Q::of).collect()
    }
}

/// Makes a field of numbers in SI units that is written as quantities: `#[serde(with = "Si::<Vec<Length>>")]`.
pub struct Si<Q>(PhantomData<Q>);

impl<Q: Quantity> Si<Q> {
    /// Writes numbers as quantities.
    pub fn serialize<S: Serializer>(number: &Q::Number, s: S) -> Result<S::Ok, S::Error> {
        Q::of(number).serialize(s)
    }

    /// Reads quantities as numbers.
    pub fn deserialize<'de, De: Deserializer<'de>>(d: De) -> Result<Q::Number, De::Error> {
        Q::deserialize(d).map(Q::number)
    }
}

impl<Q: JsonSchema> JsonSchema for Si<Q> {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        Q::schema_name()
    }

    fn json_schema(g: &mut SchemaGenerator) -> Schema {
        g.subschema_for::<Q>()
    }
}

quantity!(
    /// A length, m. Text may count cells instead.
    Length,
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

impl Quantity for MeshScale {
    type Number = f64;

    fn number(self) -> f64 {
        self.0
    }

    fn of(number: &f64) -> Self {
        Self(*number)
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

/// A number for messages: six digits.
pub(crate) fn short(value: f64) -> String {
    format!("{value:.5e}").parse::<f64>().map_or_else(|_| value.to_string(), |v| v.to_string())
}
