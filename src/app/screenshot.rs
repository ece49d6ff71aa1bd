//! Writes pictures: numbered, whole or not at all.

use crate::image::{Picture, write_png};
use std::path::{Path, PathBuf};

/// The most pictures of one name in one folder.
const MOST: u32 = 9999;

/// Writes a picture into the first of `folders` that can be written, named by `stem` and the next free number.
///
/// # Errors
/// What the last folder said.
pub fn write(picture: &Picture, stem: &str, folders: &[PathBuf]) -> Result<PathBuf, String> {
    let mut said = "there is no folder to write to".to_owned();
    for folder in folders {
        match free_path(stem, folder).map(|path| write_png(&path, picture).map(|()| path)) {
            Some(Ok(path)) => return Ok(path),
            Some(Err(e)) => said = e.to_string(),
            None => said = format!("{}: there are {MOST} pictures of that name; move some away", folder.display()),
        }
    }
    Err(format!("the screenshot was not written: {said}; start murrine in a folder that can be written"))
}

/// The current folder, then the user's folder of pictures.
#[must_use]
pub fn folders() -> Vec<PathBuf> {
    let mut folders = Vec::new();
    folders.extend(std::env::current_dir());
    let home = std::env::var_os("HOME").or_else(|| std::env::var_os("USERPROFILE"));
    folders.extend(std::env::var_os("XDG_PICTURES_DIR").map(PathBuf::from));
    folders.extend(home.map(|h| PathBuf::from(h).join("Pictures")));
    folders
}

fn free_path(stem: &str, folder: &Path) -> Option<PathBuf> {
    let stem: String = stem.chars().map(|c| if c.is_alphanumeric() || "-_".contains(c) { c } else { '-' }).collect();
    (1..=MOST).map(|number| folder.join(format!("{stem}-{number:04}.png"))).find(|path| !path.exists())
}
