//! Pictures and arrays on disk: `.png` (8-bit sRGB), `.exr` (linear float) and `.npy`.
//!
//! A file appears whole or not at all: it is written beside its place and then moved there.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// What can go wrong with a picture's file. The text starts with its name and ends with a remedy.
#[derive(Debug, thiserror::Error)]
pub enum ImageError {
    /// The ending says no format that we write.
    #[error("{0}: unknown ending; write .png, .exr or .npy")]
    Ending(PathBuf),
    /// The format can't hold what is asked, or there is none of that ending.
    #[error("{0}: {1}")]
    Unfit(PathBuf, String),
    /// The place can't take a file.
    #[error("{0}: {1}")]
    Place(PathBuf, String),
    /// Writing stopped; nothing was left behind.
    #[error("{0}: can't write it: {1}; nothing was left behind: free some space or choose another folder")]
    Write(PathBuf, String),
    /// Reading stopped.
    #[error("{0}: can't read it: {1}; make it again")]
    Read(PathBuf, String),
}

/// The format of a file, by its ending.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// 8-bit sRGB.
    Png,
    /// Linear float.
    Exr,
    /// NumPy array, float32.
    Npy,
}

impl Format {
    /// The format that the ending of `path` names, once it is sure that a file can stand there.
    ///
    /// # Errors
    /// An unknown ending, a missing folder, or something at `path` that is no file.
    pub fn of(path: &Path) -> Result<Self, ImageError> {
        let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
        let format = match ending.as_str() {
            "png" => Self::Png,
            "exr" => Self::Exr,
            "npy" => Self::Npy,
            _ => return Err(ImageError::Ending(path.to_owned())),
        };
        check_place(path)?;
        Ok(format)
    }
}

/// An 8-bit sRGB picture.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Row by row from the top.
    pub rgb8: Vec<[u8; 3]>,
}

/// A picture of floats.
#[derive(Debug, Clone, PartialEq)]
pub struct Floats {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Values a pixel: 1 or 3.
    pub components: usize,
    /// Row by row from the top.
    pub values: Vec<f32>,
}

impl Floats {
    /// The values of the pixel in column `x` and row `y`.
    #[must_use]
    pub fn at(&self, x: usize, y: usize) -> &[f32] {
        let first = (y * self.width as usize + x) * self.components;
        &self.values[first..first + self.components]
    }

    /// The largest finite magnitude, 0 where there is none.
    #[must_use]
    pub fn largest(&self) -> f32 {
        self.values.iter().filter(|v| v.is_finite()).fold(0.0, |most, v| most.max(v.abs()))
    }
}

/// Writes a file beside `path` with `write` and then moves it there.
///
/// # Errors
/// When the place can't take it or the disk is full; then nothing is left behind.
pub fn atomically(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<&File>) -> std::io::Result<()>,
) -> Result<(), ImageError> {
    check_place(path)?;
    let failed = |e: &dyn std::fmt::Display| ImageError::Write(path.to_owned(), e.to_string());
    let mut builder = tempfile::Builder::new();
    builder.prefix(".murrine-").suffix(".part");
    #[cfg(unix)]
    {
        // As any new file: what the user's mask leaves of it.
        use std::os::unix::fs::PermissionsExt as _;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let file = builder.tempfile_in(folder_of(path)).map_err(|e| failed(&e))?;
    let mut buffered = BufWriter::new(file.as_file());
    write(&mut buffered).and_then(|()| buffered.flush()).map_err(|e| failed(&e))?;
    drop(buffered);
    file.persist(path).map_err(|e| failed(&e.error))?;
    Ok(())
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Refuses a place that can't take a file.
///
/// # Errors
/// A missing folder, or something at `path` that is no file.
pub fn check_place(path: &Path) -> Result<(), ImageError> {
    let error = |what: &str| Err(ImageError::Place(path.to_owned(), what.to_owned()));
    if !folder_of(path).is_dir() {
        return error("its folder does not exist; make it or choose another");
    }
    match std::fs::metadata(path) {
        Ok(about) if !about.is_file() => error("something that is no file stands there; choose another name"),
        _ => Ok(()),
    }
}

/// Writes an 8-bit sRGB `.png`.
///
/// # Errors
/// See [`atomically`].
pub fn write_png(path: &Path, picture: &Picture) -> Result<(), ImageError> {
    use image::ImageEncoder as _;
    let encode = |to: &mut BufWriter<&File>| {
        let bytes: &[u8] = bytemuck::cast_slice(&picture.rgb8);
        let encoder = image::codecs::png::PngEncoder::new(to);
        encoder
            .write_image(bytes, picture.width, picture.height, image::ExtendedColorType::Rgb8)
            .map_err(std::io::Error::other)
    };
    atomically(path, encode)
}

/// Writes a linear float `.exr`: channels R, G, B, or Y alone. NaN stays NaN.
///
/// # Errors
/// See [`atomically`].
pub fn write_exr(path: &Path, floats: &Floats) -> Result<(), ImageError> {
    use exr::prelude::{
        AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, WritableImage as _,
    };
    let names: &[&str] = if floats.components == 1 { &["Y"] } else { &["R", "G", "B"] };
    let channels = names.iter().enumerate().map(|(c, name)| {
        let samples = floats.values.iter().skip(c).step_by(floats.components).copied().collect();
        AnyChannel::new(*name, FlatSamples::F32(samples))
    });
    let size = (floats.width as usize, floats.height as usize);
    let layer =
        Layer::new(size, LayerAttributes::default(), Encoding::FAST_LOSSLESS, AnyChannels::sort(channels.collect()));
    // The encoder seeks, so it writes to memory first.
    let mut bytes = std::io::Cursor::new(Vec::new());
    Image::from_layer(layer)
        .write()
        .to_buffered(&mut bytes)
        .map_err(|e| ImageError::Write(path.to_owned(), e.to_string()))?;
    atomically(path, |to| to.write_all(bytes.get_ref()))
}

/// Writes a float32 `.npy` of shape \[height\]\[width\]\[components\].
///
/// # Errors
/// See [`atomically`].
pub fn write_npy(path: &Path, floats: &Floats) -> Result<(), ImageError> {
    let shape = [u64::from(floats.height), u64::from(floats.width), floats.components as u64];
    write_array(path, &shape, &floats.values)
}

/// Writes an array of any shape, last index fastest.
///
/// # Errors
/// See [`atomically`].
pub fn write_array<T: npyz::AutoSerialize + Copy>(path: &Path, shape: &[u64], values: &[T]) -> Result<(), ImageError> {
    use npyz::WriterBuilder as _;
    atomically(path, |to| {
        let mut writer = npyz::WriteOptions::new().default_dtype().shape(shape).writer(to).begin_nd()?;
        writer.extend(values.iter().copied())?;
        writer.finish()
    })
}

/// Writes a u8 array of any shape, last index fastest, from its parts in order; the first that could not be made ends it.
///
/// # Errors
/// See [`atomically`], and those of the parts.
pub fn write_bytes<E: From<ImageError>>(
    path: &Path,
    shape: &[u64],
    parts: impl Iterator<Item = Result<Vec<u8>, E>>,
) -> Result<(), E> {
    use npyz::WriterBuilder as _;
    let mut failed = None;
    let written = atomically(path, |to| {
        let header = npyz::WriteOptions::<u8>::new().default_dtype().shape(shape).writer(&mut *to);
        header.write_header_only()?;
        for part in parts {
            match part {
                Ok(bytes) => to.write_all(&bytes)?,
                Err(error) => {
                    failed = Some(error);
                    return Err(std::io::ErrorKind::Interrupted.into());
                }
            }
        }
        Ok(())
    });
    failed.map_or(written.map_err(E::from), Err)
}

/// Reads an 8-bit `.png`.
///
/// # Errors
/// When there is none, or it is damaged.
pub fn read_png(path: &Path) -> Result<Picture, ImageError> {
    let failed = |e: &dyn std::fmt::Display| ImageError::Read(path.to_owned(), e.to_string());
    let mut reader = image::ImageReader::open(path).map_err(|e| failed(&e))?;
    reader.set_format(image::ImageFormat::Png);
    let picture = reader.decode().map_err(|e| failed(&e))?.into_rgb8();
    let (width, height) = picture.dimensions();
    Ok(Picture { width, height, rgb8: picture.pixels().map(|p| p.0).collect() })
}

/// Reads an `.exr` that [`write_exr`] wrote.
///
/// # Errors
/// When there is none, or it is damaged.
pub fn read_exr(path: &Path) -> Result<Floats, ImageError> {
    let failed = |e: &dyn std::fmt::Display| ImageError::Read(path.to_owned(), e.to_string());
    let image = exr::prelude::read_first_flat_layer_from_file(path).map_err(|e| failed(&e))?;
    let layer = image.layer_data;
    let names: &[&str] = if layer.channel_data.list.len() == 1 { &["Y"] } else { &["R", "G", "B"] };
    let mut values = vec![0.0; layer.size.0 * layer.size.1 * names.len()];
    for (c, name) in names.iter().enumerate() {
        let channel = layer.channel_data.list.iter().find(|channel| channel.name.to_string() == *name);
        let channel = channel.ok_or_else(|| failed(&format!("it has no channel {name}")))?;
        let slots = values.iter_mut().skip(c).step_by(names.len());
        for (slot, sample) in slots.zip(channel.sample_data.values_as_f32()) {
            *slot = sample;
        }
    }
    let size = |n: usize| u32::try_from(n).map_err(|e| failed(&e));
    Ok(Floats { width: size(layer.size.0)?, height: size(layer.size.1)?, components: names.len(), values })
}

/// Reads a `.npy` array: its shape and values, last index fastest.
///
/// # Errors
/// When there is none, it is damaged, or holds another type.
pub fn read_array<T: npyz::Deserialize>(path: &Path) -> Result<(Vec<u64>, Vec<T>), ImageError> {
    let failed = |e: &dyn std::fmt::Display| ImageError::Read(path.to_owned(), e.to_string());
    let file = File::open(path).map_err(|e| failed(&e))?;
    let array = npyz::NpyFile::new(std::io::BufReader::new(file)).map_err(|e| failed(&e))?;
    let shape = array.shape().to_vec();
    let values = array.into_vec().map_err(|e| failed(&e))?;
    Ok((shape, values))
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a test that can't go on has failed")]
    use super::*;

    fn floats(components: usize) -> Floats {
        let (width, height) = (5, 3);
        let mut values: Vec<f32> = (0..15 * components).map(|i| i as f32 * 0.37 - 2.0).collect();
        values[4] = f32::NAN;
        values[6] = 1e30;
        Floats { width, height, components, values }
    }

    fn same(a: &[f32], b: &[f32]) -> bool {
        a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits())
    }

    #[test]
    fn floats_come_back_to_the_last_bit() {
        let folder = tempfile::tempdir().unwrap();
        for components in [1, 3] {
            let floats = floats(components);
            let exr = folder.path().join("a.exr");
            write_exr(&exr, &floats).unwrap();
            let back = read_exr(&exr).unwrap();
            assert_eq!((back.width, back.height, back.components), (5, 3, components));
            assert!(same(&back.values, &floats.values));

            let npy = folder.path().join("a.npy");
            write_npy(&npy, &floats).unwrap();
            let (shape, values) = read_array::<f32>(&npy).unwrap();
            assert_eq!(shape, [3, 5, components as u64]);
            assert!(same(&values, &floats.values));
            let other: Vec<f32> = floats.values.iter().map(|v| v + 1.0).collect();
            assert!(!same(&values, &other));
        }
    }

    #[test]
    fn a_png_comes_back_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let rgb8 = (0..6u8).map(|i| [i, 255 - i, i * 40]).collect();
        let picture = Picture { width: 3, height: 2, rgb8 };
        let path = folder.path().join("a.png");
        write_png(&path, &picture).unwrap();
        assert_eq!(read_png(&path).unwrap(), picture);
        std::fs::write(&path, b"\x89PNG\r\n\x1a\nrubbish").unwrap();
        assert!(read_png(&path).is_err());
    }

    #[test]
    fn what_fails_half_way_leaves_the_old_file_and_no_other() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.npy");
        std::fs::write(&path, b"old").unwrap();
        let full = atomically(&path, |to| {
            to.write_all(&[0; 100_000])?;
            Err(std::io::ErrorKind::StorageFull.into())
        });
        let told = full.unwrap_err().to_string();
        assert!(told.starts_with(&path.display().to_string()) && told.contains("free some space"), "{told}");
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn places_that_take_no_file_are_refused_before_any_work() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("folder.png")).unwrap();
        assert!(matches!(Format::of(&folder.path().join("folder.png")), Err(ImageError::Place(..))));
        assert!(matches!(Format::of(&folder.path().join("no/such.png")), Err(ImageError::Place(..))));
        assert!(matches!(Format::of(&folder.path().join("a.jpg")), Err(ImageError::Ending(_))));
        assert_eq!(Format::of(&folder.path().join("a.PNG")).unwrap(), Format::Png);
    }
}
