//! Stage 4: the interior by exact parity: one toggled bit a crossing, then a prefix XOR down each column.

use crate::animate::Triangles;
use crate::gpu::{Gpu, GpuError, Recorder};
use crate::volume::Volume;

/// The passes.
#[derive(Debug)]
pub struct FillInterior {}

impl FillInterior {
    /// Compiles the passes.
    ///
    /// # Errors
    /// When a shader is wrong.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let _ = gpu;
        Ok(Self {})
    }

    /// Records the eager fill of one grid into `volume.interior`.
    pub fn record(&self, rec: &mut Recorder<'_>, volume: &Volume, grid: usize, triangles: &Triangles) {
        let _ = (rec, volume, grid, triangles);
    }
}
