//! Stage 3: ranks the occupied voxels, picks the triangles that win them, works out their records.

use crate::animate::Triangles;
use crate::gpu::{Gpu, GpuError, Recorder};
use crate::volume::Volume;

/// The passes.
#[derive(Debug)]
pub struct Resolve {}

impl Resolve {
    /// Compiles the passes.
    ///
    /// # Errors
    /// When a shader is wrong.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let _ = gpu;
        Ok(Self {})
    }

    /// Records the stage for one grid.
    pub fn record(&self, rec: &mut Recorder<'_>, volume: &Volume, grid: usize, triangles: &Triangles) {
        let _ = (rec, volume, grid, triangles);
    }
}
