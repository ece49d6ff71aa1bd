//! A fragment for each column of a triangle's bounding rectangle; a loop over the depth range tests cell by cell.
//!
//! Source: [`papers::TRIPIANA_2009`], ch. 2 and appendix A; the two-ended loop from ch. 5.
//!
//! | paper                     | here                        | meaning                                                  |
//! |---------------------------|-----------------------------|----------------------------------------------------------|
//! | triangle                  | `a`, `b`, `c`               | the triangle, grid space                                 |
//! | AABR, expanded            | `rectangle`                 | what is rasterized in its stead                          |
//! | half a pixel (1/res)      | `GROWTH`                    | how far it is expanded, and a little for the rasterizer  |
//! | depth range               | `range`                     | slices that the triangle's box meets                     |
//! | SAT, `triBoxOverlap`      | `is_met`                    | the thirteen axes, for one cell                          |
//! | bitmask, OR               | `mark_run`                  | the loop's cells, set by `atomicOr`                      |
//! | the loop split in half    | `run_met_two_ended`         | two loops from the middle outwards, which may end early  |
//!
//! Differs: the loop's cells are one run, so they are set with one atomic a word, whatever the grid's depth. Vertices are
//! not interpolated, and seen from a whole cell near the triangle: TR has spurious voxels beside missing ones from that.
//! Cells of a perspective grid are boxes of their slice's depth.
//! Promises: exact, 26- or 6-separating. Costs: a vertex stage and a raster set-up for each triangle, and a test for each
//! cell of its box, so a large slanted triangle costs the cube of its size.

use super::raster::{Draw, Raster};
use super::variant::{Variant, Variants};
use super::{Input, Method, Promise, Voxelizer};
use crate::animate::Vertex;
use crate::gpu::{Gpu, GpuError, GpuStruct, Recorder};
use crate::grid::{Grid, PERSPECTIVE};
use crate::papers;
use crate::scene::description::ColumnLoop;
use crate::scene::material::PartMaterial;

const SHADER: &str = "voxelize/exact_columns.wgsl";

/// `RECTANGLE_VERTICES` in the shader.
const RECTANGLE_VERTICES: u32 = 6;

pub(super) const METHOD: Method = Method {
    name: "exact-columns",
    summary: "a fragment for each column of a triangle's rectangle, a test for each cell; exact",
    shader: Some(SHADER),
    paper: &papers::TRIPIANA_2009,
    promise: Promise::Exact,
    interior: false,
    conservative: &[],
    new: |gpu| Ok(Box::new(ExactColumns::new(gpu)?)),
};

#[derive(Debug)]
struct ExactColumns {
    rasters: Variants<Raster, (Variant, ColumnLoop)>,
}

impl ExactColumns {
    fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let rasters = Variants::new(gpu, |gpu, (variant, column_loop): (Variant, ColumnLoop)| {
            let layouts = [Grid::LAYOUT, Vertex::LAYOUT, PartMaterial::LAYOUT];
            let [thin, perspective] = variant.constants();
            let two_ended = ("two_ended", f64::from(u8::from(column_loop == ColumnLoop::TwoEnded)));
            Raster::new(gpu, SHADER, ["rectangle", "mark"], &layouts, &[thin, perspective, two_ended])
        })?;
        Ok(Self { rasters })
    }
}

impl Voxelizer for ExactColumns {
    fn record(&mut self, rec: &mut Recorder<'_>, input: &Input<'_>) -> Result<(), GpuError> {
        let grid = &input.volume.grids[input.grid];
        let draw = Draw::Counted {
            vertices: input.triangles.triangle_count * RECTANGLE_VERTICES,
            // A triangle cut at the eye has up to two pieces.
            instances: if grid.projection == PERSPECTIVE { 2 } else { 1 },
        };
        let raster = self.rasters.get(rec.gpu, (Variant::of(input), input.settings.column_loop))?;
        raster.record(rec, grid.cells.truncate(), &input.resources(), draw);
        Ok(())
    }
}
