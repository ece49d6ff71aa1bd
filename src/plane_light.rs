//! Stage 5, second half: what is left of each light on each analytic plane, with soft shadows.
//!
//! Planes are what most rays end on, and a picture of the light on one can be spread. For each grid of a light and each
//! plane there is a layer with a texel where each column meets the plane. Its darkness is the light volume's, exactly;
//! then it is spread by a bell as wide as the light's disc is, seen through the last surface that the column met:
//! crisp at a body's foot, soft far from it. Every bell sums to one: spreading makes no light and loses none.
//!
//! Differs from a true penumbra: a column's shadow is spread as a whole, by its last surface alone.
//! Costs: three small passes a layer; eight bytes a texel.

use crate::animate::Triangles;
use crate::gpu::{ComputePass, Gpu, GpuError, GpuStruct, Recorder, buffer};
use crate::grid::Grid;
use crate::scene::material::PartMaterial;
use crate::surroundings::{LightData, MAX_PLANE_LAYERS, PlaneData, Surroundings, SurroundingsBuffers};
use crate::volume::{Record, Volume};
use glam::UVec2;

crate::gpu_struct! {
    /// Which layer is made.
    pub struct PlaneLightTask {
        /// Number of the light.
        pub light: u32,
        /// Number of the grid.
        pub grid: u32,
        /// Number of the plane.
        pub plane: u32,
        /// Padding.
        pub _pad: u32,
    }
}

/// The passes, and the layers that they write.
#[derive(Debug)]
pub struct PlaneLight {
    project: ComputePass,
    spread_x: ComputePass,
    spread_y: ComputePass,
    layers: Layers,
}

/// `texture_2d_array<f32>`: what is left, RGB. Texel (x, y) is column (x, y) of the layer's grid.
#[derive(Debug)]
struct Layers {
    texture: wgpu::Texture,
    view: wgpu::TextureView,
    projected: wgpu::Buffer,
    spread: wgpu::Buffer,
}

/// A layer to be made.
struct Task {
    data: PlaneLightTask,
    layer: u32,
    cells: UVec2,
}

impl PlaneLight {
    /// Compiles the passes.
    ///
    /// # Errors
    /// When a shader is wrong.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let layouts = [
            Grid::LAYOUT,
            Record::LAYOUT,
            PartMaterial::LAYOUT,
            Surroundings::LAYOUT,
            LightData::LAYOUT,
            PlaneData::LAYOUT,
            PlaneLightTask::LAYOUT,
        ];
        let pass = |entry| ComputePass::new(gpu, "plane_light.wgsl", entry, &layouts);
        Ok(Self {
            project: pass("project")?,
            spread_x: pass("spread_x")?,
            spread_y: pass("spread_y")?,
            layers: Layers::new(gpu, UVec2::ONE, 1)?,
        })
    }

    /// All layers, `plane_light` in `lib/shading.inc.wgsl`.
    #[must_use]
    pub fn view(&self) -> &wgpu::TextureView {
        &self.layers.view
    }

    /// Records all layers, once every light's grid is walked.
    ///
    /// # Errors
    /// When the layers are too large for the device.
    pub fn record(
        &mut self,
        rec: &mut Recorder<'_>,
        volume: &Volume,
        triangles: &Triangles,
        surroundings: (&Surroundings, &SurroundingsBuffers),
    ) -> Result<(), GpuError> {
        let (data, buffers) = surroundings;
        let tasks = tasks(volume, data);
        let Some(layer_count) = tasks.iter().map(|t| t.layer + 1).max() else { return Ok(()) };
        let size = tasks.iter().fold(UVec2::ONE, |size, task| size.max(task.cells));
        self.layers.make_room(rec.gpu, size, layer_count)?;
        for task in &tasks {
            let uniform = buffer::uniform(rec.gpu, "plane_light_task", &task.data);
            let layer = self.layers.texture.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(wgpu::TextureViewDimension::D2),
                base_array_layer: task.layer,
                array_layer_count: Some(1),
                ..Default::default()
            });
            let resources = [
                ("grids", volume.grid_data.as_entire_binding()),
                ("surroundings", buffers.data.as_entire_binding()),
                ("plane_light_task", uniform.as_entire_binding()),
                ("occupancy", volume.occupancy.as_entire_binding()),
                ("ranks", volume.ranks.as_entire_binding()),
                ("records", volume.records.as_entire_binding()),
                ("light_records", volume.light_records.as_entire_binding()),
                ("materials", triangles.materials.as_entire_binding()),
                ("projected", self.layers.projected.as_entire_binding()),
                ("spread", self.layers.spread.as_entire_binding()),
                ("plane_light_layer", wgpu::BindingResource::TextureView(&layer)),
            ];
            for pass in [&self.project, &self.spread_x, &self.spread_y] {
                let group = pass.bind(rec.gpu, &resources);
                pass.dispatch(&mut rec.encoder, &group, [task.cells.x, task.cells.y, 1]);
            }
        }
        Ok(())
    }
}

/// The layers that shading will look for: those of lights with [`LightData::first_layer`].
fn tasks(volume: &Volume, data: &Surroundings) -> Vec<Task> {
    let [lights, planes, ..] = data.counts.to_array();
    let mut tasks = Vec::new();
    for light in 0..lights {
        let LightData { first_grid, grid_count, first_layer, .. } = data.lights[light as usize];
        for number in (0..grid_count).filter(|_| first_layer != u32::MAX) {
            for plane in 0..planes {
                let grid = first_grid + number;
                if let Some(g) = volume.grids.get(grid as usize) {
                    let data = PlaneLightTask { light, grid, plane, _pad: 0 };
                    tasks.push(Task { data, layer: first_layer + number * planes + plane, cells: g.cells.truncate() });
                }
            }
        }
    }
    debug_assert!(tasks.iter().all(|t| t.layer < MAX_PLANE_LAYERS), "layers are given out within their number");
    tasks
}

impl Layers {
    fn new(gpu: &Gpu, size: UVec2, count: u32) -> Result<Self, GpuError> {
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("plane_light"),
            size: wgpu::Extent3d { width: size.x, height: size.y, depth_or_array_layers: count },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba16Float,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::STORAGE_BINDING,
            view_formats: &[],
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..Default::default()
        });
        let bytes = u64::from(size.x) * u64::from(size.y) * 8;
        let projected = buffer::storage(gpu, "plane_light projected", bytes)?;
        Ok(Self { texture, view, projected, spread: buffer::storage(gpu, "plane_light spread", bytes)? })
    }

    /// Grows; never shrinks, so that a body that turns does not make it anew each frame.
    fn make_room(&mut self, gpu: &Gpu, size: UVec2, count: u32) -> Result<(), GpuError> {
        let have = UVec2::new(self.texture.width(), self.texture.height());
        let layers = self.texture.depth_or_array_layers();
        if size.cmpgt(have).any() || count > layers {
            *self = Self::new(gpu, size.max(have), count.max(layers))?;
        }
        Ok(())
    }
}
