//! Pictures of a document: decoded once for each way they are used.

use super::Report;
use super::accessor::Accessors;
use super::container::Container;
use super::document::{Document, TextureInfo, TextureSampler};
use crate::scene::geometry::{Sampling, Texture, Wrap};
use glam::Vec3;
use std::collections::BTreeMap;

/// The most texels along a side that a picture keeps.
const MAX_SIDE: u32 = 1024;
/// The most texels along a side that are decoded at all.
const MAX_DECODED_SIDE: u32 = 8192;
/// The most pictures.
const MAX_PICTURES: usize = 256;
/// The most texels that are decoded in all.
const MAX_DECODED_TEXELS: u64 = 1 << 29;

/// Decodes pictures when a material first needs them.
pub(super) struct Pictures<'r, 'a> {
    document: &'a Document,
    accessors: &'r Accessors<'a>,
    container: &'r Container<'a>,
    /// By image, alpha cut-off and sampling: the place in `textures`, or `None` where it can't be decoded.
    decoded: BTreeMap<(usize, Option<u8>, u32), Option<u32>>,
    /// By image: its mean.
    means: BTreeMap<usize, Option<Vec3>>,
    texels_left: u64,
    /// What was decoded.
    pub(super) textures: Vec<Texture>,
}

impl<'r, 'a> Pictures<'r, 'a> {
    pub(super) fn new(document: &'a Document, accessors: &'r Accessors<'a>, container: &'r Container<'a>) -> Self {
        let (decoded, means, textures) = (BTreeMap::new(), BTreeMap::new(), Vec::new());
        Self { document, accessors, container, decoded, means, texels_left: MAX_DECODED_TEXELS, textures }
    }

    /// The place in `textures` of a picture; `None`, with a word, where there is none to be shown. Texels whose alpha is
    /// below `cutoff` are holes.
    pub(super) fn texture(&mut self, info: &TextureInfo, cutoff: Option<u8>, report: &mut Report) -> Option<u32> {
        let image = self.image_of(info, report)?;
        let sampling = self.sampling_of(info);
        let key = (image, cutoff, sampling.bits());
        if let Some(&known) = self.decoded.get(&key) {
            return known;
        }
        let place = self.decoded_or_word(image, report).and_then(|picture| {
            let place = u32::try_from(self.textures.len()).ok()?;
            self.textures.push(kept(picture, cutoff, sampling));
            Some(place)
        });
        self.decoded.insert(key, place);
        place
    }

    /// The mean colour of a picture, linear; `None`, with a word, where there is none to be read.
    pub(super) fn mean(&mut self, info: &TextureInfo, report: &mut Report) -> Option<Vec3> {
        let image = self.image_of(info, report)?;
        if let Some(&known) = self.means.get(&image) {
            return known;
        }
        let mean = self.decoded_or_word(image, report).map(|picture| mean_of(&picture));
        self.means.insert(image, mean);
        mean
    }

    fn image_of(&self, info: &TextureInfo, report: &mut Report) -> Option<usize> {
        let image = self.document.textures.get(info.index).and_then(|t| t.source);
        if image.is_none() {
            report.warn(format!("texture {} has no picture that can be read; the part is plain", info.index));
        }
        image
    }

    /// How a texture is laid on: glTF's default repeats and blends. The filter for what is seen large decides, and the one
    /// for what is seen small, which is always averaged, only where that is left open.
    fn sampling_of(&self, info: &TextureInfo) -> Sampling {
        let sampler = self.document.textures.get(info.index).and_then(|t| self.document.samplers.get(t.sampler?));
        let Some(TextureSampler { mag_filter, min_filter, wrap_s, wrap_t }) = sampler else {
            return Sampling::default();
        };
        let wrap = |code: &Option<u32>| match code {
            Some(33071) => Wrap::Clamp,
            Some(33648) => Wrap::Mirror,
            _ => Wrap::Repeat,
        };
        let nearest = mag_filter.or(*min_filter).is_some_and(|code| matches!(code, 9728 | 9984 | 9986));
        Sampling { wrap: [wrap(wrap_s), wrap(wrap_t)], nearest }
    }

    fn decoded_or_word(&mut self, image: usize, report: &mut Report) -> Option<image::RgbaImage> {
        self.decode(image).map_err(|e| report.lose_picture(format!("image {image}: {e}; the part is plain"))).ok()
    }

    fn decode(&mut self, index: usize) -> Result<image::RgbaImage, String> {
        let image = self.document.images.get(index).ok_or("it does not exist")?;
        if self.textures.len() >= MAX_PICTURES {
            return Err(format!("more than {MAX_PICTURES} pictures"));
        }
        let owned;
        let bytes = match (&image.uri, image.buffer_view) {
            (_, Some(view)) => self.accessors.view_bytes(view)?,
            (Some(uri), None) => {
                owned = self.container.uri(uri)?;
                &owned
            }
            (None, None) => return Err("it has no bytes".to_owned()),
        };
        let mut reader = image::ImageReader::new(std::io::Cursor::new(bytes));
        let format = image::guess_format(bytes).map_err(|e| format!("can't be decoded: {e}"))?;
        if !matches!(format, image::ImageFormat::Png | image::ImageFormat::Jpeg) {
            return Err("only PNG and JPEG can be decoded".to_owned());
        }
        reader.set_format(format);
        let (width, height) = reader.into_dimensions().map_err(|e| format!("can't be decoded: {e}"))?;
        let texels = u64::from(width) * u64::from(height);
        if width > MAX_DECODED_SIDE || height > MAX_DECODED_SIDE || texels > self.texels_left || texels == 0 {
            return Err(format!("{width}×{height} texels are too many"));
        }
        self.texels_left -= texels;
        let decoded = image::load_from_memory_with_format(bytes, format);
        Ok(decoded.map_err(|e| format!("can't be decoded: {e}"))?.into_rgba8())
    }
}

/// A picture as it is kept: no larger than [`MAX_SIDE`], its alpha nothing or whole.
fn kept(mut picture: image::RgbaImage, cutoff: Option<u8>, sampling: Sampling) -> Texture {
    // Only a mask has holes: the alpha of all else means nothing on an opaque part.
    let cutoff = cutoff.unwrap_or(0);
    picture.pixels_mut().for_each(|p| p.0[3] = if p.0[3] < cutoff { 0 } else { 255 });
    let (width, height) = picture.dimensions();
    if width.max(height) > MAX_SIDE {
        let fit = |side: u32| (side * MAX_SIDE / width.max(height)).max(1);
        let filter = image::imageops::FilterType::Triangle;
        picture = image::imageops::resize(&picture, fit(width), fit(height), filter);
    }
    let (width, height) = picture.dimensions();
    Texture { width, height, rgba8: picture.into_raw(), srgb: true, sampling }
}

fn mean_of(picture: &image::RgbaImage) -> Vec3 {
    let linear = |code: u8| {
        let x = f64::from(code) / 255.0;
        if x <= 0.040_45 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
    };
    let linear_of: Vec<f64> = (0..=u8::MAX).map(linear).collect();
    let mut sum = glam::DVec3::ZERO;
    for texel in picture.pixels() {
        let [r, g, b] = [texel.0[0], texel.0[1], texel.0[2]].map(|code| linear_of[code as usize]);
        sum += glam::DVec3::new(r, g, b);
    }
    (sum / f64::from(picture.width() * picture.height()).max(1.0)).as_vec3()
}
