//! One thread a triangle; solves for the cells of each column that the triangle's box has.
//!
//! Source: [`papers::RAUWENDAAL_BAILEY_2013`], §3.2 and Fig. 17; after Schwarz & Seidel 2010.
//!
//! | paper                | here (`lib/triangle_box.inc.wgsl`) | meaning                                           |
//! |----------------------|------------------------------------|---------------------------------------------------|
//! | v_i, e_i             | `v0` …, `e0` …                     | vertices, edges; grid space, cells                |
//! | n                    | `normal`                           | the triangle's normal                             |
//! | b_min, b_max         | `lo`, `hi`                         | its box                                           |
//! | n_ei^XY, d_ei^XY     | `x_of_y`                           | edge functions, solved for x of a row             |
//! | n_ei^YZ, d_ei^YZ     | `z_of_y`                           | the same, solved for z of a row                   |
//! | n_ei^ZX, d_ei^ZX     | `z_of_x`                           | the same, solved for z of a column                |
//! | d_min, d_max         | `plane_lo`, `plane_hi`             | the plane, solved for z of a column               |
//!
//! Differs: no axis is chosen and no cell is tested. The words hold 32 cells along z, so columns always run along z; each
//! separating axis leaves an interval of z in a column, all intervals are intersected, and the run is set with one
//! atomic a word. Both sides of each axis count, so segments and points are right. The cross product is compensated, so
//! needles are.
//! Promises: exact, 26- or 6-separating. Costs: a thread runs over the columns that its triangle's projection meets, so
//! one huge triangle holds up all others.

use super::variant::{Variant, Variants};
use super::{Input, Method, Promise, Voxelizer};
use crate::animate::Vertex;
use crate::gpu::{ComputePass, Gpu, GpuError, GpuStruct, Recorder};
use crate::grid::Grid;
use crate::papers;
use crate::scene::material::PartMaterial;

const SHADER: &str = "voxelize/triangle_parallel.wgsl";

pub(super) const METHOD: Method = Method {
    name: "triangle-parallel",
    summary: "one thread a triangle; exact",
    shader: Some(SHADER),
    paper: &papers::RAUWENDAAL_BAILEY_2013,
    promise: Promise::Exact,
    interior: false,
    conservative: &[],
    new: |gpu| Ok(Box::new(TriangleParallel::new(gpu)?)),
};

#[derive(Debug)]
struct TriangleParallel {
    passes: Variants<ComputePass>,
}

impl TriangleParallel {
    fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let passes = Variants::new(gpu, |gpu, variant: Variant| {
            let layouts = [Grid::LAYOUT, Vertex::LAYOUT, PartMaterial::LAYOUT];
            ComputePass::with_constants(gpu, SHADER, "main", &layouts, &variant.constants())
        })?;
        Ok(Self { passes })
    }
}

impl Voxelizer for TriangleParallel {
    fn record(&mut self, rec: &mut Recorder<'_>, input: &Input<'_>) -> Result<(), GpuError> {
        let pass = self.passes.get(rec.gpu, Variant::of(input))?;
        let group = pass.bind(rec.gpu, &input.resources());
        pass.dispatch(&mut rec.encoder, &group, [input.triangles.triangle_count, 1, 1]);
        Ok(())
    }
}
