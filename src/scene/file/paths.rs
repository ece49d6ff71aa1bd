//! Which files a scene may name: those beside it or under its folder's parent, and nothing beyond.

use std::path::{Component, Path, PathBuf};

/// Checks that `file`, relative to the scene's `folder`, is a readable file with one of the `endings` that does not
/// leave the folder's parent, not by a link either.
///
/// # Errors
/// What is wrong and what to do.
pub(super) fn checked(folder: &Path, file: &str, endings: &[&str]) -> Result<PathBuf, String> {
    let path = PathBuf::from(file);
    let beyond = || format!("`{file}` leaves the scene's surroundings; keep files in the scene's folder or its parent");
    let mut climbed = 0_i32;
    for part in path.components() {
        match part {
            Component::Normal(_) => climbed -= 1,
            Component::ParentDir => climbed += 1,
            Component::CurDir => {}
            Component::RootDir | Component::Prefix(_) => {
                return Err(format!("`{file}` is an absolute path; write it relative to the scene's folder"));
            }
        }
        if climbed > 1 {
            return Err(beyond());
        }
    }
    let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    if !endings.contains(&ending.as_str()) {
        let wanted: Vec<String> = endings.iter().map(|e| format!(".{e}")).collect();
        return Err(format!("`{file}` is no {} file; name one that is", wanted.join(" or ")));
    }
    let full = folder.join(&path);
    let real = full.canonicalize().map_err(|e| format!("can't open `{}`: {e}; check the name", full.display()))?;
    let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let here = here.canonicalize().map_err(|e| format!("can't open the folder `{}`: {e}", here.display()))?;
    if !real.starts_with(here.parent().unwrap_or(&here)) {
        return Err(beyond());
    }
    if !real.is_file() {
        return Err(format!("`{file}` is not a file; name a model or picture"));
    }
    Ok(path)
}
