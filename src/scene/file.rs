//! Reads, changes and writes scene files (TOML).
//!
//! [`read()`] is the way in. Every complaint is `file:line:column: what is wrong; what to do`.

mod amend;
mod paths;
mod read;
mod section;
mod set;
mod write;

use super::{Scene, SceneError, Warning};
use section::Text;
use std::path::Path;
use toml_edit::Document;

pub use amend::amended;
pub use read::{BACKGROUNDS, DEFORMERS, LIGHTS, SHAPES};
pub use set::set;
pub use write::to_toml;

/// The largest scene file, bytes.
const LARGEST_TEXT: u64 = 1 << 20;

/// Reads a scene file, or makes the default scene around a model file (`.glb`, `.gltf`, `.npz`), and applies the `--set`
/// assignments. `methods` are the names of the voxelizers there are.
///
/// # Errors
/// `file:line:column: what is wrong; what to do`, or `--set assignment: …`.
pub fn read(path: &Path, sets: &[String], methods: &[&str]) -> Result<(Scene, Vec<Warning>), SceneError> {
    let mut text = text_of(path)?;
    let mut scene = parse(&text, path, methods)?;
    for assignment in sets {
        text = set(&text, assignment)?;
        // Every line may have moved, so the assignment is the place.
        scene = parse(&text, path, methods).map_err(|e| SceneError::new(format!("--set {assignment}"), e.what))?;
    }
    Ok(scene)
}

/// Reads scene text. `path` is for messages; its folder is what files are relative to.
///
/// # Errors
/// `file:line:column: what is wrong; what to do`.
pub fn parse(text: &str, path: &Path, methods: &[&str]) -> Result<(Scene, Vec<Warning>), SceneError> {
    let name = path.display().to_string();
    let source = Text { text, name: &name };
    let document = Document::parse(text).map_err(|e| {
        let what: Vec<&str> = e.message().lines().map(str::trim).filter(|line| !line.is_empty()).collect();
        source.error(&e.span(), format!("not TOML: {}; mend the line", what.join(", ")))
    })?;
    read::scene(source, document.as_table(), path.parent().unwrap_or(Path::new("")), methods)
}

/// The scene text that `path` stands for: its own, or for a model the default scene around it.
///
/// # Errors
/// When the file can't be read, is too large or is neither.
pub fn text_of(path: &Path) -> Result<String, SceneError> {
    let name = path.display().to_string();
    let error = |what: String| SceneError::new(name.clone(), what);
    let about = std::fs::metadata(path).map_err(|e| error(format!("can't open it: {e}; check the name")))?;
    if !about.is_file() {
        return Err(error("it is no file; name a scene (.toml) or a model (.glb, .gltf, .npz)".to_owned()));
    }
    let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    match ending.as_str() {
        "glb" | "gltf" | "npz" => default_around(path).map_err(error),
        "toml" if about.len() > LARGEST_TEXT => {
            Err(error(format!("{} bytes are too many for a scene; keep it under {LARGEST_TEXT}", about.len())))
        }
        "toml" => {
            let bytes = std::fs::read(path).map_err(|e| error(format!("can't read it: {e}")))?;
            String::from_utf8(bytes)
                .map_err(|e| error(format!("byte {} is no UTF-8; save it as UTF-8", e.utf8_error().valid_up_to())))
        }
        _ => Err(error("neither a scene (.toml) nor a model (.glb, .gltf, .npz); rename or convert it".to_owned())),
    }
}

/// The default scene around a model: a pale ground, a warm key light, a soft sky.
fn default_around(path: &Path) -> Result<String, String> {
    let name = |part: Option<&std::ffi::OsStr>| {
        let text = part.and_then(|p| p.to_str()).ok_or("its name is no UTF-8; rename it".to_owned())?;
        Ok::<_, String>(toml_edit::Value::from(text).to_string())
    };
    let (stem, file) = (name(path.file_stem())?, name(path.file_name())?);
    Ok(DEFAULT_SCENE.replace("{stem}", &stem).replace("{file}", &file))
}

/// See [`crate::scene::framing`] for the space that a framed scene is written in.
const DEFAULT_SCENE: &str = r#"[camera]
frame = true
eye = [0.9, 0.75, 2.4]
target = [0.0, 0.0, 0.0]

[background]
kind = "sky"

[[light]]
kind = "directional"
direction = [0.75, -0.8, 0.35]
color = [1.0, 0.86, 0.68]
intensity = 3.0

[[model]]
name = {stem}
file = {file}

[[model]]
shape = "plane"
size = 60.0
[[model.material]]
opaque = true
base_color = [0.62, 0.59, 0.55]
checker_color = [0.50, 0.475, 0.44]
checker_square = 0.6
"#;
