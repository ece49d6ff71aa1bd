//! Dense volumes, to be compared with the records: what the papers keep, a texel a voxel.
//!
//! Source: [`papers::CHANG_LAI_2011`](crate::papers::CHANG_LAI_2011), §2.1 and §5; DO Table 2. Used by the benchmark and
//! by a claim; no frame goes this way.
//!
//! | paper                         | here                  | meaning                                              |
//! |-------------------------------|-----------------------|------------------------------------------------------|
//! | a 3D texture of four channels | [`DenseVolume`]       | normal and part of every voxel, empty ones too       |
//! | 32-bit float, 16, 8 bits      | [`Storage`]           | what a channel is kept in                            |
//!
//! Differs: the texture is filled from the records, so that all storages hold the same normals and differ by their
//! rounding alone. Both are walked by the same marcher, `lib/voxel_path.inc.wgsl`.

use crate::animate::{Triangles, Vertex};
use crate::gpu::{ComputePass, Gpu, GpuError, GpuStruct, Recorder, buffer};
use crate::grid::Grid;
use crate::march::MarchSettings;
use crate::resolve::{resources, triangle_resources};
use crate::scene::material::PartMaterial;
use crate::surroundings::{LightData, PlaneData, Surroundings, SurroundingsBuffers};
use crate::volume::{Record, Volume};
use glam::{UVec2, UVec3};

/// How a volume's normals are kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Storage {
    /// Ours: a record for each occupied voxel.
    Records,
    /// A texel a voxel, 32-bit floats.
    Float32,
    /// A texel a voxel, 16-bit floats.
    Float16,
    /// A texel a voxel, 8-bit signed fractions.
    Snorm8,
}

impl Storage {
    /// All, ours first.
    pub const ALL: [Self; 4] = [Self::Records, Self::Float32, Self::Float16, Self::Snorm8];

    /// Its name in a table.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Records => "records",
            Self::Float32 => "dense, 32-bit float RGBA",
            Self::Float16 => "dense, 16-bit float RGBA",
            Self::Snorm8 => "dense, 8-bit RGBA",
        }
    }

    /// The texture's format, and bytes of a texel.
    const fn texel(self) -> Option<(wgpu::TextureFormat, u64)> {
        match self {
            Self::Records => None,
            Self::Float32 => Some((wgpu::TextureFormat::Rgba32Float, 16)),
            Self::Float16 => Some((wgpu::TextureFormat::Rgba16Float, 8)),
            Self::Snorm8 => Some((wgpu::TextureFormat::Rgba8Snorm, 4)),
        }
    }
}

/// A texture of a grid's cells.
#[derive(Debug)]
pub struct DenseVolume {
    texture: wgpu::Texture,
    storage: Storage,
    /// Its size.
    pub bytes: u64,
}

impl DenseVolume {
    /// An empty one; for [`Storage::Records`] a single texel, to have something to bind.
    ///
    /// # Errors
    /// When the device allows no texture of so many cells.
    pub fn new(gpu: &Gpu, storage: Storage, cells: UVec3) -> Result<Self, GpuError> {
        let allowed = gpu.device.limits().max_texture_dimension_3d;
        let longest = cells.max_element();
        if longest > allowed {
            return Err(GpuError::TooMany {
                what: "cells along an axis of a dense volume".to_owned(),
                needed: longest.into(),
                allowed: allowed.into(),
                remedy: "choose a smaller grid",
            });
        }
        let (cells, (format, texel_bytes)) = match storage.texel() {
            Some(texel) => (cells, texel),
            None => (UVec3::ONE, (wgpu::TextureFormat::Rgba8Snorm, 4)),
        };
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("dense"),
            size: wgpu::Extent3d { width: cells.x, height: cells.y, depth_or_array_layers: cells.z },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D3,
            format,
            usage: wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        let bytes = cells.to_array().map(u64::from).iter().product::<u64>() * texel_bytes;
        Ok(Self { texture, storage, bytes })
    }

    fn view(&self) -> wgpu::TextureView {
        self.texture.create_view(&wgpu::TextureViewDescriptor::default())
    }
}

/// What a march over either storage is given.
#[derive(Debug, Clone, Copy)]
pub struct Input<'a> {
    /// Grid 0 is walked.
    pub volume: &'a Volume,
    /// For their materials.
    pub triangles: &'a Triangles,
    /// The eye.
    pub surroundings: &'a SurroundingsBuffers,
    /// Pixels.
    pub size: UVec2,
    /// CL's angle threshold.
    pub cos_angle_threshold: f32,
    /// CL's bound on refractions.
    pub max_events: u32,
}

/// The passes.
#[derive(Debug)]
pub struct Dense {
    fills: [ComputePass; 3],
    /// Over the records, then over a texture.
    marches: [ComputePass; 2],
}

impl Dense {
    /// Compiles the passes.
    ///
    /// # Errors
    /// When the shader is wrong.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let layouts = [
            Grid::LAYOUT,
            Record::LAYOUT,
            Vertex::LAYOUT,
            PartMaterial::LAYOUT,
            Surroundings::LAYOUT,
            LightData::LAYOUT,
            PlaneData::LAYOUT,
            MarchSettings::LAYOUT,
        ];
        let fill = |entry| ComputePass::new(gpu, "dense.wgsl", entry, &layouts);
        let march = |from_texture: f64| {
            let constants = [("from_texture", from_texture), ("bends", 2.0), ("perspective_rays", 0.0)];
            ComputePass::with_constants(gpu, "dense.wgsl", "march", &layouts, &constants)
        };
        Ok(Self {
            fills: [fill("fill_float32")?, fill("fill_float16")?, fill("fill_snorm8")?],
            marches: [march(0.0)?, march(1.0)?],
        })
    }

    /// Writes the records of grid 0 into the texture, and nothing into its other cells. Nothing to do for the records themselves.
    pub fn record_fill(&self, rec: &mut Recorder<'_>, volume: &Volume, dense: &DenseVolume) {
        let (pass, name) = match dense.storage {
            Storage::Records => return,
            Storage::Float32 => (&self.fills[0], "float32"),
            Storage::Float16 => (&self.fills[1], "float16"),
            Storage::Snorm8 => (&self.fills[2], "snorm8"),
        };
        let Some(grid) = volume.grids.first() else { return };
        let view = dense.view();
        let mut all = resources(volume, 0);
        all.push((name, wgpu::BindingResource::TextureView(&view)));
        pass.dispatch(&mut rec.encoder, &pass.bind_used(rec.gpu, &all), [grid.word_count(), 1, 1]);
    }

    /// Follows a ray a pixel through an orthographic grid; leaves its way out in `exits`, `rgba32float`, w = 1 where there
    /// is one.
    pub fn record_march(
        &self,
        rec: &mut Recorder<'_>,
        input: &Input<'_>,
        dense: &DenseVolume,
        exits: &wgpu::TextureView,
    ) {
        let settings = MarchSettings {
            size: input.size,
            rows: UVec2::new(0, input.size.y),
            max_events: input.max_events,
            cos_angle_threshold: input.cos_angle_threshold,
            ..bytemuck::Zeroable::zeroed()
        };
        let settings = buffer::uniform(rec.gpu, "march_settings", &settings);
        let view = dense.view();
        let mut all = resources(input.volume, 0);
        all.extend(triangle_resources(input.triangles));
        all.push(("surroundings", input.surroundings.data.as_entire_binding()));
        all.push(("settings", settings.as_entire_binding()));
        all.push(("dense", wgpu::BindingResource::TextureView(&view)));
        all.push(("exits", wgpu::BindingResource::TextureView(exits)));
        let pass = &self.marches[usize::from(dense.storage != Storage::Records)];
        let group = pass.bind_used(rec.gpu, &all);
        pass.dispatch(&mut rec.encoder, &group, [input.size.x, input.size.y, 1]);
    }
}
