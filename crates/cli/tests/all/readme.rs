//! Every command of the README and of `meniscus --help` works, in the order in which it is written.

use crate::common::{Place, text};
use meniscus_scene::builtin::BUILTINS;

const README: &str = include_str!("../../../../README.md");

/// The lines of the README's `sh` blocks.
fn of_readme() -> Vec<String> {
    let blocks = README.split("```sh\n").skip(1).map(|rest| rest.split("```").next().unwrap());
    blocks.flat_map(str::lines).filter(|line| !line.trim().is_empty()).map(String::from).collect()
}

/// The README's scene: its first `toml` block.
fn scene_of_readme() -> &'static str {
    let block = README.split("```toml\n").nth(1).expect("a `toml` block");
    block.split("```").next().unwrap()
}

/// The examples of `meniscus --help`.
fn of_help(place: &Place) -> Vec<String> {
    let help = text(&place.run("--help").stdout);
    let start = help.find("First steps").expect("examples");
    help[start..].lines().filter(|l| l.starts_with("  meniscus ")).map(|l| l.trim().to_owned()).collect()
}

/// The words of a command: comments and what stands after two blanks (the explanation) are left out, quotes keep blanks.
fn words(line: &str) -> Vec<String> {
    let line = line.split('#').next().unwrap().trim();
    let line = line.split("  ").next().unwrap();
    let (mut words, mut quote) = (vec![String::new()], None);
    for c in line.chars() {
        match (quote, c) {
            (Some(q), c) if q == c => quote = None,
            (None, '"' | '\'') => quote = Some(c),
            (None, ' ') => words.push(String::new()),
            (_, c) => words.last_mut().unwrap().push(c),
        }
    }
    words
}

/// The arguments of `meniscus` in a line, shortened: 2D scenes run at draft quality for a few frames, 3D ones are checked only.
/// None for commands of other programs.
fn shortened(line: &str) -> Option<Vec<String>> {
    let mut words = words(line);
    let own = |words: &[String], start: &[&str]| {
        words.iter().map(String::as_str).take(start.len()).eq(start.iter().copied())
    };
    let cargo = ["cargo", "run", "--release", "--"];
    if own(&words, &cargo) {
        words.drain(..cargo.len());
    } else if own(&words, &["meniscus"]) {
        words.remove(0);
    } else {
        assert!(
            ["cargo test", "cargo install", "git clone"].iter().any(|known| line.starts_with(known)),
            "{line}"
        );
        return None;
    }
    if words[0] == "run" {
        if BUILTINS.iter().any(|b| b.name == words[1] && b.dimension == 3) {
            return Some(vec!["check".into(), words[1].clone()]);
        }
        if !words.contains(&"--quality".to_owned()) {
            words.extend(["--quality".into(), "draft".into()]);
        }
        if !words.contains(&"--until".to_owned()) {
            words.extend(["--until".into(), "10 ms".into()]);
        }
        words.push("--quiet".into());
    }
    Some(words)
}

fn all_work(place: &Place, lines: &[String], least: usize) {
    let mut count = 0;
    for line in lines {
        let Some(words) = shortened(line) else { continue };
        let output = place.command("").args(&words).output().unwrap();
        let said = text(&output.stdout) + &text(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "`{line}`, run as `{}`, said:\n{said}", words.join(" "));
        if words[0] == "measure" {
            assert!(
                said.contains('°') && !said.contains("nothing"),
                "`{line}` measures no contact angle:\n{said}"
            );
        }
        count += 1;
    }
    assert!(count >= least, "only {count} commands in {lines:?}");
}

#[test]
fn commands_of_the_readme_work() {
    let place = Place::new("readme");
    std::fs::write(place.path("drop.toml"), scene_of_readme()).unwrap();
    all_work(&place, &of_readme(), 6);
}

#[test]
fn commands_of_the_help_work() {
    let place = Place::new("help");
    let lines = of_help(&place);
    all_work(&place, &lines, 6);
}
