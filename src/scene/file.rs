//! Reads scene files (TOML) and changes them by path.

use super::{Scene, SceneError, Warning};
use std::path::Path;

/// Reads a scene file, or makes the default scene around a model file (`.glb`, `.gltf`).
///
/// # Errors
/// `file:line:column: what is wrong; what to do`.
pub fn read(path: &Path) -> Result<(Scene, Vec<Warning>), SceneError> {
    Err(SceneError::new(path.display().to_string(), "reading is being built"))
}

/// Reads scene text. `path` is for messages; its folder is what files are relative to.
///
/// # Errors
/// `file:line:column: what is wrong; what to do`.
pub fn parse(text: &str, path: &Path) -> Result<(Scene, Vec<Warning>), SceneError> {
    let _ = text;
    Err(SceneError::new(path.display().to_string(), "reading is being built"))
}

/// Applies `--set path=value`, such as `effect.max_events=4` or `model.0.material.0.ior=1.3`, to scene text before it
/// is parsed, so that the same checks and messages hold.
///
/// # Errors
/// When the path names no key or the value is no TOML value.
pub fn set(text: &str, assignment: &str) -> Result<String, SceneError> {
    let _ = text;
    Err(SceneError::new(format!("--set {assignment}"), "setting is being built"))
}
