//! A fragment for each column that a triangle meets, and a bit by its depth.
//!
//! Source: [`papers::EISEMANN_DECORET_2006`], as TR §1.4.2 gives it; conservative depth from TR §1.4.5.3.
//!
//! | paper (TR §1.4.2)       | here                       | meaning                                                   |
//! |-------------------------|----------------------------|-----------------------------------------------------------|
//! | slicemap                | `occupancy`                | a bit a cell, a column's bits together                    |
//! | z_e                     | `depths_over`              | the fragment's depth                                      |
//! | z′ (Eq. 1.9, mended)    | `slice_of`                 | that depth, linear in eye space, in slices                |
//! | cellmask texture        | `word_bit` in `mark_run`   | the bit of a slice                                        |
//! | logical OR              | `atomicOr`                 | how fragments of one column meet                          |
//!
//! Differs: any depth, 32 slices a word, where the paper has the bits of its render targets; no texture holds the masks.
//! The depth is that of the triangle's plane on the column's middle line, held within the triangle's own.
//! Promises: approximate. One slice a column: a steep triangle leaves holes along z, conservative or not, and columns
//! whose middle line it misses are left out unless `conservative`. With `conservative` and `conservative_depth` no voxel
//! that the surface meets is left out, and corners of the triangles' own boxes are added. `separability` does not count.
//! Costs: one draw; a bit a fragment.

use super::raster::{Draw, Raster};
use super::variant::{EVERY_WAY, Variant, Variants};
use super::{Input, Method, Promise, Voxelizer};
use crate::animate::Vertex;
use crate::gpu::{Gpu, GpuError, GpuStruct, Recorder};
use crate::grid::Grid;
use crate::papers;
use crate::scene::material::PartMaterial;

const SHADER: &str = "voxelize/slicemap.wgsl";

pub(super) const METHOD: Method = Method {
    name: "slicemap",
    summary: "a fragment for each column of a triangle, one bit by its depth",
    shader: Some(SHADER),
    paper: &papers::EISEMANN_DECORET_2006,
    promise: Promise::Approximate,
    interior: false,
    conservative: EVERY_WAY,
    new: |gpu| Ok(Box::new(Slicemap::new(gpu)?)),
};

#[derive(Debug)]
struct Slicemap {
    rasters: Variants<Raster>,
}

impl Slicemap {
    fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let rasters = Variants::new(gpu, |gpu, variant| {
            let layouts = [Grid::LAYOUT, Vertex::LAYOUT, PartMaterial::LAYOUT];
            Raster::of_footprints(gpu, SHADER, ["project", "mark"], &layouts, variant, &[])
        })?;
        Ok(Self { rasters })
    }
}

impl Voxelizer for Slicemap {
    fn record(&mut self, rec: &mut Recorder<'_>, input: &Input<'_>) -> Result<(), GpuError> {
        let variant = Variant::footprint(input);
        let draw = Draw::Counted {
            vertices: input.triangles.triangle_count * variant.footprint_vertices(),
            instances: variant.pieces(),
        };
        let size = input.volume.grids[input.grid].cells.truncate();
        self.rasters.get(rec.gpu, variant)?.record(rec, size, &input.resources(), draw);
        Ok(())
    }
}
