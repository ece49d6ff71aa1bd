//! Materials and their pictures.

use super::Report;
use super::accessor::Accessors;
use super::container::Container;
use super::document::{self, Document, TextureInfo};
use crate::scene::geometry::Texture;
use crate::scene::material::{Material, sigma_from_attenuation};
use glam::{Affine2, Vec2, Vec3};
use std::collections::BTreeMap;

/// The most texels along a side that a picture keeps.
const MAX_SIDE: u32 = 1024;
/// The most texels along a side that are decoded at all.
const MAX_DECODED_SIDE: u32 = 8192;
/// The most pictures.
const MAX_PICTURES: usize = 256;
/// The most texels that are decoded in all.
const MAX_DECODED_TEXELS: u64 = 1 << 29;

/// Makes materials, and decodes each picture once, when the first opaque material needs it.
pub(super) struct Materials<'r, 'a> {
    document: &'a Document,
    accessors: &'r Accessors<'a>,
    container: &'r Container<'a>,
    /// By image and alpha cut-off: the place in `textures`, or `None` where it can't be decoded.
    decoded: BTreeMap<(usize, Option<u8>), Option<u32>>,
    texels_left: u64,
    /// What was decoded.
    pub(super) textures: Vec<Texture>,
}

/// Which texture coordinates a material uses, and how they are turned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct UvUse {
    /// 0 or 1.
    pub(super) set: u32,
    /// KHR_texture_transform.
    pub(super) transform: Affine2,
}

impl<'r, 'a> Materials<'r, 'a> {
    pub(super) fn new(document: &'a Document, accessors: &'r Accessors<'a>, container: &'r Container<'a>) -> Self {
        let (decoded, textures) = (BTreeMap::new(), Vec::new());
        Self { document, accessors, container, decoded, texels_left: MAX_DECODED_TEXELS, textures }
    }

    /// A material of the document; `None` is glTF's default, white and opaque.
    pub(super) fn material(&mut self, index: Option<usize>, report: &mut Report) -> Result<Material, String> {
        let default = document::Material::default();
        let source = match index {
            Some(i) => self.source(i)?,
            None => &default,
        };
        let mut material = plain(source);
        if material.opaque {
            let cutoff =
                (source.alpha_mode.as_deref() == Some("MASK")).then(|| byte(source.alpha_cutoff.unwrap_or(0.5)));
            if let Some(info) = &source.pbr_metallic_roughness.base_color_texture {
                material.base_color_texture = self.texture(info, cutoff, report);
            }
            if let Some(info) = source.emissive_texture.as_ref().filter(|_| material.emissive != Vec3::ZERO) {
                material.emissive_texture = self.texture(info, None, report);
            }
        }
        Ok(material)
    }

    /// The texture coordinates that a material's pictures want: the base colour's, else the emissive's.
    pub(super) fn uv_use(&self, index: Option<usize>) -> Result<UvUse, String> {
        let Some(index) = index else { return Ok(UvUse { set: 0, transform: Affine2::IDENTITY }) };
        let source = self.source(index)?;
        let info = source.pbr_metallic_roughness.base_color_texture.as_ref().or(source.emissive_texture.as_ref());
        let Some(info) = info else { return Ok(UvUse { set: 0, transform: Affine2::IDENTITY }) };
        let Some(t) = &info.extensions.transform else {
            return Ok(UvUse { set: info.tex_coord, transform: Affine2::IDENTITY });
        };
        // KHR_texture_transform turns clockwise as uv is drawn, v downwards.
        let scale = Vec2::from_array(t.scale.unwrap_or([1.0; 2]));
        let transform = Affine2::from_scale_angle_translation(scale, -t.rotation, Vec2::from_array(t.offset));
        let transform = if transform.is_finite() { transform } else { Affine2::IDENTITY };
        Ok(UvUse { set: t.tex_coord.unwrap_or(info.tex_coord), transform })
    }

    fn source(&self, index: usize) -> Result<&'a document::Material, String> {
        let materials = &self.document.materials;
        materials.get(index).ok_or_else(|| {
            format!("material {index} does not exist, there are {}; export the file again", materials.len())
        })
    }

    fn texture(&mut self, info: &TextureInfo, cutoff: Option<u8>, report: &mut Report) -> Option<u32> {
        let source = self.document.textures.get(info.index).and_then(|t| t.source);
        let Some(image) = source else {
            report.warn(format!("texture {} has no picture that can be read; the part is plain", info.index));
            return None;
        };
        if let Some(&known) = self.decoded.get(&(image, cutoff)) {
            return known;
        }
        let texture =
            self.decode(image, cutoff).map_err(|e| report.warn(format!("image {image}: {e}; the part is plain")));
        let place = texture.ok().and_then(|texture| {
            let place = u32::try_from(self.textures.len()).ok()?;
            self.textures.push(texture);
            Some(place)
        });
        self.decoded.insert((image, cutoff), place);
        place
    }

    fn decode(&mut self, index: usize, cutoff: Option<u8>) -> Result<Texture, String> {
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
        let mut decoded = image::load_from_memory_with_format(bytes, format)
            .map_err(|e| format!("can't be decoded: {e}"))?
            .into_rgba8();
        // Only a mask has holes: the alpha of all else means nothing on an opaque part.
        let cutoff = cutoff.unwrap_or(0);
        decoded.pixels_mut().for_each(|p| p.0[3] = if p.0[3] < cutoff { 0 } else { 255 });
        if width.max(height) > MAX_SIDE {
            let fit = |side: u32| (side * MAX_SIDE / width.max(height)).max(1);
            decoded = image::imageops::resize(&decoded, fit(width), fit(height), image::imageops::FilterType::Triangle);
        }
        let (width, height) = decoded.dimensions();
        Ok(Texture { width, height, rgba8: decoded.into_raw(), srgb: true })
    }
}

/// All of a material but its pictures.
fn plain(source: &document::Material) -> Material {
    let pbr = &source.pbr_metallic_roughness;
    let extensions = &source.extensions;
    let [r, g, b, alpha] = pbr.base_color_factor.unwrap_or([1.0; 4]);
    let mut base_color = Vec3::new(r, g, b).map(unit);
    // Metals let no light in. A texture may make some of the surface metal: what matters then is the glass.
    let metal = unit(pbr.metallic_factor.unwrap_or(1.0)) > 0.5 && pbr.metallic_roughness_texture.is_none();
    let transmits = extensions.transmission.as_ref().is_some_and(|t| t.transmission_factor > 0.0) && !metal;
    let volume = extensions.volume.as_ref().filter(|v| v.thickness_factor > 0.0);
    // Alpha blending without a picture is how glass was written before transmission: a film that tints.
    let blended = source.alpha_mode.as_deref() == Some("BLEND") && alpha < 1.0 && pbr.base_color_texture.is_none();
    let film = blended && !transmits;
    if film {
        base_color = Vec3::ONE.lerp(base_color, unit(alpha));
    }
    let sigma = volume.filter(|_| transmits).map_or(Vec3::ZERO, |v| {
        let color = Vec3::from_array(v.attenuation_color.unwrap_or([1.0; 3])).map(unit);
        sigma_from_attenuation(color, v.attenuation_distance.unwrap_or(f32::INFINITY))
    });
    let strength = extensions.emissive_strength.as_ref().and_then(|e| e.emissive_strength).unwrap_or(1.0);
    let emissive = (Vec3::from_array(source.emissive_factor) * strength).map(|x| finite(x, 0.0).clamp(0.0, 65504.0));
    let ior = extensions.ior.as_ref().and_then(|i| i.ior).unwrap_or(1.5);
    Material {
        opaque: !(transmits || film),
        // 0 is a special mode for converted specular-glossiness files, meant as the default.
        ior: if ior == 0.0 { 1.5 } else { finite(ior, 1.5).clamp(1.0, 10.0) },
        sigma,
        base_color,
        roughness: unit(pbr.roughness_factor.unwrap_or(1.0)),
        dispersion: extensions.dispersion.as_ref().map_or(0.0, |d| finite(d.dispersion, 0.0).clamp(0.0, 100.0)),
        thin_wall: film || (transmits && volume.is_none()),
        emissive,
        ..Material::default()
    }
}

fn unit(x: f32) -> f32 {
    finite(x, 1.0).clamp(0.0, 1.0)
}

fn finite(x: f32, otherwise: f32) -> f32 {
    if x.is_finite() { x } else { otherwise }
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to 0 … 255")]
fn byte(x: f32) -> u8 {
    (unit(x) * 255.0).round() as u8
}
