//! `meniscus scenes` and `meniscus new`.

use super::print;
use crate::args::NewArgs;
use crate::failure::{Failure, OUTPUT, Result, USAGE};
use meniscus_scene::builtin::{BUILTINS, find};
use meniscus_scene::error::nearest;
use std::fmt::Write as _;
use std::path::Path;

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
    let name = scene_name(path).unwrap_or_else(|| scene.name.to_owned());
    let line = |name: &str| format!("\nname = \"{name}\"\n");
    super::save(path, &scene.text.replacen(&line(scene.name), &line(&name), 1))?;
    let file = path.display();
    print(&format!("{file}: run it with\n  meniscus run {file}\ninto the folder out/{name}\n"))?;
    Ok(0)
}

/// The name of the scene in a file of this name, so that a copy does not use the output folder of its original. None if the file's name
/// yields no valid one.
fn scene_name(path: &Path) -> Option<String> {
    let stem = path.file_stem()?.to_string_lossy();
    let fine = |c: char| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '-' };
    let name: String = stem.trim_start_matches('.').chars().map(fine).take(100).collect();
    name.contains(|c: char| c.is_ascii_alphanumeric()).then_some(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_names_its_scene() {
        let name = |path: &str| scene_name(Path::new(path));
        assert_eq!(name("cases/my.toml").as_deref(), Some("my"));
        assert_eq!(name("my drop (2).toml").as_deref(), Some("my-drop--2-"));
        assert_eq!(name(".hidden").as_deref(), Some("hidden"));
        assert_eq!(name("---.toml"), None);
    }
}
