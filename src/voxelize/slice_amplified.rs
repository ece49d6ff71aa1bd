//! One pass over all slices: every triangle repeated for each slice that it may meet, and clipped to it.
//!
//! Source: [`papers::CHANG_LAI_2011`], §2.2 and Fig. 2; the overlap from §3.2.2.
//!
//! | paper                    | here                     | meaning                                                  |
//! |--------------------------|--------------------------|----------------------------------------------------------|
//! | Tri, V0 V1 V2            | `a`, `b`, `c`            | the triangle, grid space                                 |
//! | Z()                      | `z` of grid space        | depth along the columns                                  |
//! | thickness                | 1, or `slab` k to k + 1  | a slice's depth                                          |
//! | min_slice, max_slice     | `slices_reached`         | slices that the triangle may meet                        |
//! | Plane_near, Plane_far    | `near`, `far`            | ends of a slice, moved apart by `slice_overlap`          |
//! | Intersect(Tri)           | the rasterizer's clipper | leaves out the copies that miss their slice              |
//!
//! Differs: there are no geometry shaders, so a compute pass lists the copies and one indirect draw rasterizes them. A
//! voxel holds a bit, not a normal: records come later, the same for all methods. Where it is conservative the fragment
//! cuts at the slice, by the depth that the plane has in the column: an outline's corners have none.
//! Promises: approximate. A voxel is marked where the column's middle line meets the triangle, so a steep triangle leaves
//! holes between columns; a larger overlap marks more voxels along z and closes none of them. `conservative` and
//! `conservative_depth` together close all. `separability` does not count. Costs: a clipped triangle for each slice it spans.

use super::raster::{Draw, Raster};
use super::variant::{EVERY_WAY, Variant, Variants};
use super::{Input, Method, Promise, Voxelizer};
use crate::animate::Vertex;
use crate::gpu::{ComputePass, Gpu, GpuError, GpuStruct, Recorder, buffer};
use crate::grid::Grid;
use crate::papers;
use crate::scene::material::PartMaterial;

const SHADER: &str = "voxelize/slice_amplified.wgsl";

/// Copies that the list holds for each triangle, on average, and the bounds of its size.
const COPIES_PER_TRIANGLE: u32 = 8;
const COPIES_RANGE: (u32, u32) = (1 << 16, 1 << 22);

/// Byte offset of `listed` in the shader's `Draw`.
const LISTED_OFFSET: u64 = 16;

pub(super) const METHOD: Method = Method {
    name: "slice-amplified",
    summary: "every triangle once for each slice it may meet; the paper's own",
    shader: Some(SHADER),
    paper: &papers::CHANG_LAI_2011,
    promise: Promise::Approximate,
    interior: false,
    conservative: EVERY_WAY,
    new: |gpu| Ok(Box::new(SliceAmplified::new(gpu)?)),
};

crate::gpu_struct! {
    /// `Options` in the shader.
    struct Options {
        overlap: f32,
        capacity: u32,
    }
}

#[derive(Debug)]
struct SliceAmplified {
    passes: Variants<(ComputePass, Raster)>,
    options: wgpu::Buffer,
    draw: wgpu::Buffer,
    drawn: wgpu::Buffer,
    lists: Option<Lists>,
}

/// The lists, for up to so many triangles.
#[derive(Debug)]
struct Lists {
    triangle_count: u32,
    capacity: u32,
    copies: wgpu::Buffer,
    rest: wgpu::Buffer,
}

impl SliceAmplified {
    fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let passes = Variants::new(gpu, |gpu, variant: Variant| {
            let layouts = [Grid::LAYOUT, Vertex::LAYOUT, PartMaterial::LAYOUT, Options::LAYOUT];
            let constants = variant.footprint_constants();
            Ok((
                ComputePass::with_constants(gpu, SHADER, "amplify", &layouts, &constants)?,
                Raster::of_footprints(gpu, SHADER, ["slice", "mark"], &layouts, variant, &[])?,
            ))
        })?;
        Ok(Self {
            passes,
            options: buffer::uniform(gpu, "options", &Options { overlap: 0.0, capacity: 0 }),
            draw: buffer::with_usage(gpu, "draw", 24, buffer::STORAGE | wgpu::BufferUsages::INDIRECT)?,
            drawn: buffer::uniform(gpu, "drawn", &[0_u32; 4]),
            lists: None,
        })
    }
}

impl Lists {
    fn new(gpu: &Gpu, triangle_count: u32) -> Result<Self, GpuError> {
        let capacity = triangle_count.saturating_mul(COPIES_PER_TRIANGLE).clamp(COPIES_RANGE.0, COPIES_RANGE.1);
        Ok(Self {
            triangle_count,
            capacity,
            copies: buffer::storage(gpu, "copies", u64::from(capacity) * 8)?,
            rest: buffer::storage(gpu, "rest", u64::from(triangle_count) * 4)?,
        })
    }
}

impl Voxelizer for SliceAmplified {
    fn record(&mut self, rec: &mut Recorder<'_>, input: &Input<'_>) -> Result<(), GpuError> {
        let triangle_count = input.triangles.triangle_count;
        if triangle_count == 0 {
            return Ok(());
        }
        let lists = match &mut self.lists {
            Some(lists) if lists.triangle_count >= triangle_count => lists,
            lists => lists.insert(Lists::new(rec.gpu, triangle_count)?),
        };
        let overlap = input.settings.slice_overlap.clamp(0.0, 1.0);
        // The same for every grid of a frame.
        let options = Options { overlap, capacity: lists.capacity };
        rec.gpu.queue.write_buffer(&self.options, 0, bytemuck::bytes_of(&options));
        rec.encoder.clear_buffer(&self.draw, 0, None);

        let (amplify, raster) = self.passes.get(rec.gpu, Variant::footprint(input))?;
        let mut resources = input.resources().to_vec();
        resources.push(("options", self.options.as_entire_binding()));
        resources.push(("copies", lists.copies.as_entire_binding()));
        resources.push(("rest", lists.rest.as_entire_binding()));
        resources.push(("draw", self.draw.as_entire_binding()));
        let group = amplify.bind(rec.gpu, &resources);
        amplify.dispatch(&mut rec.encoder, &group, [triangle_count, 1, 1]);

        rec.encoder.copy_buffer_to_buffer(&self.draw, LISTED_OFFSET, &self.drawn, 0, 4);
        let mut resources = input.resources().to_vec();
        resources.push(("options", self.options.as_entire_binding()));
        resources.push(("drawn_copies", lists.copies.as_entire_binding()));
        resources.push(("drawn_rest", lists.rest.as_entire_binding()));
        resources.push(("drawn", self.drawn.as_entire_binding()));
        let size = input.volume.grids[input.grid].cells.truncate();
        raster.record(rec, size, &resources, Draw::Indirect(&self.draw));
        Ok(())
    }
}
