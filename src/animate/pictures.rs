//! The pictures of all parts in one array of sRGB layers, each with smaller and smaller copies of itself: what is seen
//! small is averaged in linear light.

use super::{too_many, u32_of};
use crate::gpu::{Gpu, GpuError};
use crate::scene::geometry::Texture;
use image::Rgba32FImage;
use image::imageops::{FilterType, resize};

/// Largest side of a layer, texels.
const MAX_SIDE: u32 = 1024;
/// Most bytes of all layers, their copies apart.
const MAX_BYTES: u64 = 128 << 20;

/// All pictures as layers of one size: as large as the largest, within [`MAX_SIDE`] and [`MAX_BYTES`].
pub(super) fn array(gpu: &Gpu, pictures: &[&Texture]) -> Result<wgpu::TextureView, GpuError> {
    let allowed = gpu.device.limits().max_texture_array_layers;
    let layers = u32_of(pictures.len());
    if layers > allowed {
        return Err(too_many("pictures", pictures.len(), allowed as usize));
    }
    let largest = pictures.iter().map(|p| p.width.max(p.height)).max().unwrap_or(1);
    let mut side = largest.clamp(1, MAX_SIDE);
    while u64::from(layers) * u64::from(side) * u64::from(side) * 4 > MAX_BYTES {
        side /= 2;
    }
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("textures"),
        size: wgpu::Extent3d { width: side, height: side, depth_or_array_layers: layers.max(1) },
        mip_level_count: side.ilog2() + 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8UnormSrgb,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    for (layer, picture) in (0..layers).zip(pictures) {
        let mut smaller = sized(picture, side);
        for level in 0..texture.mip_level_count() {
            let side = side >> level;
            if level > 0 {
                smaller = halved(&smaller);
            }
            let mut place = texture.as_image_copy();
            (place.origin.z, place.mip_level) = (layer, level);
            gpu.queue.write_texture(
                place,
                &coded(&smaller),
                wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * side), rows_per_image: None },
                wgpu::Extent3d { width: side, height: side, depth_or_array_layers: 1 },
            );
        }
    }
    Ok(texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2Array),
        ..Default::default()
    }))
}

/// The picture at `side` × `side` texels, linear.
fn sized(picture: &Texture, side: u32) -> Rgba32FImage {
    let linear_of: Vec<f32> = (0..=u8::MAX)
        .map(|code| {
            let value = f32::from(code) / 255.0;
            if picture.srgb { linear_from_srgb(value) } else { value }
        })
        .collect();
    let texels = picture.rgba8.chunks_exact(4).flat_map(|t| {
        let [r, g, b] = [t[0], t[1], t[2]].map(|code| linear_of[code as usize]);
        [r, g, b, f32::from(t[3]) / 255.0]
    });
    let whole = Rgba32FImage::from_raw(picture.width, picture.height, texels.collect());
    let whole = whole.unwrap_or_else(|| Rgba32FImage::from_pixel(side, side, image::Rgba([1.0; 4])));
    if whole.dimensions() == (side, side) {
        return whole;
    }
    let filter = if picture.sampling.nearest { FilterType::Nearest } else { FilterType::Triangle };
    resize(&whole, side, side, filter)
}

/// A square picture of half the side, each texel the mean of four.
fn halved(picture: &Rgba32FImage) -> Rgba32FImage {
    let side = (picture.width() / 2).max(1);
    Rgba32FImage::from_fn(side, side, |x, y| {
        let four = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(dx, dy)| picture.get_pixel(2 * x + dx, 2 * y + dy).0);
        image::Rgba([0, 1, 2, 3].map(|c| four.iter().map(|texel| texel[c]).sum::<f32>() / 4.0))
    })
}

/// A linear picture, sRGB-coded.
fn coded(linear: &Rgba32FImage) -> Vec<u8> {
    linear
        .pixels()
        .flat_map(|p| [0, 1, 2, 3].map(|c| if c < 3 { srgb8_from_linear(p.0[c]) } else { byte(p.0[c]) }))
        .collect()
}

/// A component of a linear colour as pictures store it.
pub(crate) fn srgb8_from_linear(value: f32) -> u8 {
    byte(srgb_from_linear(value))
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to 0 … 255")]
fn byte(value: f32) -> u8 {
    (value.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}

fn linear_from_srgb(value: f32) -> f32 {
    if value <= 0.040_45 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

fn srgb_from_linear(value: f32) -> f32 {
    if value <= 0.003_130_8 { value * 12.92 } else { 1.055 * value.powf(1.0 / 2.4) - 0.055 }
}
