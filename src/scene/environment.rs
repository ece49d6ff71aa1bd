//! Equirectangular pictures of the surroundings, `.hdr` and `.exr`.

use super::SceneError;
use glam::Vec3;
use image::{DynamicImage, ImageDecoder, ImageFormat};
use std::path::Path;

/// The largest file that is read.
const MAX_FILE_BYTES: u64 = 1 << 30;
/// The widest picture that is decoded.
const MAX_DECODED_SIDE: u32 = 8192;
/// The widest picture that is kept; wider ones are averaged down.
const MAX_WIDTH: u32 = 4096;
/// The brightest that a texel can be: what a half float holds.
const MAX_RADIANCE: f32 = 65504.0;

/// An equirectangular environment.
#[derive(Debug, Clone, PartialEq)]
pub struct EnvironmentMap {
    /// Texels.
    pub width: u32,
    /// Texels.
    pub height: u32,
    /// Linear RGB, row by row from the zenith.
    pub rgb: Vec<[f32; 3]>,
}

/// Reads an environment.
///
/// # Errors
/// When the file can't be read, or is no `.hdr` or `.exr` picture of a size that can be held.
pub fn read(path: &Path) -> Result<EnvironmentMap, SceneError> {
    let place = path.display().to_string();
    let fault = |what: String| SceneError::new(&place, what);
    let unreadable = |e: std::io::Error| fault(format!("can't be read: {e}; name a .hdr or .exr picture"));
    let meta = std::fs::metadata(path).map_err(unreadable)?;
    if !meta.is_file() || meta.len() > MAX_FILE_BYTES {
        return Err(fault(format!("is no file of at most {MAX_FILE_BYTES} bytes; name a .hdr or .exr picture")));
    }
    parse(&std::fs::read(path).map_err(unreadable)?).map_err(fault)
}

/// Reads an environment from its bytes; what is wrong is told in words.
///
/// # Errors
/// As [`read`].
pub fn parse(bytes: &[u8]) -> Result<EnvironmentMap, String> {
    let broken = |e: image::ImageError| format!("can't be decoded: {e}; name another .hdr or .exr picture");
    let cursor = std::io::Cursor::new(bytes);
    let decoded = match image::guess_format(bytes) {
        Ok(ImageFormat::Hdr) => decode(image::codecs::hdr::HdrDecoder::new(cursor).map_err(broken)?)?,
        Ok(ImageFormat::OpenExr) => decode(image::codecs::openexr::OpenExrDecoder::new(cursor).map_err(broken)?)?,
        _ => return Err("is no .hdr or .exr picture; convert it".to_owned()),
    };
    let mut map = EnvironmentMap {
        width: decoded.width(),
        height: decoded.height(),
        rgb: decoded.into_rgb32f().pixels().map(|p| sound(p.0)).collect(),
    };
    while map.width > MAX_WIDTH || map.height > MAX_WIDTH {
        map = map.halved();
    }
    Ok(map)
}

fn decode(decoder: impl ImageDecoder) -> Result<DynamicImage, String> {
    let (width, height) = decoder.dimensions();
    if width == 0 || height == 0 || width > MAX_DECODED_SIDE || height > MAX_DECODED_SIDE / 2 {
        let most = MAX_DECODED_SIDE / 2;
        return Err(format!(
            "has {width}×{height} texels; at most {MAX_DECODED_SIDE}×{most} can be read, scale it down"
        ));
    }
    DynamicImage::from_decoder(decoder).map_err(|e| format!("can't be decoded: {e}; name another .hdr or .exr picture"))
}

/// Radiance is neither negative nor endless.
fn sound(rgb: [f32; 3]) -> [f32; 3] {
    rgb.map(|x| if x.is_nan() { 0.0 } else { x.clamp(0.0, MAX_RADIANCE) })
}

impl EnvironmentMap {
    /// Half as wide and high, each texel the mean of four.
    fn halved(&self) -> Self {
        let (width, height) = (self.width.div_ceil(2), self.height.div_ceil(2));
        let texel = |x: u32, y: u32| {
            let (x, y) = (x.min(self.width - 1) as usize, y.min(self.height - 1) as usize);
            Vec3::from_array(self.rgb[y * self.width as usize + x])
        };
        let mut rgb = Vec::with_capacity(width as usize * height as usize);
        for y in 0..height {
            for x in 0..width {
                let (x, y) = (2 * x, 2 * y);
                let sum = texel(x, y) + texel(x + 1, y) + texel(x, y + 1) + texel(x + 1, y + 1);
                rgb.push((sum * 0.25).to_array());
            }
        }
        Self { width, height, rgb }
    }
}
