//! The error type of scenes: what was found, where, what is accepted, and how to correct it.

use std::fmt::Write as _;
use std::ops::Range;
use std::sync::Arc;

/// Kind of an error; it decides the exit status of the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorKind {
    /// The scene is invalid, or this version cannot run it (exit status 3).
    Invalid,
    /// A file could not be read or written (exit status 4). The message names it.
    Io,
}

/// Why a scene was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{message}")]
pub struct SceneError {
    /// Decides the exit status.
    pub kind: ErrorKind,
    /// The error: one sentence that names the value and the reason.
    pub message: String,
    /// The remedy: accepted values and how to correct the file.
    pub help: Option<String>,
    /// The offending text: a byte range of `source_text` that starts and ends at characters.
    pub span: Option<Range<usize>>,
    /// Name of the file, or `--set` when the value came from the command line.
    pub source_name: String,
    /// The whole text that `span` points into.
    pub source_text: Arc<str>,
}

impl SceneError {
    /// An invalid scene, without a position in its text.
    pub fn new(message: impl Into<String>) -> Self {
        Self {
            kind: ErrorKind::Invalid,
            message: message.into(),
            help: None,
            span: None,
            source_name: String::new(),
            source_text: Arc::from(""),
        }
    }

    /// A file that could not be read. The message names the file.
    pub fn io(name: &str, message: impl Into<String>) -> Self {
        Self { kind: ErrorKind::Io, source_name: name.to_owned(), ..Self::new(message) }
    }

    /// The same error with a help text.
    #[must_use]
    pub fn with_help(mut self, help: impl Into<String>) -> Self {
        let help = help.into();
        self.help = (!help.is_empty()).then_some(help);
        self
    }

    /// The same error with a position in a text; the range is clamped to the text.
    #[must_use]
    pub fn at(mut self, name: &str, text: &Arc<str>, span: Option<Range<usize>>) -> Self {
        self.source_name = name.to_owned();
        self.source_text = Arc::clone(text);
        self.span = span.map(|s| clamp(text, s));
        self
    }

    /// The exit status of the program: 3 for an invalid scene, 4 for input and output.
    pub fn exit_status(&self) -> u8 {
        match self.kind {
            ErrorKind::Invalid => 3,
            ErrorKind::Io => 4,
        }
    }

    /// Line and column (both from 1, the column in characters) of the start of the offending text.
    pub fn line_column(&self) -> Option<(usize, usize)> {
        let start = self.span.as_ref()?.start;
        let before = self.source_text.get(..start)?;
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        Some((before.matches('\n').count() + 1, before[line_start..].chars().count() + 1))
    }

    /// The error in one line: what, where, and how to correct it.
    pub fn line(&self) -> String {
        let place = match self.line_column() {
            Some((line, column)) => format!(" ({}:{line}:{column})", self.source_name),
            None => String::new(),
        };
        let help = self.help.as_ref().map_or_else(String::new, |help| format!("; {help}"));
        format!("{}{place}{help}", self.message)
    }

    /// The error as plain text, with the line of the scene that it concerns.
    pub fn render(&self) -> String {
        let mut out = format!("error: {}\n", self.message);
        self.render_snippet(&mut out);
        if let Some(help) = &self.help {
            let _ = writeln!(out, "  help: {help}");
        }
        out
    }

    fn render_snippet(&self, out: &mut String) {
        let (Some((line, column)), Some(span)) = (self.line_column(), &self.span) else {
            if !self.source_name.is_empty() {
                let _ = writeln!(out, "  --> {}", self.source_name);
            }
            return;
        };
        let start = self.source_text[..span.start].rfind('\n').map_or(0, |i| i + 1);
        let end =
            self.source_text[span.start..].find('\n').map_or(self.source_text.len(), |i| span.start + i);
        let text = self.source_text[start..end].trim_end_matches('\r');
        let until = span.end.min(start + text.len()).max(span.start);
        let marks = self.source_text[span.start..until].chars().count().max(1);
        let number = line.to_string();
        let gutter = " ".repeat(number.len());
        let padding: String =
            text.chars().take(column - 1).map(|c| if c == '\t' { '\t' } else { ' ' }).collect();
        let _ = writeln!(out, "{gutter}--> {}:{line}:{column}", self.source_name);
        let _ = writeln!(out, "{gutter} |");
        let _ = writeln!(out, "{number} | {text}");
        let _ = writeln!(out, "{gutter} | {padding}{}", "^".repeat(marks));
    }
}

/// Clamps a range to the text and widens it to whole characters.
fn clamp(text: &str, span: Range<usize>) -> Range<usize> {
    let mut start = span.start.min(text.len());
    let mut end = span.end.clamp(start, text.len());
    while !text.is_char_boundary(start) {
        start -= 1;
    }
    while !text.is_char_boundary(end) {
        end += 1;
    }
    start..end
}

/// The candidate nearest to a word by edit distance, if it is near enough to be a likely correction.
pub fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let limit = (word.chars().count() / 3).clamp(1, 4);
    candidates
        .into_iter()
        .map(|c| (edit_distance(word, c), c))
        .filter(|(d, c)| *d <= limit || (c.starts_with(word) && word.len() >= 3))
        .min_by_key(|(d, _)| *d)
        .map(|(_, c)| c)
}

/// Edit distance: insertions, deletions, replacements and swaps of neighbours that turn one word into the other.
fn edit_distance(a: &str, b: &str) -> usize {
    let a: Vec<char> = a.chars().take(64).collect();
    let b: Vec<char> = b.chars().take(64).collect();
    let mut before = vec![0; b.len() + 1];
    let mut last: Vec<usize> = (0..=b.len()).collect();
    for i in 1..=a.len() {
        let mut row = vec![i; b.len() + 1];
        for j in 1..=b.len() {
            let change = last[j - 1] + usize::from(a[i - 1] != b[j - 1]);
            row[j] = change.min(last[j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                row[j] = row[j].min(before[j - 2] + 1);
            }
        }
        before = std::mem::replace(&mut last, row);
    }
    last[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearest_word() {
        assert_eq!(nearest("resolutoin", ["size", "resolution", "walls"]), Some("resolution"));
        assert_eq!(nearest("resolution", ["size", "walls"]), None);
        assert_eq!(nearest("vel", ["velocity", "shape"]), Some("velocity"));
        assert_eq!(edit_distance("ab", "ba"), 1);
    }

    #[test]
    fn clamps_to_characters() {
        let text: Arc<str> = Arc::from("a µ b");
        let e = SceneError::new("x").at("f", &text, Some(3..99));
        assert_eq!(e.span, Some(2..text.len()));
        assert_eq!(e.line_column(), Some((1, 3)));
    }
}
