//! `meniscus scenes` and `meniscus new`.

use super::print;
use crate::args::NewArgs;
use crate::failure::{Failure, OUTPUT, Result, USAGE};
use meniscus_scene::builtin::{BUILTINS, find};
use meniscus_scene::error::nearest;
use std::fmt::Write as _;

/// Lists the built-in scenes.
pub fn list(json: bool) -> Result {
    if json {
        print(&format!("{:#}\n", serde_json::json!(&BUILTINS[..])))?;
        return Ok(0);
    }
    let width = BUILTINS.iter().map(|b| b.name.len()).max().unwrap_or(0);
    let mut out = String::new();
    for b in &BUILTINS {
        let figure = b.figure.map_or_else(String::new, |figure| format!(" [{figure}]"));
        let _ = writeln!(out, "{:width$}  {}D  {}{figure}", b.name, b.dimension, b.line);
        let _ = writeln!(out, "{:width$}      {}", "", b.cost);
    }
    out += "\nmeniscus run NAME runs one; meniscus new NAME -o my.toml makes a copy to change\n";
    print(&out)?;
    Ok(0)
}

/// Writes the commented file of a built-in scene.
pub fn new(args: &NewArgs) -> Result {
    let Some(name) = args.preset.as_deref().filter(|_| !args.list) else { return list(false) };
    let Some(scene) = find(name) else {
        let near = nearest(name, BUILTINS.iter().map(|b| b.name));
        let near = near.map_or_else(String::new, |near| format!("did you mean `{near}`? "));
        return Err(Failure::new(USAGE, format!("there is no built-in scene `{name}`"))
            .help(format!("{near}`meniscus scenes` lists them")));
    };
    let Some(path) = &args.output else {
        print(scene.text)?;
        return Ok(0);
    };
    if path.exists() {
        return Err(Failure::new(OUTPUT, format!("`{}` exists already", path.display()))
            .help("choose another name: nothing is overwritten"));
    }
    super::save(path, scene.text)?;
    print(&format!("{}: run it with\n  meniscus run {}\n", path.display(), path.display()))?;
    Ok(0)
}
