//! Materials: what glTF says of a surface, as far as it is shown here (`docs/gltf.md`).

use super::Report;
use super::accessor::Accessors;
use super::container::Container;
use super::document::{self, Document, TextureInfo};
use super::pictures::Pictures;
use crate::scene::material::{Material, sigma_from_attenuation};
use glam::{Affine2, Vec2, Vec3};

/// Makes materials, with their pictures.
pub(super) struct Materials<'r, 'a> {
    document: &'a Document,
    /// What was decoded.
    pub(super) pictures: Pictures<'r, 'a>,
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
        Self { document, pictures: Pictures::new(document, accessors, container) }
    }

    /// A material of the document; `None` is glTF's default, white and opaque. It is laid on with the coordinates of
    /// `uv_use`.
    pub(super) fn material(
        &mut self,
        index: Option<usize>,
        uv_use: Option<&UvUse>,
        report: &mut Report,
    ) -> Result<Material, String> {
        let default = document::Material::default();
        let source = match index {
            Some(i) => self.source(i)?,
            None => &default,
        };
        let mut material = plain(source);
        warn_of_what_is_not_shown(source, &material, report);
        let color_info = source.pbr_metallic_roughness.base_color_texture.as_ref();
        if !material.opaque {
            // Light picks the tint up wherever it enters; one colour serves shadows, mirrors and bends alike.
            if let Some(mean) = color_info.and_then(|info| self.pictures.mean(info, report)) {
                material.base_color *= mean;
            }
            return Ok(material);
        }
        let mut laid_on = |info: &TextureInfo, cutoff: Option<u8>| {
            if Some(&uv_use_of(info)) != uv_use {
                report.warn(
                    "a part's pictures use different texture coordinates; those that differ from the base colour's are \
                     left out"
                        .to_owned(),
                );
                return None;
            }
            self.pictures.texture(info, cutoff, report)
        };
        let masked = source.alpha_mode.as_deref() == Some("MASK");
        let cutoff = masked.then(|| byte(source.alpha_cutoff.unwrap_or(0.5)));
        material.base_color_texture = color_info.and_then(|info| laid_on(info, cutoff));
        if let Some(info) = source.emissive_texture.as_ref().filter(|_| material.emissive != Vec3::ZERO) {
            material.emissive_texture = laid_on(info, None);
        }
        Ok(material)
    }

    /// The texture coordinates that a material's pictures want: the base colour's, else the emissive's; `None` where it
    /// has no pictures.
    pub(super) fn uv_use(&self, index: Option<usize>) -> Result<Option<UvUse>, String> {
        let Some(index) = index else { return Ok(None) };
        let source = self.source(index)?;
        let info = source.pbr_metallic_roughness.base_color_texture.as_ref().or(source.emissive_texture.as_ref());
        Ok(info.map(uv_use_of))
    }

    fn source(&self, index: usize) -> Result<&'a document::Material, String> {
        let materials = &self.document.materials;
        materials.get(index).ok_or_else(|| {
            format!("material {index} does not exist, there are {}; export the file again", materials.len())
        })
    }
}

fn uv_use_of(info: &TextureInfo) -> UvUse {
    let Some(t) = &info.extensions.transform else {
        return UvUse { set: info.tex_coord, transform: Affine2::IDENTITY };
    };
    // KHR_texture_transform turns clockwise as uv is drawn, v downwards.
    let scale = Vec2::from_array(t.scale.unwrap_or([1.0; 2]));
    let transform = Affine2::from_scale_angle_translation(scale, -t.rotation, Vec2::from_array(t.offset));
    let transform = if transform.is_finite() { transform } else { Affine2::IDENTITY };
    UvUse { set: t.tex_coord.unwrap_or(info.tex_coord), transform }
}

/// Says once for each kind what of a material the picture does not show.
fn warn_of_what_is_not_shown(source: &document::Material, material: &Material, report: &mut Report) {
    if source.alpha_mode.as_deref() == Some("BLEND") && material.opaque {
        report.warn("a part blends by its picture's alpha; it is shown opaque".to_owned());
    }
    let transmission = source.extensions.transmission.as_ref().filter(|_| !material.opaque);
    if transmission.is_some_and(|t| t.transmission_factor < 1.0 || t.transmission_texture.is_some()) {
        report.warn("a part transmits in part; it is shown wholly clear".to_owned());
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
    let unlit = extensions.unlit.is_some() && !(transmits || film);
    let ior = extensions.ior.as_ref().and_then(|i| i.ior).unwrap_or(1.5);
    Material {
        opaque: !(transmits || film),
        // 0 is a special mode for converted specular-glossiness files, meant as the default.
        ior: if ior == 0.0 { 1.5 } else { finite(ior, 1.5).clamp(1.0, 10.0) },
        sigma,
        base_color,
        roughness: if unlit { 0.0 } else { unit(pbr.roughness_factor.unwrap_or(1.0)) },
        dispersion: extensions.dispersion.as_ref().map_or(0.0, |d| finite(d.dispersion, 0.0).clamp(0.0, 100.0)),
        thin_wall: film || (transmits && volume.is_none()),
        double_sided: source.double_sided,
        emissive,
        unlit,
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
