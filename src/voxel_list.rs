//! The voxel list: each occupied voxel of one grid once, with what its surface is like there.
//!
//! Source: [`papers::RAUWENDAAL_BAILEY_2013`](crate::papers::RAUWENDAAL_BAILEY_2013), §3.5 and §3.6.
//!
//! | paper                        | here                       | meaning                                              |
//! |------------------------------|----------------------------|------------------------------------------------------|
//! | voxel-list                   | [`VoxelList`]              | the occupied voxels, compact                         |
//! | atomic counter               | a voxel's rank             | its place in the list                                |
//! | mutex at a voxel             | its occupancy bit          | lets one thread alone list it ([`LockedList`])       |
//! | λ_i(v'_i), dilated attributes | weights of the closest point | attributes of the undilated triangle               |
//!
//! Differs: the place of a voxel is its rank, a prefix sum over the words that the frame needs anyway. So a list can be
//! had of what any method marked, costs no atomic, and is sorted: the same bytes every time. A record knows its triangle's
//! point closest to the voxel's centre, and attributes are those of that point: no dilated triangle is interpolated, by
//! no method, so nothing is extrapolated. [`LockedList`] is the paper's way, kept to be compared; its mutexes are bits, of
//! which one `atomicOr` takes up to 32.
//! Promises: no voxel twice, none left out; by rank, sorted. Costs: 48 bytes a voxel; the paper's way an atomic a run.

use crate::animate::{Triangles, Vertex};
use crate::gpu::{ComputePass, Gpu, GpuError, GpuStruct, Recorder, buffer};
use crate::grid::Grid;
use crate::resolve::{resources, triangle_resources};
use crate::scene::geometry::RestVertex;
use crate::scene::material::PartMaterial;
use crate::volume::{Record, Volume};
use glam::{UVec3, Vec3};

crate::gpu_struct! {
    /// A voxel of the list.
    pub struct ListedVoxel {
        /// Of the surface: its triangle's point that is closest to the voxel's centre, world.
        pub position: Vec3,
        /// Three times ten bits; see [`ListedVoxel::cell`].
        pub cell: u32,
        /// Smooth, world, unit.
        pub normal: Vec3,
        /// Its triangle, or [`NO_TRIANGLE`](crate::animate::NO_TRIANGLE).
        pub triangle: u32,
        /// Linear: what an opaque part reflects, what a clear one's surface lets through.
        pub color: Vec3,
        /// Index into the world's parts.
        pub part: u32,
    }
}

impl ListedVoxel {
    /// The voxel's cell in its grid.
    #[must_use]
    pub const fn cell(&self) -> UVec3 {
        unpacked(self.cell)
    }
}

/// The list by rank.
#[derive(Debug)]
pub struct VoxelList {
    pass: ComputePass,
    texture_sampler: wgpu::Sampler,
}

impl VoxelList {
    /// Compiles the pass.
    ///
    /// # Errors
    /// When the shader is wrong.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let layouts = [
            Grid::LAYOUT,
            Record::LAYOUT,
            Vertex::LAYOUT,
            RestVertex::LAYOUT,
            PartMaterial::LAYOUT,
            ListedVoxel::LAYOUT,
        ];
        Ok(Self {
            pass: ComputePass::new(gpu, "voxel_list.wgsl", "main", &layouts)?,
            texture_sampler: gpu.device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("textures"),
                address_mode_u: wgpu::AddressMode::Repeat,
                address_mode_v: wgpu::AddressMode::Repeat,
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                ..Default::default()
            }),
        })
    }

    /// Records the list of a resolved grid into `listed`, an array of [`ListedVoxel`]; what finds no room is left out.
    pub fn record(
        &self,
        rec: &mut Recorder<'_>,
        volume: &Volume,
        grid: usize,
        triangles: &Triangles,
        listed: &wgpu::Buffer,
    ) {
        let Some(g) = volume.grids.get(grid) else { return };
        let mut all = resources(volume, grid);
        all.extend(triangle_resources(triangles));
        all.push(("rest_vertices", triangles.rest_vertices.as_entire_binding()));
        all.push(("textures", wgpu::BindingResource::TextureView(&triangles.textures)));
        all.push(("texture_sampler", wgpu::BindingResource::Sampler(&self.texture_sampler)));
        all.push(("listed", listed.as_entire_binding()));
        self.pass.dispatch(&mut rec.encoder, &self.pass.bind_used(rec.gpu, &all), [g.word_count(), 1, 1]);
    }

    /// The list of a resolved grid whose counts have settled, read back.
    ///
    /// # Errors
    /// When the device refuses the buffer, or is lost.
    pub fn read(
        &self,
        gpu: &Gpu,
        volume: &Volume,
        grid: usize,
        triangles: &Triangles,
    ) -> Result<Vec<ListedVoxel>, GpuError> {
        let counts = volume.counts().get(grid).map_or(0, |c| c.occupied);
        let count = volume.grids.get(grid).map_or(0, |g| counts.min(g.record_capacity)) as usize;
        let listed = buffer::storage(gpu, "voxel_list", (count * size_of::<ListedVoxel>()) as u64)?;
        let mut rec = Recorder::new(gpu, crate::gpu::Timing::Off);
        self.record(&mut rec, volume, grid, triangles, &listed);
        rec.finish()?;
        buffer::read(gpu, &listed, 0, count)
    }
}

/// The list as the paper makes it, while triangles mark; its order is as chance has it.
#[derive(Debug)]
pub struct LockedList {
    /// Orthographic, then perspective.
    by_projection: [ComputePass; 2],
    cells: wgpu::Buffer,
    count: wgpu::Buffer,
}

impl LockedList {
    /// Compiles the passes; `most` voxels have room.
    ///
    /// # Errors
    /// When the shader is wrong, or the device refuses the buffer.
    pub fn new(gpu: &Gpu, most: u32) -> Result<Self, GpuError> {
        let layouts = [Grid::LAYOUT, Vertex::LAYOUT, PartMaterial::LAYOUT];
        let pass = |projection: f64| {
            let constants = [("perspective", projection)];
            ComputePass::with_constants(gpu, "voxel_list_locked.wgsl", "main", &layouts, &constants)
        };
        Ok(Self {
            by_projection: [pass(0.0)?, pass(1.0)?],
            cells: buffer::storage(gpu, "listed_cells", u64::from(most) * 4)?,
            count: buffer::storage(gpu, "listed_count", 4)?,
        })
    }

    /// Marks the cleared grid, a thread a triangle, and lists what was marked.
    pub fn record(&self, rec: &mut Recorder<'_>, volume: &Volume, grid: usize, triangles: &Triangles) {
        let Some(g) = volume.grids.get(grid) else { return };
        rec.encoder.clear_buffer(&self.count, 0, None);
        let mut all = resources(volume, grid);
        all.extend(triangle_resources(triangles));
        all.push(("listed_cells", self.cells.as_entire_binding()));
        all.push(("listed_count", self.count.as_entire_binding()));
        let pass = &self.by_projection[usize::from(g.projection == crate::grid::PERSPECTIVE)];
        pass.dispatch(&mut rec.encoder, &pass.bind_used(rec.gpu, &all), [triangles.triangle_count, 1, 1]);
    }

    /// Reads the cells back.
    ///
    /// # Errors
    /// When the device is lost.
    pub fn read(&self, gpu: &Gpu) -> Result<Vec<UVec3>, GpuError> {
        let count: Vec<u32> = buffer::read(gpu, &self.count, 0, 1)?;
        let room = usize::try_from(self.cells.size() / 4).unwrap_or(usize::MAX);
        let cells = buffer::read(gpu, &self.cells, 0, count.first().map_or(0, |n| *n as usize).min(room))?;
        Ok(cells.into_iter().map(unpacked).collect())
    }
}

/// The cell of `pack_cell` in `shaders/lib/volume.inc.wgsl`.
const fn unpacked(bits: u32) -> UVec3 {
    UVec3::new(bits & 1023, bits >> 10 & 1023, bits >> 20)
}
