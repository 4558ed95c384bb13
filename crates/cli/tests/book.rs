//! The book and the other pages name files and items of the code by links, and every link leads somewhere.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

/// All files below a folder whose names end with `ending`, sorted.
fn files(folder: &Path, ending: &str) -> Vec<PathBuf> {
    let mut out = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()) {
        match entry.is_dir() {
            true => out.extend(files(&entry, ending)),
            false if entry.to_string_lossy().ends_with(ending) => out.push(entry),
            false => {}
        }
    }
    out.sort();
    out
}

/// The pages: those of the book and the documentation, and those at the root.
fn pages() -> Vec<PathBuf> {
    let root = root();
    let mut pages = [files(&root.join("book"), ".md"), files(&root.join("docs"), ".md")].concat();
    pages.extend(["README.md", "ARCHITECTURE.md", "CHANGELOG.md"].map(|name| root.join(name)));
    pages
}

/// The links of a page, text and target, outside blocks of code.
fn links(page: &str) -> Vec<(String, String)> {
    let mut out = Vec::new();
    for (i, block) in page.split("```").enumerate() {
        let mut rest = if i % 2 == 0 { block } else { "" };
        while let Some(middle) = rest.find("](") {
            let text = rest[..middle].rsplit('[').next().unwrap_or("").to_string();
            let after = &rest[middle + 2..];
            let end = after.find(')').unwrap_or(after.len());
            out.push((text, after[..end].trim().to_string()));
            rest = &after[end..];
        }
    }
    out
}

/// The last identifier of a text in backticks, such as `b` of `` `a::b()` ``.
fn named_item(text: &str) -> Option<&str> {
    let name = text.strip_prefix('`')?.strip_suffix('`')?;
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let mut words = name.split(|c| !is_word(c)).filter(|word| !word.is_empty());
    words.next_back().filter(|_| !name.contains('.') && !name.contains('/'))
}

/// Whether a text contains a whole word.
fn has_word(text: &str, word: &str) -> bool {
    text.split(|c: char| !(c.is_alphanumeric() || c == '_')).any(|w| w == word)
}

#[test]
fn links_lead_to_files_that_have_the_named_items() {
    let mut wrong = Vec::new();
    for page in pages() {
        let text = std::fs::read_to_string(&page).unwrap();
        for (name, target) in links(&text) {
            let file = target.split('#').next().unwrap();
            if file.is_empty() || file.contains("://") {
                continue;
            }
            let path = page.parent().unwrap().join(file);
            if !path.exists() {
                wrong.push(format!("{}: no file {target}", page.display()));
            } else if let Some(item) = named_item(&name).filter(|_| file.ends_with(".rs"))
                && !has_word(&std::fs::read_to_string(&path).unwrap(), item)
            {
                wrong.push(format!("{}: no `{item}` in {target}", page.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn the_summary_lists_every_page_of_the_book() {
    let book = root().join("book");
    let summary = std::fs::read_to_string(book.join("SUMMARY.md")).unwrap();
    let listed: BTreeSet<String> = links(&summary).into_iter().map(|(_, target)| target).collect();
    let name = |page: &PathBuf| page.strip_prefix(&book).unwrap().to_string_lossy().replace('\\', "/");
    let all = files(&book, ".md").iter().map(name).filter(|page| page != "SUMMARY.md").collect::<Vec<_>>();
    let missing: Vec<&String> = all.iter().filter(|page| !listed.contains(*page)).collect();
    assert!(missing.is_empty(), "not in book/SUMMARY.md: {missing:?}");
}

#[test]
fn pages_that_the_code_names_exist() {
    let (root, mut wrong) = (root(), Vec::new());
    for source in files(&root.join("crates"), ".rs") {
        let text = std::fs::read_to_string(&source).unwrap();
        for (at, _) in text.match_indices("book/") {
            let page: String =
                text[at..].chars().take_while(|c| c.is_alphanumeric() || "/-_.".contains(*c)).collect();
            let page = page.trim_end_matches('.');
            if page.ends_with(".md") && !root.join(page).exists() {
                wrong.push(format!("{}: {page}", source.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Paragraphs shorter than this may recur, such as a line of a table's head.
const SHORT_PARAGRAPH: usize = 160;

#[test]
fn no_paragraph_stands_twice() {
    let mut seen: BTreeSet<String> = BTreeSet::new();
    let mut twice = Vec::new();
    for page in pages() {
        let text = std::fs::read_to_string(&page).unwrap();
        for paragraph in text.split("\n\n").map(str::trim).filter(|p| p.len() >= SHORT_PARAGRAPH) {
            if !seen.insert(paragraph.to_string()) {
                twice.push(format!("{}: {}", page.display(), paragraph.lines().next().unwrap_or("")));
            }
        }
    }
    assert!(twice.is_empty(), "{}", twice.join("\n"));
}
