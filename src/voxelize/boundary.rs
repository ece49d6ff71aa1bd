//! The boundary of a solid that a method left in the interior words: what it hands on as its surface.

use super::Input;
use crate::gpu::{ComputePass, Gpu, GpuError, GpuStruct, Recorder};
use crate::grid::Grid;

/// Writes cells that are inside and have one of 26 neighbours outside into the occupancy words.
#[derive(Debug)]
pub(super) struct Boundary(ComputePass);

impl Boundary {
    pub(super) fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        ComputePass::new(gpu, "voxelize/boundary.wgsl", "main", &[Grid::LAYOUT]).map(Self)
    }

    /// Records it for the grid of `input`, whose occupancy is cleared.
    pub(super) fn record(&self, rec: &mut Recorder<'_>, input: &Input<'_>) {
        let volume = input.volume;
        let group = self.0.bind(
            rec.gpu,
            &[
                ("grids", volume.grid_data.as_entire_binding()),
                ("grid_index", volume.grid_index[input.grid].as_entire_binding()),
                ("interior", volume.interior.as_entire_binding()),
                ("occupancy", volume.occupancy.as_entire_binding()),
            ],
        );
        self.0.dispatch(&mut rec.encoder, &group, [volume.grids[input.grid].word_count(), 1, 1]);
    }
}
