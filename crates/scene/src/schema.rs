//! The JSON Schema of scene files, for editors.

use crate::file::SceneFile;

/// The JSON Schema of a scene file, as pretty JSON.
pub fn json_schema() -> String {
    let schema = schemars::schema_for!(SceneFile);
    serde_json::to_string_pretty(&schema).unwrap_or_default()
}
