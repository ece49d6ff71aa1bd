//! A fragment for each column that a triangle meets; it toggles every cell whose centre lies in front of it.
//!
//! Source: [`papers::EISEMANN_DECORET_2008`], as TR §1.4.3 gives it.
//!
//! | paper (TR §1.4.3)       | here                       | meaning                                                   |
//! |-------------------------|----------------------------|-----------------------------------------------------------|
//! | mask[k], bits 0 … k − 1 | the words below `count`    | all cells in front of the fragment                        |
//! | logical XOR             | `atomicXor`                | a cell is inside if an odd number of surfaces lie beyond  |
//! | half a voxel added      | `centers_before`           | counters the shift: cells are sampled at their centres    |
//!
//! Differs: any depth, 32 slices a word. The solid goes to the interior words and its boundary, cells with one of 26
//! neighbours outside, to the occupancy words; the paper asks for a second method for the boundary.
//! Promises: approximate; the solid of closed meshes, each cell by its centre. It hangs on the rasterizer drawing each
//! shared edge once, which it does, so it can't be conservative. A leak is a column that is solid as far as the surface.
//! `separability` does not count. Costs: one draw; a fragment toggles every word in front of it.
//!
//! Beside it: [`crate::fill`] has its own rasterizer in whole numbers and toggles one bit a crossing.

use super::boundary::Boundary;
use super::raster::{Draw, Raster};
use super::variant::{Variant, Variants};
use super::{Input, Method, Promise, Voxelizer};
use crate::animate::Vertex;
use crate::gpu::{Gpu, GpuError, GpuStruct, Recorder};
use crate::grid::Grid;
use crate::papers;
use crate::scene::description::Conservative;
use crate::scene::material::PartMaterial;

const SHADER: &str = "voxelize/slicemap_solid.wgsl";

pub(super) const METHOD: Method = Method {
    name: "slicemap-solid",
    summary: "the solid of closed meshes: every fragment toggles the cells in front of it",
    shader: Some(SHADER),
    paper: &papers::EISEMANN_DECORET_2008,
    promise: Promise::Approximate,
    interior: true,
    conservative: &[],
    new: |gpu| Ok(Box::new(SlicemapSolid::new(gpu)?)),
};

#[derive(Debug)]
struct SlicemapSolid {
    rasters: Variants<Raster>,
    boundary: Boundary,
}

impl SlicemapSolid {
    fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let rasters = Variants::new(gpu, |gpu, variant| {
            let layouts = [Grid::LAYOUT, Vertex::LAYOUT, PartMaterial::LAYOUT];
            Raster::of_footprints(gpu, SHADER, ["project", "toggle"], &layouts, variant, &[])
        })?;
        Ok(Self { rasters, boundary: Boundary::new(gpu)? })
    }
}

impl Voxelizer for SlicemapSolid {
    fn record(&mut self, rec: &mut Recorder<'_>, input: &Input<'_>) -> Result<(), GpuError> {
        if input.settings.conservative != Conservative::None || input.settings.conservative_depth {
            return Err(GpuError::Setting(format!(
                "`{}` can't be conservative, edges that triangles share would count twice; \
                 write conservative = \"none\" and conservative_depth = false",
                METHOD.name
            )));
        }
        input.clear_interior(rec);
        let variant = Variant::plain(input);
        let draw = Draw::Counted {
            vertices: input.triangles.triangle_count * variant.footprint_vertices(),
            instances: variant.pieces(),
        };
        let size = input.volume.grids[input.grid].cells.truncate();
        self.rasters.get(rec.gpu, variant)?.record(rec, size, &input.interior_resources(), draw);
        self.boundary.record(rec, input);
        Ok(())
    }
}
