//! Stage 7: tone map, debug views, the picture.

use crate::gpu::{Gpu, GpuError, Recorder};
use crate::march::{Channel, Radiance};
use crate::scene::description::EffectSettings;
use crate::surroundings::SurroundingsBuffers;
use crate::volume::Volume;
use glam::UVec2;

/// What is shown instead of the picture.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum DebugView {
    /// The picture.
    #[default]
    None,
    /// The view grid's voxels as cubes, coloured by their record's normal.
    Cubes,
    /// One slice of the view's grid: occupancy and interior.
    Slice {
        /// 0 = x, 1 = y, 2 = z of the grid.
        axis: u32,
        /// 0 to 1 along it.
        position: f32,
    },
    /// The chosen float channel in false colours (0 … `max`); directions as colours.
    Channel {
        /// The value shown brightest.
        max: f32,
    },
    /// One slice of light 0's grid: the light that is left.
    LightVolume {
        /// 0 to 1 along the light.
        position: f32,
    },
}

/// The passes.
#[derive(Debug)]
pub struct Compose {}

/// What is composed.
#[derive(Debug, Clone, Copy)]
pub struct Input<'a> {
    /// From the march.
    pub radiance: &'a Radiance,
    /// What the channel beside the radiance holds.
    pub channel: Channel,
    /// For the debug views.
    pub volume: &'a Volume,
    /// For the debug views' camera.
    pub surroundings: &'a SurroundingsBuffers,
    /// Exposure.
    pub effect: &'a EffectSettings,
    /// What to show.
    pub view: DebugView,
}

impl Compose {
    /// Compiles the passes.
    ///
    /// # Errors
    /// When a shader is wrong.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let _ = gpu;
        Ok(Self {})
    }

    /// Makes a picture, `rgba8unorm` holding sRGB-encoded values.
    #[must_use]
    pub fn target(&self, gpu: &Gpu, size: UVec2) -> wgpu::Texture {
        gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("picture"),
            size: wgpu::Extent3d { width: size.x.max(1), height: size.y.max(1), depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba8Unorm,
            usage: wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::STORAGE_BINDING
                | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        })
    }

    /// Records the stage. `target` may be larger than the radiance, which is then scaled up smoothly.
    pub fn record(&self, rec: &mut Recorder<'_>, input: &Input<'_>, target: &wgpu::Texture) {
        let _ = (rec, input, target);
    }
}
