//! The order of the layers: which crates may name which, and that the files of a crate do not name each other in circles.
//!
//! Paths that begin with `crate`, `super`, a crate's name or, in a folder's `mod.rs`, that of a file in it are read from the text of every
//! file; what a folder's `mod.rs` or a crate's `lib.rs` re-exports counts as the file that defines it. Tests are left out. Arrows that close a circle today are in [`ALLOWED`]:
//! none may be added, and one that is gone must leave the list. Limit: names are found as text, so that a path within a string counts.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Crates, each with those that it may name.
const CRATES: [(&str, &[&str]); 8] = [
    ("numerics", &[]),
    ("contact", &["numerics"]),
    ("elastic", &["numerics", "contact"]),
    ("sim", &["numerics", "contact", "elastic"]),
    ("scene", &["numerics", "contact", "elastic", "sim"]),
    ("view", &["numerics"]),
    ("validation", &["numerics", "contact", "elastic", "sim", "scene"]),
    ("cli", &["numerics", "contact", "elastic", "sim", "scene", "view", "validation"]),
];

/// Arrows that close circles: crate, the file that names, the file that is named.
const ALLOWED: [(&str, &str, &str); 0] = [];

/// A path of names: `["crate", "grid", "Band"]`.
type Names = Vec<String>;

/// The files of a crate by the path of their module.
struct Crate {
    name: String,
    texts: BTreeMap<Names, String>,
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

impl Crate {
    fn read(name: &str) -> Self {
        let source = root().join(name).join("src");
        let mut texts = BTreeMap::new();
        put_files(&source, &vec!["crate".to_string()], &mut texts);
        Self { name: name.to_string(), texts }
    }

    /// The file of the longest part of a path that is a module, and the name after it.
    fn module(&self, path: &[String]) -> Option<(Names, Option<String>)> {
        (1..=path.len()).rev().find_map(|n| {
            let module = path[..n].to_vec();
            self.texts.contains_key(&module).then(|| (module, path.get(n).cloned()))
        })
    }

    /// The file that a path leads to from a module, re-exports followed.
    fn target(&self, from: &Names, path: &[String]) -> Option<Names> {
        let (mut at, mut item) = self.module(&absolute(from, path)?)?;
        for _ in 0..4 {
            let Some(name) = &item else { break };
            let exports = exports(&at, &self.texts[&at]);
            let Some(next) = exports.get(name).and_then(|path| self.module(path)) else { break };
            (at, item) = next;
        }
        Some(at)
    }

    /// All paths in a folder's text that begin with the name of a module in it, re-exports left out.
    fn paths_to_children(&self, folder: &Names, text: &str) -> Vec<Names> {
        let mut all = Vec::new();
        let children = self.texts.keys().filter(|m| m.len() == folder.len() + 1 && m.starts_with(folder));
        for child in children.filter_map(|m| m.last()) {
            for statement in
                text.split(';').filter(|s| !s.contains("pub use ") && !s.contains("pub(crate) use "))
            {
                for (at, _) in statement.match_indices(&format!("{child}::")) {
                    let before = statement[..at].chars().next_back();
                    if before.is_none_or(|c| !(c.is_alphanumeric() || c == '_' || c == ':')) {
                        tree(&statement[at..], &mut Vec::new(), &mut all);
                    }
                }
            }
        }
        all
    }

    /// The arrows between files: from one that names to one that is named.
    fn arrows(&self) -> BTreeSet<(Names, Names)> {
        let mut arrows = BTreeSet::new();
        for (from, text) in &self.texts {
            for path in paths(text).into_iter().chain(self.paths_to_children(from, text)) {
                let Some(to) = self.target(from, &path) else { continue };
                if to != *from {
                    arrows.insert((from.clone(), to));
                }
            }
        }
        arrows
    }
}

fn put_files(folder: &Path, module: &Names, texts: &mut BTreeMap<Names, String>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let stem = path.file_stem().unwrap().to_string_lossy().into_owned();
        let mut own = module.clone();
        if path.is_dir() {
            own.push(stem);
            put_files(&path, &own, texts);
        } else if path.extension().is_some_and(|e| e == "rs") && !stem.ends_with("tests") {
            if !["mod", "lib", "main"].contains(&stem.as_str()) {
                own.push(stem);
            }
            let text = plain(&std::fs::read_to_string(&path).unwrap());
            texts.entry(own).or_default().push_str(&text);
        }
    }
}

/// A text without comments and tests.
fn plain(text: &str) -> String {
    let code = text.split("#[cfg(test)]\nmod ").next().unwrap_or_default();
    let code = code.split("#[cfg(test)]\npub(crate) mod ").next().unwrap_or_default();
    code.lines().map(|line| line.split("//").next().unwrap_or_default()).collect::<Vec<_>>().join("\n")
}

/// A path from the root of the crate.
fn absolute(from: &Names, path: &[String]) -> Option<Names> {
    let mut at = from.clone();
    let mut rest = path;
    match path.first()?.as_str() {
        "crate" => return Some(path.to_vec()),
        "self" => rest = &path[1..],
        "super" => {
            while rest.first().is_some_and(|name| name == "super") {
                at.pop()?;
                rest = &rest[1..];
            }
        }
        _ => {}
    }
    at.extend(rest.iter().cloned());
    Some(at)
}

/// All paths in a text that begin with `crate::` or `super::`, those in braces one by one.
fn paths(text: &str) -> Vec<Names> {
    let mut all = Vec::new();
    for start in ["crate::", "super::"] {
        for (at, _) in text.match_indices(start) {
            let before = text[..at].chars().next_back();
            if before.is_none_or(|c| !(c.is_alphanumeric() || c == '_' || c == ':')) {
                tree(&text[at..], &mut Vec::new(), &mut all);
            }
        }
    }
    all
}

/// The paths of a use tree at the start of a text, after `prefix`; gives back what follows it.
fn tree<'a>(text: &'a str, prefix: &mut Names, all: &mut Vec<Names>) -> &'a str {
    let mut text = text.trim_start();
    if let Some(mut rest) = text.strip_prefix('{') {
        loop {
            rest = rest.trim_start();
            if let Some(after) = rest.strip_prefix('}') {
                return after;
            }
            let before = rest.len();
            rest = tree(rest, &mut prefix.clone(), all).trim_start();
            rest = rest.strip_prefix(',').unwrap_or(rest);
            if rest.len() == before {
                return rest;
            }
        }
    }
    let end = text.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(text.len());
    prefix.push(text[..end].to_string());
    text = &text[end..];
    match text.strip_prefix("::") {
        Some(rest) if !rest.starts_with('<') => tree(rest, prefix, all),
        _ => {
            all.push(prefix.clone());
            let renamed = text.trim_start().strip_prefix("as ");
            renamed.map_or(text, |rest| rest.trim_start_matches(|c: char| c.is_alphanumeric() || c == '_'))
        }
    }
}

/// The names that a module re-exports, each with its path from the crate's root.
fn exports(module: &Names, text: &str) -> BTreeMap<String, Names> {
    let mut exports = BTreeMap::new();
    for statement in text.split(';') {
        let uses = ["pub use ", "pub(crate) use "].iter().find_map(|start| statement.split(start).nth(1));
        let Some(uses) = uses else { continue };
        let mut all = Vec::new();
        tree(uses, &mut Vec::new(), &mut all);
        for path in all {
            let Some(path) = absolute(module, &path) else { continue };
            exports.insert(path.last().unwrap().clone(), path);
        }
    }
    exports
}

/// The arrows that lie on a circle.
fn circular(arrows: &BTreeSet<(Names, Names)>) -> BTreeSet<(Names, Names)> {
    let mut next: BTreeMap<&Names, Vec<&Names>> = BTreeMap::new();
    arrows.iter().for_each(|(from, to)| next.entry(from).or_default().push(to));
    let reaches = |from: &Names, goal: &Names| {
        let (mut seen, mut stack) = (BTreeSet::new(), vec![from]);
        while let Some(at) = stack.pop() {
            if at == goal {
                return true;
            }
            if seen.insert(at) {
                stack.extend(next.get(at).into_iter().flatten());
            }
        }
        false
    };
    arrows.iter().filter(|(from, to)| reaches(to, from)).cloned().collect()
}

#[test]
fn crates_name_only_those_below_them() {
    for (name, below) in CRATES {
        for (module, text) in &Crate::read(name).texts {
            for (other, _) in CRATES {
                let named = text.contains(&format!("meniscus_{other}"));
                let allowed = other == name || below.contains(&other);
                assert!(!named || allowed, "{name}: {} names meniscus_{other}", module.join("::"));
            }
        }
    }
}

#[test]
fn files_name_each_other_in_no_circle() {
    let mut wrong = Vec::new();
    for (name, _) in CRATES {
        let read = Crate::read(name);
        let arrows = read.arrows();
        let allowed: BTreeSet<(Names, Names)> = ALLOWED
            .iter()
            .filter(|(of, ..)| *of == read.name)
            .map(|(_, from, to)| {
                [from, to].map(|path| path.split("::").map(str::to_string).collect::<Names>())
            })
            .map(|[from, to]| (from, to))
            .collect();
        for gone in allowed.difference(&arrows) {
            wrong.push(format!("{name}: {} does not name {} any more", gone.0.join("::"), gone.1.join("::")));
        }
        let left = arrows.difference(&allowed).cloned().collect();
        for (from, to) in circular(&left) {
            wrong.push(format!(
                "{name}: {} names {}, which leads back to it",
                from.join("::"),
                to.join("::")
            ));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The most entries of a folder of source files.
const ENTRIES: usize = 12;
/// The most lines of a source file.
const LINES: usize = 500;

#[test]
fn folders_have_a_dozen_entries_and_files_five_hundred_lines_at_most() {
    let of = |(name, _): &(&str, _)| ["src", "tests"].map(|part| root().join(name).join(part));
    let mut folders: Vec<PathBuf> = CRATES.iter().flat_map(of).filter(|folder| folder.is_dir()).collect();
    folders.push(root().join("../examples"));
    while let Some(folder) = folders.pop() {
        let entries: Vec<PathBuf> = std::fs::read_dir(&folder).unwrap().map(|e| e.unwrap().path()).collect();
        assert!(entries.len() <= ENTRIES, "{} has {} entries", folder.display(), entries.len());
        let (inner, files): (Vec<_>, Vec<_>) = entries.into_iter().partition(|path| path.is_dir());
        for file in files.iter().filter(|file| file.extension().is_some_and(|name| name == "rs")) {
            let lines = std::fs::read_to_string(file).unwrap().lines().count();
            assert!(lines <= LINES, "{} has {lines} lines", file.display());
        }
        folders.extend(inner);
    }
}
