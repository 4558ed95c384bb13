//! The text of `scene.toml` in an output folder.

use crate::job::Job;

/// Start of the line with the identity.
const IDENTITY: &str = "# identity ";

/// The scene file of the output: a comment with the identity, then the scene.
pub fn scene_text(job: &Job) -> String {
    format!(
        "# The scene as run by Meniscus {}: running it again gives this run.\n{IDENTITY}{:016x}\n\n{}",
        env!("CARGO_PKG_VERSION"),
        job.identity,
        job.text
    )
}

/// The identity in such a text.
pub fn identity_line(text: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(IDENTITY))?;
    u64::from_str_radix(line.trim(), 16).ok()
}
