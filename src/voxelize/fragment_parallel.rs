//! A fragment for each column that a triangle may meet; the fragment solves for the column's cells.
//!
//! Source: [`papers::RAUWENDAAL_BAILEY_2013`], §3.3; the outline after Hasselgren et al. 2005 (RB Fig. 8).
//!
//! | paper              | here (`lib/column_raster.inc.wgsl`)  | meaning                                                |
//! |--------------------|--------------------------------------|--------------------------------------------------------|
//! | T                  | `a`, `b`, `c`                        | the triangle, grid space                               |
//! | T′                 | `outline_corner`                     | what is rasterized in its stead                        |
//! | l                  | `reach`                              | how far T′ goes beyond T, cells                        |
//! | lines 14–20        | `mark_fragment`                      | what Figs. 17 and 18 leave to the fragment             |
//!
//! Differs: nothing is swizzled. RB turns each triangle to its dominant axis, so that no column is deeper than three
//! cells. Here a word holds 32 cells along z and a column is solved, not walked, so a steep triangle is cheapest seen
//! along z: few columns, each marked with few atomics. T′ is the hull of three squares instead of the triangle's own
//! shape grown: no spikes, right for lines and points. There are no geometry shaders: the vertex shader pulls a triangle
//! twelve times.
//! It is conservative by nature, in depth too, so it takes no `conservative` option: the outline reaches every column
//! that a triangle touches, and the fragment decides.
//! Promises: exact, 26- or 6-separating. Costs: a vertex stage and a raster set-up for each triangle, ten times what
//! `triangle-parallel` takes for small ones; fast on large ones, which spread over all cores.

use super::raster::{Draw, Raster};
use super::variant::{Variant, Variants};
use super::{Input, Method, Promise, Voxelizer};
use crate::animate::Vertex;
use crate::gpu::{Gpu, GpuError, GpuStruct, Recorder};
use crate::grid::{Grid, PERSPECTIVE};
use crate::papers;
use crate::scene::material::PartMaterial;

const SHADER: &str = "voxelize/fragment_parallel.wgsl";

/// Vertices of a triangle's outline, `OUTLINE_VERTICES` in the shader.
const OUTLINE_VERTICES: u32 = 12;

pub(super) const METHOD: Method = Method {
    name: "fragment-parallel",
    summary: "a fragment for each column of a triangle; exact",
    shader: Some(SHADER),
    paper: &papers::RAUWENDAAL_BAILEY_2013,
    promise: Promise::Exact,
    interior: false,
    conservative: &[],
    new: |gpu| Ok(Box::new(FragmentParallel::new(gpu)?)),
};

#[derive(Debug)]
struct FragmentParallel {
    rasters: Variants<Raster>,
}

impl FragmentParallel {
    fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let rasters = Variants::new(gpu, |gpu, variant: Variant| {
            let layouts = [Grid::LAYOUT, Vertex::LAYOUT, PartMaterial::LAYOUT];
            Raster::new(gpu, SHADER, ["outline", "mark"], &layouts, &variant.constants())
        })?;
        Ok(Self { rasters })
    }
}

impl Voxelizer for FragmentParallel {
    fn record(&mut self, rec: &mut Recorder<'_>, input: &Input<'_>) -> Result<(), GpuError> {
        let grid = &input.volume.grids[input.grid];
        let draw = Draw::Counted {
            vertices: input.triangles.triangle_count * OUTLINE_VERTICES,
            // A triangle cut at the eye has up to two pieces.
            instances: if grid.projection == PERSPECTIVE { 2 } else { 1 },
        };
        let raster = self.rasters.get(rec.gpu, Variant::of(input))?;
        raster.record(rec, grid.cells.truncate(), &input.resources(), draw);
        Ok(())
    }
}
