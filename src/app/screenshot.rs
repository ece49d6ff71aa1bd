//! Writes pictures: numbered, whole or not at all.

use glam::UVec2;
use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// The most pictures of one name in one folder.
const MOST: u32 = 9999;

/// Writes an sRGB picture into the first of `folders` that can be written, named by `stem` and the next free number.
///
/// # Errors
/// What the last folder said.
pub fn write(rgba8: &[u8], size: UVec2, stem: &str, folders: &[PathBuf]) -> Result<PathBuf, String> {
    let mut rgb = Vec::with_capacity(rgba8.len() / 4 * 3);
    for pixel in rgba8.chunks_exact(4) {
        rgb.extend_from_slice(&pixel[..3]);
    }
    let mut png = Vec::new();
    PngEncoder::new(&mut png)
        .write_image(&rgb, size.x, size.y, ExtendedColorType::Rgb8)
        .map_err(|e| format!("the screenshot can't be encoded: {e}"))?;
    let mut said = "there is no folder to write to".to_owned();
    for folder in folders {
        match write_numbered(&png, stem, folder) {
            Ok(path) => return Ok(path),
            Err(e) => said = format!("{}: {e}", folder.display()),
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

fn write_numbered(bytes: &[u8], stem: &str, folder: &Path) -> std::io::Result<PathBuf> {
    let mut file = tempfile::Builder::new().prefix(".murrine-").suffix(".png").tempfile_in(folder)?;
    file.write_all(bytes)?;
    let stem: String = stem.chars().map(|c| if c.is_alphanumeric() || "-_".contains(c) { c } else { '-' }).collect();
    for number in 1..=MOST {
        let path = folder.join(format!("{stem}-{number:04}.png"));
        match file.persist_noclobber(&path) {
            Ok(written) => {
                make_readable(&written)?;
                return Ok(path);
            }
            Err(e) if e.error.kind() == std::io::ErrorKind::AlreadyExists => file = e.file,
            Err(e) => return Err(e.error),
        }
    }
    Err(std::io::Error::other(format!("there are {MOST} pictures of that name; move some away")))
}

/// Temporary files are for their owner alone; a picture is for all who may read the folder.
fn make_readable(file: &std::fs::File) -> std::io::Result<()> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        file.set_permissions(std::fs::Permissions::from_mode(0o644))?;
    }
    let _ = file;
    Ok(())
}
