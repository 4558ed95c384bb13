//! Scene text parsed into a TOML tree, and `--set` overrides of it.

use super::source::Source;
use crate::error::SceneError;
use serde::Deserialize;
use serde::de::Error as _;
use std::borrow::Cow;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// The largest scene text that is read, bytes.
const MAX_TEXT: usize = 4 << 20;

/// A parsed scene text, not yet deserialised as a scene.
pub struct Document<'i> {
    source: Source,
    root: Spanned<DeTable<'i>>,
}

impl<'i> Document<'i> {
    /// Parses the text of a scene.
    ///
    /// # Errors
    /// [`SceneError`] pointing at invalid TOML.
    pub fn parse(name: &str, text: &'i str) -> Result<Self, SceneError> {
        let mut source = Source::default();
        source.add(name, text);
        if text.len() > MAX_TEXT {
            let error = SceneError::new(format!(
                "the scene has {} bytes, but at most {MAX_TEXT} are read",
                text.len()
            ));
            return Err(error.with_help("put meshes into separate files"));
        }
        match DeTable::parse(text) {
            Ok(root) => Ok(Self { source, root }),
            Err(e) => Err(source.point(SceneError::new(e.message()), e.span())),
        }
    }

    /// Replaces or adds a value: `domain.resolution=64`, `liquid.body.0.velocity=["1 m/s", 0]`. Text that is not a TOML value is
    /// taken as a string, so `tension.liquid_air=0.5 mN/cm` needs no quotes.
    ///
    /// # Errors
    /// [`SceneError`] pointing into the setting.
    pub fn apply_set(&mut self, setting: &'i str) -> Result<(), SceneError> {
        let start = self.source.add("--set", setting);
        let Some((path, text)) = setting.split_once('=') else {
            let error = SceneError::new(format!("`{setting}` is not of the form path=value"))
                .with_help("write, for example, domain.resolution=64");
            return Err(self.source.point(error, Some(start..start + setting.len())));
        };
        let value_start = start + path.len() + 1;
        let value = parse_set_value(text).map_err(|e| {
            let span = e.span().map(|s| s.start + value_start..s.end + value_start);
            self.source.point(
                SceneError::new(e.message())
                    .with_help("close all quotes and brackets, and put text in quotes"),
                span,
            )
        })?;
        let value = shift(value, value_start);
        let mut segments = Vec::new();
        let mut at = start;
        for word in path.split('.') {
            let trimmed = word.trim();
            let lead = word.len() - word.trim_start().len();
            segments.push((trimmed, at + lead..at + lead + trimmed.len()));
            at += word.len() + 1;
        }
        if segments.len() > 60 {
            let error = SceneError::new("the path has more than 60 parts");
            return Err(self.source.point(error, Some(start..value_start)));
        }
        self.remove_conflicting_key(path.trim());
        set_in_table(self.root.get_mut(), &segments, value).map_err(|e| self.source.point(e.0, Some(e.1)))
    }

    /// Removes `domain.dx` when `domain.resolution` is set, and vice versa: they exclude each other.
    fn remove_conflicting_key(&mut self, path: &str) {
        let rival = match path {
            "domain.dx" => "resolution",
            "domain.resolution" => "dx",
            _ => return,
        };
        if let Some(domain) = self.root.get_mut().get_mut("domain")
            && let DeValue::Table(t) = domain.get_mut()
        {
            t.remove(rival);
        }
    }

    /// The positions of all keys and values.
    pub fn source(&mut self) -> Source {
        self.source.collect_table("", self.root.get_ref());
        self.source.clone()
    }

    /// Deserialises a table of the scene by its key, with lengths in cells as NaN; `None` if it is not there or not accepted.
    pub fn table<T: Deserialize<'i>>(&self, key: &str) -> Option<T> {
        super::deserialize::tree(self.root.get_ref().get(key)?.clone(), f64::NAN).ok()
    }

    /// Deserialises the whole tree of a scene with cells of `dx` metres.
    ///
    /// # Errors
    /// [`SceneError`] pointing at the key or value that is not accepted.
    pub fn read<T: Deserialize<'i>>(self, dx: f64) -> Result<T, SceneError> {
        let root = Spanned::new(self.root.span(), DeValue::Table(self.root.into_inner()));
        super::deserialize::tree(root, dx).map_err(|e| e.in_source(&self.source))
    }
}

fn parse_set_value(text: &str) -> Result<Spanned<DeValue<'_>>, toml::de::Error> {
    let trimmed = text.trim();
    let lead = text.len() - text.trim_start().len();
    match DeValue::parse(trimmed) {
        Ok(v) => Ok(shift(v, lead)),
        Err(e) if trimmed.starts_with(['"', '\'', '[', '{']) => Err(e),
        Err(_) if trimmed.is_empty() => Err(toml::de::Error::custom("the value after `=` is missing")),
        Err(_) => Ok(Spanned::new(lead..lead + trimmed.len(), DeValue::String(Cow::Borrowed(trimmed)))),
    }
}

/// The value with all positions shifted.
fn shift<'i>(value: Spanned<DeValue<'i>>, by: usize) -> Spanned<DeValue<'i>> {
    let move_by = |s: Range<usize>| s.start + by..s.end + by;
    let span = move_by(value.span());
    let mut inner = value.into_inner();
    match &mut inner {
        DeValue::Table(t) => {
            *t = std::mem::take(t)
                .into_iter()
                .map(|(k, v)| (Spanned::new(move_by(k.span()), k.into_inner()), shift(v, by)))
                .collect();
        }
        DeValue::Array(a) => {
            for item in a.iter_mut() {
                let old = std::mem::replace(item, Spanned::new(0..0, DeValue::Boolean(false)));
                *item = shift(old, by);
            }
        }
        _ => {}
    }
    Spanned::new(span, inner)
}

type SetError = Box<(SceneError, Range<usize>)>;

fn set_in_table<'i>(
    table: &mut DeTable<'i>,
    path: &[(&'i str, Range<usize>)],
    value: Spanned<DeValue<'i>>,
) -> Result<(), SetError> {
    let Some(((word, span), rest)) = path.split_first() else { return Ok(()) };
    if word.is_empty() {
        let error = SceneError::new("the path has an empty part: a dot too many");
        return Err(Box::new((error.with_help("write path=value, like domain.resolution=64"), span.clone())));
    }
    if rest.is_empty() {
        table.remove(*word);
        table.insert(Spanned::new(span.clone(), Cow::Borrowed(*word)), value);
        return Ok(());
    }
    if !table.contains_key(*word) {
        let empty = Spanned::new(span.clone(), DeValue::Table(DeTable::new()));
        table.insert(Spanned::new(span.clone(), Cow::Borrowed(*word)), empty);
    }
    match table.get_mut(*word) {
        Some(next) => set_in_value(next.get_mut(), word, rest, value),
        None => Ok(()),
    }
}

fn set_in_value<'i>(
    target: &mut DeValue<'i>,
    name: &str,
    path: &[(&'i str, Range<usize>)],
    value: Spanned<DeValue<'i>>,
) -> Result<(), SetError> {
    let Some(((word, span), rest)) = path.split_first() else { return Ok(()) };
    match target {
        DeValue::Table(t) => set_in_table(t, path, value),
        DeValue::Array(a) => {
            let count = a.len();
            let names: Vec<Option<String>> = a.iter().map(name_of).collect();
            let number = word.parse().ok().or_else(|| names.iter().position(|n| n.as_deref() == Some(*word)));
            let Some(item) = number.and_then(|i: usize| a.get_mut(i)) else {
                let error = SceneError::new(format!("`{name}` has no entry `{word}`"));
                let names: Vec<String> = names.into_iter().flatten().collect();
                let help = match names.is_empty() {
                    true => format!("it has {count} entries, numbered from 0"),
                    false => format!(
                        "it has {count} entries, given by their number (from 0) or by name: {}",
                        names.join(", ")
                    ),
                };
                return Err(Box::new((error.with_help(help), span.clone())));
            };
            if rest.is_empty() {
                *item = value;
                Ok(())
            } else {
                set_in_value(item.get_mut(), word, rest, value)
            }
        }
        other => {
            let error = SceneError::new(format!(
                "`{name}` is {}, it has no key `{word}`",
                with_article(other.type_str())
            ));
            Err(Box::new((error.with_help(format!("set `{name}` itself")), span.clone())))
        }
    }
}

/// The `name` of an entry of a list, for example of a solid.
fn name_of(item: &Spanned<DeValue<'_>>) -> Option<String> {
    let DeValue::Table(table) = item.get_ref() else { return None };
    match table.get("name")?.get_ref() {
        DeValue::String(name) => Some(name.to_string()),
        _ => None,
    }
}

fn with_article(noun: &str) -> String {
    let article = if noun.starts_with(['a', 'e', 'i', 'o', 'u']) { "an" } else { "a" };
    format!("{article} {noun}")
}
