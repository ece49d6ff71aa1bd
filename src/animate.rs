//! Stage 1: moves every vertex in compute: morphs, then joints, then deformers, into world space.

use crate::gpu::{Gpu, GpuError, Recorder, buffer};
use crate::scene::material::Material;
use crate::scene::{Pose, Scene, World};
use glam::Vec3;

crate::gpu_struct! {
    /// An animated vertex.
    pub struct Vertex {
        /// World.
        pub position: Vec3,
        /// Index of its part in [`World::parts`].
        pub part: u32,
        /// World, unit.
        pub normal: Vec3,
        /// Padding.
        pub _pad: u32,
    }
}

/// The world's triangles on the device: what `animate` writes and every later stage reads.
#[derive(Debug)]
pub struct Triangles {
    /// `array<Vertex>`.
    pub vertices: wgpu::Buffer,
    /// `array<u32>`, three a triangle.
    pub indices: wgpu::Buffer,
    /// `array<RestVertex>`, parallel to `vertices`.
    pub rest_vertices: wgpu::Buffer,
    /// `array<PartMaterial>`.
    pub materials: wgpu::Buffer,
    /// Pictures of opaque parts, `texture_2d_array`, one layer each.
    pub textures: wgpu::TextureView,
    /// Number of vertices.
    pub vertex_count: u32,
    /// Number of triangles.
    pub triangle_count: u32,
}

/// The pass.
#[derive(Debug)]
pub struct Animate {}

impl Animate {
    /// Compiles the pass.
    ///
    /// # Errors
    /// When a shader is wrong.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let _ = gpu;
        Ok(Self {})
    }

    /// Uploads what does not change while a scene is shown. Analytic planes have no triangles here.
    ///
    /// # Errors
    /// When the model is larger than the device's bindings.
    pub fn upload(&mut self, gpu: &Gpu, world: &World) -> Result<Triangles, GpuError> {
        let _ = world;
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("textures"),
            size: wgpu::Extent3d { width: 1, height: 1, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba8UnormSrgb,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        Ok(Triangles {
            vertices: buffer::storage(gpu, "vertices", 0)?,
            indices: buffer::storage(gpu, "indices", 0)?,
            rest_vertices: buffer::storage(gpu, "rest_vertices", 0)?,
            materials: buffer::storage(gpu, "materials", 0)?,
            textures: texture.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(wgpu::TextureViewDimension::D2Array),
                ..Default::default()
            }),
            vertex_count: 0,
            triangle_count: 0,
        })
    }

    /// Records the stage: matrices and weights up, vertices out.
    pub fn record(&self, rec: &mut Recorder<'_>, triangles: &Triangles, world: &World, scene: &Scene, pose: &Pose) {
        let _ = (rec, triangles, world, scene, pose);
    }

    /// Writes each part's material; called when one changed.
    pub fn write_materials(&self, gpu: &Gpu, triangles: &Triangles, materials: &[Material]) {
        let _ = (gpu, triangles, materials);
    }
}
