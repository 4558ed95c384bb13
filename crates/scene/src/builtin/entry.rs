//! The entry of a built-in scene in the list of scenes.

use serde::Serialize;

/// A built-in scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Builtin {
    /// Name.
    pub name: &'static str,
    /// 2 or 3.
    pub dimension: u32,
    /// The figure of the paper that it follows, if any.
    pub figure: Option<&'static str>,
    /// One-line summary of the scene.
    pub line: &'static str,
    /// Approximate cost of a run on two cores.
    pub cost: &'static str,
    /// The scene file.
    #[serde(skip)]
    pub text: &'static str,
}
