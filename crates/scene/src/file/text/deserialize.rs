//! Deserialises a TOML tree as a scene file, with errors that say what was found, what is accepted, and where.

use super::quantity::{HELP_MARK, LENGTH};
use super::source::Source;
use crate::error::{SceneError, nearest};
use crate::units::{self, Dimension};
use serde::de::value::{CowStrDeserializer, MapAccessDeserializer, MapDeserializer, SeqDeserializer};
use serde::de::{Error as _, Expected, IntoDeserializer, Unexpected, Visitor};
use serde::{Deserialize, Deserializer};
use std::borrow::Cow;
use std::fmt::Display;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeInteger, DeTable, DeValue};

/// Deserialises a tree of a scene with cells of `dx` metres.
///
/// # Errors
/// [`ReadError`] at the key or value that the grammar does not accept.
pub(super) fn tree<'i, T: Deserialize<'i>>(value: Spanned<DeValue<'i>>, dx: f64) -> Result<T, ReadError> {
    T::deserialize(Value { value, dx })
}

/// A key or value that the grammar does not accept.
#[derive(Debug, thiserror::Error)]
#[error("{message}")]
pub(super) struct ReadError {
    message: String,
    help: String,
    /// Position of the key or value. The nearest enclosing value sets it.
    span: Option<Range<usize>>,
}

impl ReadError {
    fn new(message: impl Into<String>, help: impl Into<String>) -> Self {
        Self { message: message.into(), help: help.into(), span: None }
    }

    /// The same error at a position, unless it already has one.
    fn or_at(mut self, span: Range<usize>) -> Self {
        self.span.get_or_insert(span);
        self
    }

    /// The error of a scene with this source.
    pub(super) fn in_source(self, source: &Source) -> SceneError {
        source.point(SceneError::new(self.message).with_help(self.help), self.span)
    }

    fn unexpected(found: Unexpected<'_>, wanted: &dyn Expected) -> Self {
        let found = match found {
            Unexpected::Seq => "a list".to_owned(),
            Unexpected::Map => "a table".to_owned(),
            other => other.to_string(),
        };
        Self::new(format!("found {found}"), format!("expected {}", plain_type(&wanted.to_string())))
    }

    /// A name that is none of the accepted ones; `noun` says what it is the name of.
    fn unknown(noun: &str, found: &str, accepted: &[&str]) -> Self {
        let meant = SYNONYMS.iter().find(|(word, ours)| *word == found && accepted.contains(ours));
        let near = meant.map(|m| m.1).or_else(|| nearest(found, accepted.iter().copied()));
        let near = near.map_or_else(String::new, |n| format!("did you mean `{n}`? "));
        let help = match accepted {
            _ if noun == "key" && SCENE_TABLES.contains(&found) => {
                let header = if found == "solid" { "[[solid]]".to_owned() } else { format!("[{found}]") };
                format!(
                    "`{found}` is a table of the scene, but a line under a header in brackets belongs to the table of that header: \
                     write `{header}` as a header of its own, or put the line above the first header"
                )
            }
            [] => format!("no {noun} is accepted here"),
            _ => format!("{near}accepted: {}", accepted.join(", ")),
        };
        Self::new(format!("unknown {noun} `{found}`"), help)
    }
}

impl serde::de::Error for ReadError {
    /// An error of a quantity: its text is a message, or a message and a help text with [`HELP_MARK`] between them.
    fn custom<T: Display>(text: T) -> Self {
        let text = text.to_string();
        let (message, help) = text.split_once(HELP_MARK).unwrap_or((&text, ""));
        Self::new(message, help)
    }

    fn invalid_type(found: Unexpected<'_>, wanted: &dyn Expected) -> Self {
        Self::unexpected(found, wanted)
    }

    fn invalid_value(found: Unexpected<'_>, wanted: &dyn Expected) -> Self {
        Self::unexpected(found, wanted)
    }

    fn invalid_length(length: usize, wanted: &dyn Expected) -> Self {
        Self::unexpected(Unexpected::Other(&format!("a list of length {length}")), wanted)
    }

    fn unknown_variant(found: &str, accepted: &'static [&'static str]) -> Self {
        Self::unknown("value", found, accepted)
    }

    fn unknown_field(found: &str, accepted: &'static [&'static str]) -> Self {
        Self::unknown("key", found, accepted)
    }

    fn missing_field(key: &'static str) -> Self {
        let help = match key {
            "format" => {
                "add `format = 1`, the version of the scene format, at the top of the file".to_owned()
            }
            key if SCENE_TABLES.contains(&key) => format!("add the table `[{key}]` to the scene"),
            key => format!("add `{key} = …` to this table"),
        };
        Self::new(format!("the key `{key}` is missing"), help)
    }
}

/// The tables of a scene. In TOML one that is written below the header of another table becomes a key of that.
const SCENE_TABLES: [&str; 8] =
    ["domain", "liquid", "solid", "tension", "contact_line", "numerics", "output", "expect"];

/// Common synonyms, mapped to the keys and values of the scene grammar.
const SYNONYMS: [(&str, &str); 8] = [
    ("clamp", "fixed"),
    ("clamped", "fixed"),
    ("elastic", "neo_hookean"),
    ("viscosity", "dynamic_viscosity"),
    ("dt", "fixed_step"),
    ("end_time", "duration"),
    ("sphere", "ball"),
    ("circle", "ball"),
];

/// Plain description of a Rust type, as derived visitors name what they expect.
fn plain_type(wanted: &str) -> String {
    match wanted {
        "u32" | "u64" | "usize" => "a whole number, not negative, no quotes".to_owned(),
        "f64" => "a number, no quotes".to_owned(),
        "a string" | "path string" => "text in quotes".to_owned(),
        "a boolean" => "true or false".to_owned(),
        "a sequence" => "a list [ … ]".to_owned(),
        other => match other.strip_prefix("struct ") {
            Some("Wetting") => "a table, like { contact_angle = \"30 deg\" }".to_owned(),
            Some(_) => "a table { … }".to_owned(),
            None if other.starts_with("enum ") => "a table with one key that names the kind".to_owned(),
            None => other.to_owned(),
        },
    }
}

/// A value of the tree.
struct Value<'i> {
    value: Spanned<DeValue<'i>>,
    /// Cell size, m, for lengths in cells.
    dx: f64,
}

/// A key of the tree.
struct Key<'i>(Spanned<Cow<'i, str>>);

impl<'de> IntoDeserializer<'de, ReadError> for Value<'de> {
    type Deserializer = Self;

    fn into_deserializer(self) -> Self {
        self
    }
}

impl<'de> IntoDeserializer<'de, ReadError> for Key<'de> {
    type Deserializer = Self;

    fn into_deserializer(self) -> Self {
        self
    }
}

impl<'de> Deserializer<'de> for Key<'de> {
    type Error = ReadError;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, ReadError> {
        let span = self.0.span();
        let key = CowStrDeserializer::<ReadError>::new(self.0.into_inner());
        key.deserialize_any(visitor).map_err(|e| e.or_at(span))
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf option unit
        unit_struct newtype_struct seq tuple tuple_struct map struct enum identifier ignored_any
    }
}

impl<'de> Deserializer<'de> for Value<'de> {
    type Error = ReadError;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, ReadError> {
        let (span, dx) = (self.value.span(), self.dx);
        let read = match self.value.into_inner() {
            DeValue::String(Cow::Borrowed(text)) => visitor.visit_borrowed_str(text),
            DeValue::String(Cow::Owned(text)) => visitor.visit_string(text),
            DeValue::Integer(number) => visit_integer(&number, visitor),
            DeValue::Float(number) => visit_float(number.as_str(), visitor),
            DeValue::Boolean(value) => visitor.visit_bool(value),
            DeValue::Datetime(_) => Err(ReadError::invalid_type(Unexpected::Other("a date"), &visitor)),
            DeValue::Array(list) => {
                visitor.visit_seq(SeqDeserializer::new(list.into_iter().map(|value| Value { value, dx })))
            }
            DeValue::Table(table) => visitor.visit_map(entries(table, dx)),
        };
        read.map_err(|e| e.or_at(span))
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, ReadError> {
        visitor.visit_some(self)
    }

    /// A length, which becomes one in m if it counts cells, or what is made of a value (`read_as`).
    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        visitor: V,
    ) -> Result<V::Value, ReadError> {
        let span = self.value.span();
        let read = match self.value.get_ref() {
            DeValue::String(text) if name == LENGTH => match units::parse(text, Dimension::Length) {
                Ok(length) if length.in_cells => {
                    visitor.visit_newtype_struct((length.value * self.dx).into_deserializer())
                }
                _ => self.deserialize_any(visitor),
            },
            _ if name == LENGTH => self.deserialize_any(visitor),
            _ => visitor.visit_newtype_struct(self),
        };
        read.map_err(|e| e.or_at(span))
    }

    /// A table; derived visitors would take a list of its values, too.
    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, ReadError> {
        if matches!(self.value.get_ref(), DeValue::Array(_)) {
            return Err(ReadError::invalid_type(Unexpected::Seq, &visitor).or_at(self.value.span()));
        }
        self.deserialize_any(visitor)
    }

    /// The content of a value of an enum that is written as a table: nothing.
    fn deserialize_unit<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, ReadError> {
        let wrong = match self.value.get_ref() {
            DeValue::Array(list) if list.is_empty() => return visitor.visit_unit(),
            DeValue::Table(table) if table.is_empty() => return visitor.visit_unit(),
            DeValue::Array(_) => "expected an empty list".to_owned(),
            DeValue::Table(_) => "expected an empty table".to_owned(),
            other => format!("expected a table, found {}", other.type_str()),
        };
        Err(ReadError::new(wrong, "").or_at(self.value.span()))
    }

    /// A value by its name, or a table whose only key names the kind.
    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, ReadError> {
        let (span, dx) = (self.value.span(), self.dx);
        let one_key = |message| {
            Err(ReadError::new(message, "its key selects one of several kinds: give exactly one key"))
        };
        let read = match self.value.into_inner() {
            DeValue::String(text) => visitor.visit_enum(CowStrDeserializer::new(text)),
            DeValue::Table(table) => match table.len() {
                0 => one_key("this table has no key"),
                1 => visitor.visit_enum(MapAccessDeserializer::new(entries(table, dx))),
                _ => one_key("this table has more than one key"),
            },
            _ => Err(ReadError::new("expected a text or a table", "")),
        };
        read.map_err(|e| e.or_at(span))
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf
        unit_struct seq tuple tuple_struct map identifier ignored_any
    }
}

/// The entries of a table.
fn entries<'i>(
    table: DeTable<'i>,
    dx: f64,
) -> MapDeserializer<'i, impl Iterator<Item = (Key<'i>, Value<'i>)>, ReadError> {
    MapDeserializer::new(table.into_iter().map(move |(key, value)| (Key(key), Value { value, dx })))
}

fn visit_integer<'de, V: Visitor<'de>>(number: &DeInteger<'_>, visitor: V) -> Result<V::Value, ReadError> {
    let (digits, radix) = (number.as_str(), number.radix());
    if let Ok(number) = i64::from_str_radix(digits, radix) {
        visitor.visit_i64(number)
    } else if let Ok(number) = u64::from_str_radix(digits, radix) {
        visitor.visit_u64(number)
    } else if let Ok(number) = i128::from_str_radix(digits, radix) {
        visitor.visit_i128(number)
    } else {
        Err(ReadError::new("integer number overflowed", ""))
    }
}

/// Text that overflows reads as infinity; only `inf` itself may.
fn visit_float<'de, V: Visitor<'de>>(text: &str, visitor: V) -> Result<V::Value, ReadError> {
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() || number.is_nan() || text.ends_with("inf") => {
            visitor.visit_f64(number)
        }
        _ => Err(ReadError::new("floating-point number overflowed", "")),
    }
}
