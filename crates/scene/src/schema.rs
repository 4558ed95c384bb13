//! The JSON Schema of scene files for editors, and the same as a Markdown page.

use crate::file::Scene;
use crate::output::markdown::{cell, one_line};
use schemars::Schema;
use schemars::generate::SchemaSettings;
use schemars::transform::RecursiveTransform;
use serde_json::Value;
use std::collections::VecDeque;
use std::fmt::Write as _;

/// The JSON Schema of a scene file, as pretty JSON.
pub fn json_schema() -> String {
    serde_json::to_string_pretty(&schema()).unwrap_or_default()
}

/// The schema without defaults: some of them follow from other keys, and the descriptions name all.
fn schema() -> Schema {
    let without_default = |schema: &mut Schema| {
        schema.remove("default");
    };
    let settings = SchemaSettings::default().with_transform(RecursiveTransform(without_default));
    settings.into_generator().into_root_schema_for::<Scene>()
}

const HEAD: &str = "# The scene file\n\n\
    A scene is a TOML file. This page is generated from the JSON Schema \
    (`meniscus schema --markdown > docs/scene.md`); a test fails if it is out of date. \
    `meniscus check SCENE` reports errors in a file and where they are.\n\n\
    **Units.** Every value with a dimension is text with a unit, such as `\"1.2 mm\"`; only `0` needs no \
    unit. Vectors have one entry for each axis; the last axis points up. In 2D all quantities are per metre \
    of depth.\n\n\
    **Editors.** With the schema in a file (`meniscus schema > scene.schema.json`), the line \
    `#:schema ./scene.schema.json` at the top of a scene lets editors that use Taplo (Even Better TOML of \
    VS Code, and others) complete keys and mark errors.\n\n\
    **Tables with one key** select one of several kinds: `shape.ball = { … }`, \
    `material.rigid = { fixed = true }`.\n";

/// The grammar as a page of Markdown: one section per table of a scene, in order of appearance.
pub fn markdown() -> String {
    let schema = schema();
    let root = schema.as_value();
    let mut out = HEAD.to_owned();
    let mut known = vec!["Scene".to_owned()];
    let mut queue = VecDeque::from([("Scene".to_owned(), root.clone())]);
    while let Some((name, node)) = queue.pop_front() {
        let title = if name == "Scene" { "The whole file" } else { &name };
        let _ = write!(out, "\n## {title}\n\n");
        if let Some(text) = node["description"].as_str() {
            let _ = write!(out, "{}\n\n", one_line(text));
        }
        let mut found = Vec::new();
        table(&mut out, &node, &mut found);
        for Found { name, node } in found {
            if !known.contains(&name) {
                queue.push_back((name.clone(), node.unwrap_or_else(|| root["$defs"][&name].clone())));
                known.push(name);
            }
        }
    }
    out
}

/// A definition that another one refers to: by its name, or as a part of the other one.
struct Found {
    name: String,
    node: Option<Value>,
}

/// The keys or values of a definition. Adds the definitions that it refers to to `found`.
fn table(out: &mut String, node: &Value, found: &mut Vec<Found>) {
    let required: Vec<&str> =
        node["required"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
    let mut rows = Vec::new();
    for (key, value) in node["properties"].as_object().into_iter().flatten() {
        let needed = if required.contains(&key.as_str()) { "yes" } else { "" };
        rows.push([format!("`{key}`"), kind(value, found), needed.to_owned(), text_of(value)]);
    }
    if let Some(other) = node.get("additionalProperties").filter(|other| other.is_object()) {
        rows.push(["name of a solid".into(), kind(other, found), String::new(), text_of(other)]);
    }
    if !rows.is_empty() {
        out.push_str("| key | value | required | |\n|---|---|---|---|\n");
    }
    for [key, value, needed, text] in rows {
        let _ = writeln!(out, "| {key} | {value} | {needed} | {text} |");
    }
    for one in node["oneOf"].as_array().into_iter().flatten() {
        for (key, value) in one["properties"].as_object().into_iter().flatten() {
            let text = [text_of(one), text_of(value)].into_iter().find(|t| !t.is_empty()).unwrap_or_default();
            let kind =
                if value["properties"].is_object() { part(key, one, found) } else { kind(value, found) };
            let _ = writeln!(out, "- `{key}`: {kind}. {text}");
        }
        if one["properties"].is_null() {
            let text = text_of(one);
            let _ = writeln!(
                out,
                "- {}{}",
                kind(one, found),
                if text.is_empty() { text } else { format!(": {text}") }
            );
        }
    }
    if node["properties"].is_null() && node["oneOf"].is_null() && node["additionalProperties"].is_null() {
        let _ = writeln!(out, "Value: {}.", kind(node, found));
    }
}

/// A link to the keys of one of several kinds, which have a section of their own.
fn part(key: &str, one: &Value, found: &mut Vec<Found>) -> String {
    let capital = |word: &str| word[..1].to_uppercase() + &word[1..];
    let name: String = key.split('_').map(capital).collect();
    let mut node = one["properties"][key].clone();
    node["description"] = one["description"].clone();
    let link = format!("[{name}](#{})", name.to_lowercase());
    found.push(Found { name, node: Some(node) });
    link
}

fn text_of(node: &Value) -> String {
    node["description"].as_str().map(cell).unwrap_or_default()
}

/// The type of a value in words.
fn kind(node: &Value, found: &mut Vec<Found>) -> String {
    if let Some(name) = node["$ref"].as_str().and_then(|r| r.rsplit('/').next()) {
        found.push(Found { name: name.to_owned(), node: None });
        return format!("[{name}](#{})", name.to_lowercase());
    }
    for key in ["anyOf", "oneOf"] {
        if let Some(all) = node[key].as_array() {
            let all: Vec<String> =
                all.iter().filter(|n| n["type"] != "null").map(|n| kind(n, found)).collect();
            return all.join(" or ");
        }
    }
    if !node["const"].is_null() {
        return format!("`{}`", node["const"]);
    }
    if let Some(values) = node["enum"].as_array() {
        return values.iter().map(|v| format!("`{v}`")).collect::<Vec<_>>().join(", ");
    }
    let types: Vec<&str> = match &node["type"] {
        Value::String(one) => vec![one],
        Value::Array(all) => all.iter().filter_map(Value::as_str).filter(|t| *t != "null").collect(),
        _ => Vec::new(),
    };
    let word = |t: &&str| match *t {
        "array" => match node.get("items") {
            Some(items) => format!("list of {}", kind(items, &mut Vec::new())),
            None => "list".to_owned(),
        },
        "string" => "text".to_owned(),
        "integer" => "whole number".to_owned(),
        "boolean" => "`true` or `false`".to_owned(),
        "object" => "table".to_owned(),
        other => other.to_owned(),
    };
    if let Some(items) = node.get("items") {
        kind(items, found);
    }
    if let Some(other) = node.get("additionalProperties").filter(|other| other.is_object()) {
        return format!("table of {} by name of solid", kind(other, found));
    }
    types.iter().map(word).collect::<Vec<_>>().join(" or ")
}
