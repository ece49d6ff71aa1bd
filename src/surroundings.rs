//! What rays meet outside the volume: camera, lights, planes, background. One uniform and one texture.
//!
//! Shader side: `shaders/lib/surroundings.inc.wgsl`.

use crate::gpu::{Gpu, GpuError};
use crate::scene::{Scene, World};
use glam::{Mat4, UVec4, Vec3, Vec4};

/// The most lights.
pub const MAX_LIGHTS: usize = 8;
/// The most analytic planes.
pub const MAX_PLANES: usize = 8;

crate::gpu_struct! {
    /// A light as shaders see it.
    pub struct LightData {
        /// Position; directional: unused.
        pub position: Vec3,
        /// 0 directional, 1 point, 2 spot.
        pub kind: u32,
        /// The way it travels or points, unit.
        pub direction: Vec3,
        /// Spot: cosine of the half angle.
        pub cos_outer: f32,
        /// Colour times intensity.
        pub radiance: Vec3,
        /// Spot: cosine where it starts to fade.
        pub cos_inner: f32,
        /// First of its grids, or `u32::MAX` for none.
        pub first_grid: u32,
        /// How many grids it has (0, 1 or 6).
        pub grid_count: u32,
        /// Padding.
        pub _pad: [u32; 2],
    }
}

crate::gpu_struct! {
    /// An analytic square at local y = 0, met exactly.
    pub struct PlaneData {
        /// `local_from_world`, local unit = half side.
        pub local_from_world: Mat4,
        /// World normal, unit.
        pub normal: Vec3,
        /// Index of its part.
        pub part: u32,
        /// Second colour of the checkerboard.
        pub checker_color: Vec3,
        /// Squares along half a side; 0 is plain.
        pub checker_squares: f32,
    }
}

crate::gpu_struct! {
    /// Everything around the volume, `Surroundings` in `lib/surroundings.inc.wgsl`.
    pub struct Surroundings {
        /// Camera position.
        pub eye: Vec3,
        /// tan(fov/2).
        pub tan_half_fov: f32,
        /// Camera axes, unit.
        pub right: Vec3,
        /// Width over height.
        pub aspect: f32,
        /// Camera axes, unit.
        pub up: Vec3,
        /// 0 colour, 1 sky, 2 checker, 3 environment.
        pub background_kind: u32,
        /// Camera axes, unit: the way it looks.
        pub forward: Vec3,
        /// Sky: power of the height. Checker: side of a square.
        pub background_parameter: f32,
        /// Colour; sky: horizon; checker: one colour. w: unused.
        pub background_a: Vec4,
        /// Sky: zenith; checker: the other colour.
        pub background_b: Vec4,
        /// Sky: below the horizon. Checker: a point of its plane. Environment: x = turn in radians, y = intensity.
        pub background_c: Vec4,
        /// Checker: the plane's normal, towards the camera.
        pub background_d: Vec4,
        /// x: lights, y: planes, z: index of the scene grid or MAX, w: unused.
        pub counts: UVec4,
        /// Lights.
        pub lights: [LightData; MAX_LIGHTS],
        /// Planes.
        pub planes: [PlaneData; MAX_PLANES],
    }
}

/// Surroundings on the device.
#[derive(Debug)]
pub struct SurroundingsBuffers {
    /// One [`Surroundings`], uniform.
    pub data: wgpu::Buffer,
    /// The environment, equirectangular, `texture_2d<f32>`, filterable; one black texel without one.
    pub environment: wgpu::TextureView,
    /// Linear, wraps around.
    pub sampler: wgpu::Sampler,
}

impl SurroundingsBuffers {
    /// Uploads the environment.
    ///
    /// # Errors
    /// When it is too large for the device.
    pub fn new(gpu: &Gpu, world: &World) -> Result<Self, GpuError> {
        let _ = world;
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("environment"),
            size: wgpu::Extent3d { width: 1, height: 1, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba16Float,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        Ok(Self {
            data: gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("surroundings"),
                size: size_of::<Surroundings>() as u64,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }),
            environment: texture.create_view(&wgpu::TextureViewDescriptor::default()),
            sampler: gpu.device.create_sampler(&wgpu::SamplerDescriptor::default()),
        })
    }
}

impl SurroundingsBuffers {
    /// Writes the uniform; called when it changed.
    pub fn write(&self, gpu: &Gpu, surroundings: &Surroundings) {
        gpu.queue.write_buffer(&self.data, 0, bytemuck::bytes_of(surroundings));
    }
}

/// Works out the uniform. `light_grids[i]` are the grid numbers of light `i`; `scene_grid` that of the opaque parts.
#[must_use]
pub fn surroundings(
    scene: &Scene,
    world: &World,
    aspect: f32,
    light_grids: &[std::ops::Range<u32>],
    scene_grid: Option<u32>,
) -> Surroundings {
    let _ = (scene, world, aspect, light_grids, scene_grid);
    bytemuck::Zeroable::zeroed()
}
