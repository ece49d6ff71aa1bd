//! Stage 4: the interior by exact parity: one toggled bit a crossing, then a prefix XOR down each column.
//!
//! Source: [`papers::CHANG_LAI_2011`], §2.3, first strategy; the toggles after Eisemann & Décoret 2008.
//! A mesh that leaks makes odd columns. They are counted ([`GridCounters::odd_columns`]) and, if asked for, take what
//! most of the nearest even columns in eight directions have; else they are solid from their last crossing to the grid's end.
//!
//! [`papers::CHANG_LAI_2011`]: crate::papers::CHANG_LAI_2011

use crate::animate::{Triangles, Vertex};
use crate::gpu::{ComputePass, Gpu, GpuError, GpuStruct, Layout, Recorder};
use crate::grid::{Grid, ORTHOGRAPHIC, PERSPECTIVE};
use crate::resolve::{LargeTriangles, resources, triangle_resources};
use crate::scene::material::PartMaterial;
use crate::volume::{GridCounters, Volume};

/// The passes.
#[derive(Debug)]
pub struct FillInterior {
    /// Orthographic, then perspective: all triangles, then the shares of large ones.
    toggle_by_projection: [[ComputePass; 2]; 2],
    sweep: ComputePass,
    mend: ComputePass,
    large: LargeTriangles,
}

const LAYOUTS: [Layout; 4] = [Grid::LAYOUT, Vertex::LAYOUT, PartMaterial::LAYOUT, GridCounters::LAYOUT];

/// Passes that toggle one bit a crossing: for orthographic grids, then perspective ones; over all triangles, then the
/// shares of large ones. With `by_operand` those of bodies' operands ([`crate::csg`]), else all others.
pub(crate) fn toggles(gpu: &Gpu, by_operand: bool) -> Result<[[ComputePass; 2]; 2], GpuError> {
    let pass = |entry, projection: u32| {
        let constants = [("perspective", f64::from(projection)), ("by_operand", f64::from(u8::from(by_operand)))];
        ComputePass::with_constants(gpu, "fill.wgsl", entry, &LAYOUTS, &constants)
    };
    let both = |projection| Ok::<_, GpuError>([pass("main", projection)?, pass("large", projection)?]);
    Ok([both(ORTHOGRAPHIC)?, both(PERSPECTIVE)?])
}

impl FillInterior {
    /// Compiles the passes.
    ///
    /// # Errors
    /// When a shader is wrong.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        Ok(Self {
            toggle_by_projection: toggles(gpu, false)?,
            sweep: ComputePass::new(gpu, "fill.wgsl", "sweep", &LAYOUTS)?,
            mend: ComputePass::new(gpu, "fill.wgsl", "mend", &LAYOUTS)?,
            large: LargeTriangles::new(gpu)?,
        })
    }

    /// Records the eager fill of one grid into `volume.interior`. With `repair`, odd columns take what most of their
    /// nearest even neighbours have.
    pub fn record(&self, rec: &mut Recorder<'_>, volume: &Volume, grid: usize, triangles: &Triangles, repair: bool) {
        let Some(g) = volume.grids.get(grid) else { return };
        rec.encoder.clear_buffer(&volume.interior, u64::from(g.word_base) * 4, Some(u64::from(g.word_count()) * 4));
        rec.encoder.clear_buffer(&volume.chunk_sums, 0, None);
        let mut all = resources(volume, grid);
        all.extend(triangle_resources(triangles));
        let [main, large] = &self.toggle_by_projection[usize::from(g.projection == PERSPECTIVE)];
        self.large.record(rec, [main, large], &all, triangles.triangle_count);
        let columns = [g.cells.x * g.cells.y, 1, 1];
        self.sweep.dispatch(&mut rec.encoder, &self.sweep.bind_used(rec.gpu, &all), columns);
        if repair {
            self.mend.dispatch(&mut rec.encoder, &self.mend.bind_used(rec.gpu, &all), columns);
        }
    }
}
