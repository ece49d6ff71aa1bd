//! Triangles by dominant axis into three directional sheet buffers, merged into one worksheet.
//!
//! Source: [`papers::DONG_2004`], §3–4; also TR §1.4.4, who found what the published blending loses.
//!
//! | paper                        | here                     | meaning                                              |
//! |------------------------------|--------------------------|------------------------------------------------------|
//! | directional sheet buffers    | `sheets`                 | three volumes of bits, by the axis of projection     |
//! | C, voxels a texel            | `SLAB`, 32               | cells along the axis that share a word               |
//! | patch                        | a slab's texels          | one after the other within a sheet                   |
//! | rasterization                | `turned`                 | the triangle seen along its dominant axis            |
//! | texelization                 | `texelize`               | a fragment's depth becomes a bit of a texel          |
//! | add blending                 | `blend`                  | `three_axis_blending = "additive"`                   |
//! | synthesis, worksheet         | `synthesize`, occupancy  | the sheets' bits brought to the volume's words       |
//! | scan filling (§3.3)          | `scan_fill`              | the interior                                         |
//!
//! Differs: nothing is sorted beforehand. The vertex stage finds each triangle's axis, and a texel may be of any slab, so
//! the model is traversed once. Bits are united by `atomicOr`; DO adds them, which is right only while each voxel is met
//! once: where two triangles meet, 2ˢ + 2ˢ is the next voxel's bit. That form is an option, its components of 8 bits
//! ending at 255 as those of a render target do. A texel of it is changed by compare and exchange, so the sum doesn't
//! depend on the order. What is drawn is a triangle's rectangle; the fragment asks whether the triangle holds its middle.
//! Promises: approximate, the same from all sides: a voxel is marked where the line through its middle along the
//! triangle's dominant axis meets the triangle. `separability` does not count. The interior (`fill = "eager"`) has
//! streaks where lines graze the surface, as DO §6.2 admits. Costs: a raster set-up for each triangle, and three grids of
//! words that are cleared and read.

use super::raster::{Draw, Raster};
use super::scan_fill::ScanFill;
use super::variant::{Variant, Variants};
use super::{Input, Method, Promise, Voxelizer};
use crate::animate::Vertex;
use crate::gpu::{ComputePass, Gpu, GpuError, GpuStruct, Recorder, buffer};
use crate::grid::{Grid, PERSPECTIVE};
use crate::papers;
use crate::scene::description::{Blending, Fill};
use crate::scene::material::PartMaterial;
use glam::{UVec2, UVec3};

const SHADER: &str = "voxelize/three_axis.wgsl";

/// `RECTANGLE_VERTICES` in the shader.
const RECTANGLE_VERTICES: u32 = 6;

pub(super) const METHOD: Method = Method {
    name: "three-axis",
    summary: "each triangle seen along its dominant axis, three sheets merged into one; a solid by scan filling",
    shader: Some(SHADER),
    paper: &papers::DONG_2004,
    promise: Promise::Approximate,
    interior: true,
    conservative: &[],
    new: |gpu| Ok(Box::new(ThreeAxis::new(gpu)?)),
};

/// The three directional sheet buffers of a grid.
#[derive(Debug)]
pub struct Sheets {
    /// Resolution of the grid.
    pub cells: UVec3,
    /// Texels of the sheets along x, y and z, one sheet after the other: [`Sheets::sheet`].
    pub words: wgpu::Buffer,
}

/// Where a sheet lies, and its form.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sheet {
    /// First texel.
    pub first: u32,
    /// Texels of a patch, across the next axis and the one after it.
    pub size: UVec2,
    /// Patches, of 32 cells along the axis each.
    pub patches: u32,
}

impl Sheets {
    /// The sheet along an axis of a grid, 0 to 2; the twin of `sheet_base` in the shader.
    #[must_use]
    pub fn sheet(cells: UVec3, axis: usize) -> Sheet {
        let of = |a: usize| (UVec2::new(cells[(a + 1) % 3], cells[(a + 2) % 3]), cells[a].div_ceil(32));
        let (size, patches) = of(axis);
        let first = (0..axis).map(|a| of(a).0.element_product() * of(a).1).sum();
        Sheet { first, size, patches }
    }

    fn new(gpu: &Gpu, cells: UVec3) -> Result<Self, GpuError> {
        let words = buffer::storage(gpu, "sheets", u64::from(Self::texel_count(cells)) * 4)?;
        Ok(Self { cells, words })
    }

    fn texel_count(cells: UVec3) -> u32 {
        let last = Self::sheet(cells, 2);
        last.first + last.size.element_product() * last.patches
    }
}

#[derive(Debug)]
struct ThreeAxis {
    passes: Variants<(Raster, ComputePass), (Variant, Blending)>,
    fill: ScanFill,
    /// Those of grid 0, which may be looked at, and those that all others share.
    sheets: [Option<Sheets>; 2],
}

impl ThreeAxis {
    fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let passes = Variants::new(gpu, |gpu, (variant, blending): (Variant, Blending)| {
            let layouts = [Grid::LAYOUT, Vertex::LAYOUT, PartMaterial::LAYOUT];
            let [perspective] = variant.projection_constants();
            let constants = [perspective, ("additive", f64::from(u8::from(blending == Blending::Additive)))];
            Ok((
                Raster::new(gpu, SHADER, ["turned", "texelize"], &layouts, &constants)?,
                ComputePass::with_constants(gpu, SHADER, "synthesize", &layouts, &[])?,
            ))
        })?;
        Ok(Self { passes, fill: ScanFill::new(gpu)?, sheets: [None, None] })
    }
}

impl Voxelizer for ThreeAxis {
    fn record(&mut self, rec: &mut Recorder<'_>, input: &Input<'_>) -> Result<(), GpuError> {
        let grid = &input.volume.grids[input.grid];
        let sheets = match &mut self.sheets[usize::from(input.grid != 0)] {
            Some(sheets) if sheets.cells == grid.cells => sheets,
            sheets => sheets.insert(Sheets::new(rec.gpu, grid.cells)?),
        };
        let variant = (Variant::of(input), input.settings.three_axis_blending);
        let (raster, synthesize) = self.passes.get(rec.gpu, variant)?;
        rec.encoder.clear_buffer(&sheets.words, 0, None);
        let mut resources = input.resources().to_vec();
        resources.push(("sheets", sheets.words.as_entire_binding()));
        let draw = Draw::Counted {
            vertices: input.triangles.triangle_count * RECTANGLE_VERTICES,
            // A triangle cut at the eye has up to two pieces.
            instances: if grid.projection == PERSPECTIVE { 2 } else { 1 },
        };
        raster.record(rec, UVec2::splat(grid.cells.max_element()), &resources, draw);
        let group = synthesize.bind(rec.gpu, &resources);
        synthesize.dispatch(&mut rec.encoder, &group, [Sheets::texel_count(grid.cells), 1, 1]);
        if input.settings.fill == Fill::Eager {
            self.fill.record(rec, input);
        }
        Ok(())
    }

    fn sheets(&self) -> Option<&Sheets> {
        self.sheets[0].as_ref()
    }
}
