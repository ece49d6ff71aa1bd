//! Stage 5: walks each column of each light's grid and writes how much light is left after each record.

use crate::animate::Triangles;
use crate::gpu::{Gpu, GpuError, Recorder};
use crate::scene::description::EffectSettings;
use crate::volume::Volume;

/// The pass.
#[derive(Debug)]
pub struct LightColumns {}

impl LightColumns {
    /// Compiles the pass.
    ///
    /// # Errors
    /// When a shader is wrong.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let _ = gpu;
        Ok(Self {})
    }

    /// Records the walk of one light's grid into `volume.light_records`.
    pub fn record(
        &self,
        rec: &mut Recorder<'_>,
        volume: &Volume,
        grid: usize,
        triangles: &Triangles,
        effect: &EffectSettings,
    ) {
        let _ = (rec, volume, grid, triangles, effect);
    }
}
