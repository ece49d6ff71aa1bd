//! The interior by scan filling along three axes, from marked voxels alone.
//!
//! Source: [`crate::papers::DONG_2004`], §3.3; the surface belongs to the solid.

use super::Input;
use crate::gpu::{ComputePass, Gpu, GpuError, GpuStruct, Recorder};
use crate::grid::Grid;

/// The passes, in order: along z, along x, along y.
#[derive(Debug)]
pub(super) struct ScanFill {
    passes: [ComputePass; 3],
}

impl ScanFill {
    /// Compiles them.
    pub(super) fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let pass = |entry| ComputePass::new(gpu, "voxelize/scan_fill.wgsl", entry, &[Grid::LAYOUT]);
        Ok(Self { passes: [pass("along_z")?, pass("along_x")?, pass("along_y")?] })
    }

    /// Writes the grid's `interior` from its `occupancy`.
    pub(super) fn record(&self, rec: &mut Recorder<'_>, input: &Input<'_>) {
        let volume = input.volume;
        let grid = &volume.grids[input.grid];
        let resources = [
            ("grids", volume.grid_data.as_entire_binding()),
            ("grid_index", volume.grid_index[input.grid].as_entire_binding()),
            ("occupancy", volume.occupancy.as_entire_binding()),
            ("interior", volume.interior.as_entire_binding()),
        ];
        let per_column = grid.words_per_column;
        let lines = [grid.cells.x * grid.cells.y, grid.cells.y * per_column, grid.cells.x * per_column];
        for (pass, lines) in self.passes.iter().zip(lines) {
            pass.dispatch(&mut rec.encoder, &pass.bind(rec.gpu, &resources), [lines, 1, 1]);
        }
    }
}
