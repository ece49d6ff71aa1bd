//! The volume: one set of buffers that holds every grid of the frame.
//!
//! All grids (the view's, the scene's, each light's) share the same few buffers and have a region in each, so that a
//! shader that walks several grids stays within the eight storage buffers that WebGPU promises. Regions change only
//! when a grid outgrows its own, so that one grid can be made anew while the others stand.
//!
//! How many records a grid needs is known only once it is voxelized. Its capacity starts as an estimate; ranks past it
//! are dropped in order; the device's counts come back a frame late ([`Volume::count`]) and the next
//! [`Volume::fit`] makes room. A program that shows no frame before the last one calls [`Volume::settle`] and renders
//! again until it says true.
//!
//! | buffer        | one entry           | bytes | what                                                       |
//! | `occupancy`   | a word              | 4     | 32 slices of a column, a bit each                          |
//! | `ranks`       | a word              | 4     | occupied voxels of this grid before this word              |
//! | `interior`    | a word              | 4     | solid cells (eager fill), else unused and tiny             |
//! | `records`     | a voxel, in rank order; then further sheets | 16 | [`Record`]                          |
//! | `keys`        | six a voxel         | 4     | transient: winners, shared by all grids; all 0 in between  |
//! | `chunk_sums`  | 32 words or voxels  | 4     | transient: prefix sums, shared by all grids                |
//! | `light_records` | a record          | 8     | what is left of the light there, and its medium; light grids only |
//! | `counters`    | a grid              | 16    | [`GridCounters`]                                           |

mod counts;
mod regions;

use crate::gpu::{Gpu, GpuError, Recorder, buffer};
use crate::grid::{Grid, MAX_GRIDS};
use crate::scene::description::CELLS;
use counts::Counts;
use regions::Regions;

crate::gpu_struct! {
    /// One sheet of surface in one voxel; see `shaders/lib/record.inc.wgsl`.
    pub struct Record {
        /// Triangle number and flags.
        pub triangle: u32,
        /// Octahedral plane normal, world.
        pub normal: u32,
        /// A point of the plane in the cell.
        pub point: u32,
        /// Part, and where further sheets start.
        pub medium: u32,
    }
}

crate::gpu_struct! {
    /// What a grid holds, counted by the device and read back a frame late. Counts what did not fit, too.
    pub struct GridCounters {
        /// Occupied voxels.
        pub occupied: u32,
        /// Further sheets.
        pub extras: u32,
        /// Columns with an odd number of crossings (eager fill).
        pub odd_columns: u32,
        /// Marked voxels that no triangle claimed.
        pub orphans: u32,
    }
}

/// Items of a chunk in the prefix sums, `CHUNK` in `lib/volume.inc.wgsl`.
pub const CHUNK: u32 = 32;
/// Winners that a voxel can have.
const SLOTS: u64 = 6;

const REMEDY: &str = "choose a smaller grid: a lower grid.cells or light_grid.cells";

/// The buffers of all grids of a frame.
#[derive(Debug)]
pub struct Volume {
    /// The grids, with their regions set.
    pub grids: Vec<Grid>,
    /// `array<Grid, MAX_GRIDS>`, uniform.
    pub grid_data: wgpu::Buffer,
    /// One small uniform a grid that holds its number: what a pass over one grid binds as `grid_index`.
    pub grid_index: Vec<wgpu::Buffer>,
    /// See the module's table.
    pub occupancy: wgpu::Buffer,
    /// See the module's table.
    pub ranks: wgpu::Buffer,
    /// See the module's table.
    pub interior: wgpu::Buffer,
    /// See the module's table.
    pub records: wgpu::Buffer,
    /// See the module's table.
    pub keys: wgpu::Buffer,
    /// See the module's table.
    pub chunk_sums: wgpu::Buffer,
    /// See the module's table.
    pub light_records: wgpu::Buffer,
    /// See the module's table.
    pub counters: wgpu::Buffer,
    regions: Regions,
    counts: Counts,
}

impl Volume {
    /// An empty volume.
    ///
    /// # Errors
    /// When the device refuses even small buffers.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let grid_index = (0_u32..).take(MAX_GRIDS).map(|g| buffer::uniform(gpu, "grid_index", &[g, 0, 0, 0])).collect();
        Ok(Self {
            grids: Vec::new(),
            grid_data: gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("grids"),
                size: (size_of::<Grid>() * MAX_GRIDS) as u64,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }),
            grid_index,
            occupancy: buffer::storage(gpu, "occupancy", 0)?,
            ranks: buffer::storage(gpu, "ranks", 0)?,
            interior: buffer::storage(gpu, "interior", 0)?,
            records: buffer::storage(gpu, "records", 0)?,
            keys: buffer::storage(gpu, "keys", 0)?,
            chunk_sums: buffer::storage(gpu, "chunk_sums", 0)?,
            light_records: buffer::storage(gpu, "light_records", 0)?,
            counters: buffer::storage(gpu, "counters", (size_of::<GridCounters>() * MAX_GRIDS) as u64)?,
            regions: Regions::default(),
            counts: Counts::default(),
        })
    }

    /// Gives every grid its region and (re)allocates what is too small, from the last counts where there are any.
    /// Returns, for each grid, whether its region is new: then it must be voxelized.
    ///
    /// # Errors
    /// When a grid can't fit the device's bindings or memory, before anything is allocated where that can be known; the
    /// remedy is a smaller grid.
    pub fn fit(&mut self, gpu: &Gpu, grids: &[Grid]) -> Result<Vec<bool>, GpuError> {
        self.counts.poll(gpu);
        let mut regions = self.regions.clone();
        let anew = regions.fit(grids, self.counts.of(self.regions.generation), buffer::largest(gpu));
        if regions.generation != self.regions.generation {
            self.allocate(gpu, grids, &regions)?;
        }
        self.regions = regions;
        self.grids = grids.to_vec();
        for (grid, region) in self.grids.iter_mut().zip(&self.regions.of_grids) {
            grid.word_base = region.word_base;
            grid.record_base = region.record_base;
            grid.record_capacity = region.record_capacity;
            grid.extra_base = region.extra_base;
            grid.extra_capacity = region.extra_capacity;
        }
        gpu.queue.write_buffer(&self.grid_data, 0, bytemuck::cast_slice(&self.grids));
        Ok(anew)
    }

    fn allocate(&mut self, gpu: &Gpu, grids: &[Grid], regions: &Regions) -> Result<(), GpuError> {
        let allowed = buffer::largest(gpu);
        let sizes = regions.sizes();
        if let Some((label, needed)) = sizes.named().into_iter().find(|(_, bytes)| *bytes > allowed) {
            let cells: Vec<String> =
                grids.iter().map(|g| format!("{}x{}x{}", g.cells.x, g.cells.y, g.cells.z)).collect();
            let what = format!("`{label}` of grids of {} cells", cells.join(", "));
            return Err(GpuError::Limit { what, needed, allowed, remedy: REMEDY });
        }
        let scope = gpu.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let occupancy = buffer::storage(gpu, "occupancy", sizes.words)?;
        let ranks = buffer::storage(gpu, "ranks", sizes.words)?;
        let interior = buffer::storage(gpu, "interior", sizes.words)?;
        let records = buffer::storage(gpu, "records", sizes.records)?;
        let light_records = buffer::storage(gpu, "light_records", sizes.light_records)?;
        let keep_keys = (sizes.keys..=2 * sizes.keys).contains(&self.keys.size());
        let keys = if keep_keys { self.keys.clone() } else { buffer::storage(gpu, "keys", sizes.keys)? };
        let chunk_sums = buffer::storage(gpu, "chunk_sums", sizes.chunk_sums)?;
        if pollster::block_on(scope.pop()).is_some() {
            let mib = sizes.named().iter().map(|(_, bytes)| bytes).sum::<u64>() >> 20;
            let what = format!("the grids' {mib} MiB");
            return Err(GpuError::Memory { what, remedy: REMEDY });
        }
        (self.occupancy, self.ranks, self.interior) = (occupancy, ranks, interior);
        (self.records, self.light_records) = (records, light_records);
        (self.keys, self.chunk_sums) = (keys, chunk_sums);
        Ok(())
    }

    /// Room for the words of one grid and, if `solid`, its interior, but for no ranks and no records: for marking alone,
    /// which takes grids that no frame can. The next [`Volume::fit`] starts anew.
    ///
    /// # Errors
    /// When the grid can't fit the device's bindings.
    pub fn fit_words(&mut self, gpu: &Gpu, grid: &Grid, solid: bool) -> Result<(), GpuError> {
        let bytes = u64::from(grid.word_count()) * 4;
        let grow = |buffer: &mut wgpu::Buffer, label, bytes| {
            if buffer.size() < bytes {
                *buffer = buffer::storage(gpu, label, bytes)?;
            }
            Ok::<_, GpuError>(())
        };
        grow(&mut self.occupancy, "occupancy", bytes)?;
        grow(&mut self.interior, "interior", if solid { bytes } else { 0 })?;
        // A bit a column.
        grow(&mut self.chunk_sums, "chunk_sums", (u64::from(grid.cells.x) * u64::from(grid.cells.y)).div_ceil(8))?;
        self.regions.forget();
        self.grids = vec![Grid { word_base: 0, record_capacity: 0, extra_capacity: 0, ..*grid }];
        gpu.queue.write_buffer(&self.grid_data, 0, bytemuck::cast_slice(&self.grids));
        Ok(())
    }

    /// Cells along the axes of the largest cube whose words, ranks and records the adapter's bindings hold, alone in a
    /// frame.
    #[must_use]
    pub fn largest_cube(gpu: &Gpu) -> u32 {
        let allowed = buffer::largest(gpu);
        let fits = |cells: &u32| {
            let mut regions = Regions::default();
            regions.fit(&[Grid::world_aligned(glam::DVec3::ZERO, 1.0, glam::UVec3::splat(*cells))], &[], allowed);
            regions.sizes().named().iter().all(|(_, bytes)| *bytes <= allowed)
        };
        CELLS.rev().step_by(16).find(fits).unwrap_or(0)
    }

    /// Clears a grid's occupancy words and counts.
    pub fn clear(&self, rec: &mut Recorder<'_>, grid: usize) {
        let Some(g) = self.grids.get(grid) else { return };
        let bytes = u64::from(g.word_count()) * 4;
        rec.encoder.clear_buffer(&self.occupancy, u64::from(g.word_base) * 4, Some(bytes));
        let counters = size_of::<GridCounters>() as u64;
        rec.encoder.clear_buffer(&self.counters, grid as u64 * counters, Some(counters));
    }

    /// At the end of a frame: asks for its counts, which come back a frame late. Never waits.
    pub fn count(&mut self, rec: &mut Recorder<'_>) {
        self.counts.ask(rec, &self.counters, self.regions.generation);
    }

    /// Takes in the counts that have come back since; never waits.
    pub fn take_counts(&mut self, gpu: &Gpu) {
        self.counts.poll(gpu);
    }

    /// Waits for the counts of the last frame: true if every record had room. Headless only.
    ///
    /// # Errors
    /// When the device is lost.
    pub fn settle(&mut self, gpu: &Gpu) -> Result<bool, GpuError> {
        let counters = buffer::read(gpu, &self.counters, 0, self.grids.len())?;
        self.counts.put_now(counters, self.regions.generation);
        Ok(self.fits())
    }

    /// True if the last counts that came back had room for every record.
    #[must_use]
    pub fn fits(&self) -> bool {
        let counts = self.counts.of(self.regions.generation);
        counts.iter().zip(&self.regions.of_grids).all(|(count, region)| region.holds(count))
    }

    /// The last counts that came back, a grid each; empty at first.
    #[must_use]
    pub fn counts(&self) -> &[GridCounters] {
        self.counts.of(self.regions.generation)
    }

    /// Bytes of every buffer, as allocated, by name.
    #[must_use]
    pub fn memory(&self) -> Vec<(&'static str, u64)> {
        vec![
            ("occupancy", self.occupancy.size()),
            ("ranks", self.ranks.size()),
            ("interior", self.interior.size()),
            ("records", self.records.size()),
            ("keys", self.keys.size()),
            ("chunk sums", self.chunk_sums.size()),
            ("light records", self.light_records.size()),
        ]
    }

    /// Bytes that one grid takes of the buffers that grids do not share in time: words, ranks and interior, records
    /// and light records, as its region is allocated.
    #[must_use]
    pub fn grid_memory(&self, grid: usize) -> u64 {
        self.regions.of_grids.get(grid).map_or(0, |region| region.bytes())
    }
}

/// RGB half and medium.
const LIGHT_RECORD_BYTES: u64 = 8;
