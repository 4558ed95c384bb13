//! Warnings about a scene.

/// Warnings: suspicious values that do not prevent a run.
#[derive(Clone, Debug, Default)]
pub struct Warnings(pub Vec<Warning>);

impl PartialEq for Warnings {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// A warning.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Warning {
    /// Dotted path of the value.
    pub path: String,
    /// Message.
    pub message: String,
}
