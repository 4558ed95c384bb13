//! Where keys and values stand in the text of a scene, for errors that point into it.

use crate::error::SceneError;
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Source positions of keys and values. The file and then every `--set` share one range of byte positions.
#[derive(Clone, Debug, Default)]
pub struct Source {
    /// First position, name and text of each source text.
    texts: Vec<(usize, String, Arc<str>)>,
    /// Key and value positions by dotted path.
    spans: BTreeMap<String, (Range<usize>, Range<usize>)>,
}

/// Two scenes from different sources can be equal, so all sources compare equal.
impl PartialEq for Source {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Source {
    /// Adds a text; returns the position of its first byte.
    pub(super) fn add(&mut self, name: &str, text: &str) -> usize {
        let start = self.texts.last().map_or(0, |(s, _, t)| s + t.len() + 1);
        self.texts.push((start, name.to_owned(), Arc::from(text)));
        start
    }

    /// The error with a range of positions attached.
    pub(crate) fn point(&self, error: SceneError, span: Option<Range<usize>>) -> SceneError {
        let wanted = span.as_ref().map_or(0, |s| s.start);
        let piece = self.texts.iter().rev().find(|(start, _, _)| *start <= wanted);
        match piece {
            Some((start, name, text)) => {
                let cut = span.map(|s| s.start - start..s.end.saturating_sub(*start));
                error.at(name, text, cut)
            }
            None => error,
        }
    }

    /// The error pointing at the value of a path, or at the nearest enclosing table that the text contains.
    pub fn at_value(&self, error: SceneError, path: &str) -> SceneError {
        let mut path = path;
        loop {
            if let Some((_, value)) = self.spans.get(path) {
                return self.point(error, Some(value.clone()));
            }
            match path.rfind('.') {
                Some(i) => path = &path[..i],
                None => return self.point(error, None),
            }
        }
    }

    /// The error pointing at a key.
    pub fn at_key(&self, error: SceneError, path: &str) -> SceneError {
        match self.spans.get(path) {
            Some((key, _)) => self.point(error, Some(key.clone())),
            None => self.at_value(error, path),
        }
    }

    /// The path of the first key inside a table, for tables whose only key names a kind.
    pub fn first_inside(&self, path: &str) -> String {
        let prefix = format!("{path}.");
        let next = self.spans.range(prefix.clone()..).next();
        next.filter(|(k, _)| k.starts_with(&prefix)).map_or_else(|| path.to_owned(), |(k, _)| k.clone())
    }

    /// Whether a path is written in the scene.
    pub fn has(&self, path: &str) -> bool {
        self.spans.contains_key(path)
    }

    /// The scene's text without `--set`.
    pub fn text(&self) -> &str {
        self.texts.first().map_or("", |p| &p.2)
    }

    /// Adds the positions of all keys and values of a table at the path `prefix`, empty for the root.
    pub(super) fn collect_table(&mut self, prefix: &str, table: &DeTable<'_>) {
        for (key, value) in table {
            let path = if prefix.is_empty() {
                key.get_ref().to_string()
            } else {
                format!("{prefix}.{}", key.get_ref())
            };
            self.collect(path, key.span(), value);
        }
    }

    fn collect(&mut self, path: String, key: Range<usize>, value: &Spanned<DeValue<'_>>) {
        match value.get_ref() {
            DeValue::Table(t) => self.collect_table(&path, t),
            DeValue::Array(a) => {
                for (i, item) in a.iter().enumerate() {
                    self.collect(format!("{path}.{i}"), item.span(), item);
                }
            }
            _ => {}
        }
        // The span of a table written in dotted keys is empty or reversed; use the span of its key.
        let span = value.span();
        let span = if span.start < span.end { span } else { key.clone() };
        self.spans.insert(path, (key, span));
    }
}
