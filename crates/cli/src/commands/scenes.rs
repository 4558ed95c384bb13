//! `meniscus scenes` and `meniscus new`.

use super::{grid_text, print};
use crate::args::{NewArgs, ScenesArgs};
use crate::failure::{Failure, OUTPUT, Result, USAGE};
use meniscus_scene::builtin::{BUILTINS, Builtin, find, open};
use meniscus_scene::error::nearest;
use meniscus_scene::file::LoadOptions;
use meniscus_scene::output::markdown::row;
use std::fmt::Write as _;
use std::path::Path;

/// Start of the page of Markdown, up to the rows of its table.
const PAGE_HEAD: &str = "# Built-in scenes\n\n\
    `meniscus run NAME` runs a scene, and `meniscus new NAME -o my.toml` writes a copy of its file to change. Cells are those of \
    `--quality normal`; times are approximate. A scene with a figure follows that figure of the paper *Hydrophobic and Hydrophilic \
    Solid-Fluid Interaction* (Liu et al. 2022), and the first lines of its file say what it takes from the paper. Scenes whose \
    names end in `-paper-constants` have the constants that the paper prints. This page is made by `meniscus scenes --markdown > \
    docs/scenes.md`.\n\n\
    | scene | dimension | cells | description | figure | time on two cores |\n|---|---|---|---|---|---|\n";

/// Lists the built-in scenes.
pub fn list(args: &ScenesArgs) -> Result {
    let out = if args.json {
        format!("{:#}\n", serde_json::json!(&BUILTINS[..]))
    } else if args.markdown {
        page(&BUILTINS)?
    } else {
        text()
    };
    print(&out)?;
    Ok(0)
}

/// The built-in scenes as text for a terminal.
fn text() -> String {
    let width = BUILTINS.iter().map(|b| b.name.len()).max().unwrap_or(0);
    let mut out = String::new();
    for b in &BUILTINS {
        let figure = b.figure.map_or_else(String::new, |figure| format!(" [{figure}]"));
        let _ = writeln!(out, "{:width$}  {}D  {}{figure}", b.name, b.dimension, b.line);
        let _ = writeln!(out, "{:width$}      {}", "", b.cost);
    }
    out + "\nmeniscus run NAME runs one; meniscus new NAME -o my.toml makes a copy to change\n"
}

/// Scenes as a page of Markdown, which links their files as seen from the folder `docs`.
fn page(scenes: &[Builtin]) -> Result<String> {
    let mut out = String::from(PAGE_HEAD);
    for b in scenes {
        let scene = open(b.name, &LoadOptions::default())?;
        out += &row(&[
            format!("[`{0}`](../scenes/{0}.toml)", b.name),
            format!("{}D", b.dimension),
            grid_text(&scene.domain.cells),
            b.line.to_owned(),
            b.figure.unwrap_or_default().to_owned(),
            b.cost.replace("--quality draft", "`--quality draft`"),
        ]);
    }
    Ok(out)
}

/// Writes the commented file of a built-in scene.
pub fn new(args: &NewArgs) -> Result {
    let Some(name) = args.preset.as_deref().filter(|_| !args.list) else {
        print(&text())?;
        return Ok(0);
    };
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

    #[test]
    fn the_page_has_a_row_for_each_scene() {
        let scenes = ["fig12-contact-angle-45-2d", "fig02-soft-cow"].map(|name| *find(name).unwrap());
        let page = page(&scenes).unwrap();
        let rows: Vec<&str> = page.lines().filter(|line| line.starts_with("| [")).collect();
        let drop = "| [`fig12-contact-angle-45-2d`](../scenes/fig12-contact-angle-45-2d.toml) | 2D | 160 × 56 \
                    | A disc of liquid settles on a plate at Young's angle | Fig. 12 | ten seconds |";
        assert_eq!(rows[0], drop);
        assert!(rows[1].contains("| 3D | 96³ |") && rows[1].ends_with("; `--quality draft`: six minutes |"));
        assert_eq!(rows.len(), 2, "{page}");
    }
}
