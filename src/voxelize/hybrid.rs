//! Small triangles at once, a thread each; large ones deferred to fragments by one indirect draw.
//!
//! Source: [`papers::RAUWENDAAL_BAILEY_2013`], §3.4 and Fig. 15.
//!
//! | paper                   | here                        | meaning                                            |
//! |-------------------------|-----------------------------|----------------------------------------------------|
//! | area(T), projected      | `projected_area`            | what decides, cells²                               |
//! | cutoff value            | `cutoff_cells2`             | the largest area of a small triangle               |
//! | classification, pass 1  | `triage`                    | marks the small ones, lists the large ones         |
//! | index buffer            | `large`                     | the large ones' numbers                            |
//! | pass 2                  | `outline`, `mark`           | draws the list                                     |
//!
//! Differs: the area is seen along z, which is what either half's time goes with here; see `fragment_parallel`.
//! Promises: exact, 26- or 6-separating. Costs: as `triangle-parallel` on small triangles, as `fragment-parallel` on
//! large ones, and an empty draw when there are none. Figures beside both halves: `docs/measurements.md`.

use super::raster::{Draw, Raster};
use super::variant::{Variant, Variants};
use super::{Input, Method, Promise, Voxelizer};
use crate::animate::Vertex;
use crate::gpu::{ComputePass, Gpu, GpuError, GpuStruct, Recorder, buffer};
use crate::grid::Grid;
use crate::papers;
use crate::scene::material::PartMaterial;

const SHADER: &str = "voxelize/hybrid.wgsl";

/// The cut-off where threads are many and weak: RB §3.4.1 found a few voxels² best on every scene but one.
const HARDWARE_CUTOFF_CELLS2: f32 = 8.0;

/// The cut-off on lavapipe: eight lanes on a few cores. A column costs a thread no more than a fragment, so only a
/// triangle that would keep all but one core waiting is worth a draw.
const SOFTWARE_CUTOFF_CELLS2: f32 = 8192.0;

/// Large triangles that a draw takes; more are marked by threads.
const LIST_CAPACITY: u32 = 1 << 16;

pub(super) const METHOD: Method = Method {
    name: "hybrid",
    summary: "small triangles by threads, large ones by fragments; exact; the default",
    shader: Some(SHADER),
    paper: &papers::RAUWENDAAL_BAILEY_2013,
    promise: Promise::Exact,
    interior: false,
    conservative: &[],
    new: |gpu| Ok(Box::new(Hybrid::new(gpu)?)),
};

crate::gpu_struct! {
    /// `Options` in the shader.
    struct Options {
        cutoff_cells2: f32,
        capacity: u32,
    }
}

#[derive(Debug)]
struct Hybrid {
    halves: Variants<(ComputePass, Raster)>,
    options: wgpu::Buffer,
    large: wgpu::Buffer,
    draw: wgpu::Buffer,
}

impl Hybrid {
    fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let halves = Variants::new(gpu, |gpu, variant: Variant| {
            let layouts = [Grid::LAYOUT, Vertex::LAYOUT, PartMaterial::LAYOUT, Options::LAYOUT];
            let constants = variant.constants();
            Ok((
                ComputePass::with_constants(gpu, SHADER, "triage", &layouts, &constants)?,
                Raster::new(gpu, SHADER, ["outline", "mark"], &layouts, &constants)?,
            ))
        })?;
        let arguments = buffer::STORAGE | wgpu::BufferUsages::INDIRECT;
        Ok(Self {
            halves,
            options: buffer::uniform(gpu, "options", &Options { cutoff_cells2: 0.0, capacity: 0 }),
            large: buffer::storage(gpu, "large", u64::from(LIST_CAPACITY) * 4)?,
            draw: buffer::with_usage(gpu, "draw", 20, arguments)?,
        })
    }
}

impl Voxelizer for Hybrid {
    fn record(&mut self, rec: &mut Recorder<'_>, input: &Input<'_>) -> Result<(), GpuError> {
        let grid = &input.volume.grids[input.grid];
        let (triage, raster) = self.halves.get(rec.gpu, Variant::of(input))?;
        let auto = if rec.gpu.is_software() { SOFTWARE_CUTOFF_CELLS2 } else { HARDWARE_CUTOFF_CELLS2 };
        let cutoff_cells2 = input.settings.cutoff_cells2.unwrap_or(auto);
        let options = Options { cutoff_cells2, capacity: LIST_CAPACITY };
        // The same for every grid of a frame.
        rec.gpu.queue.write_buffer(&self.options, 0, bytemuck::bytes_of(&options));
        rec.encoder.clear_buffer(&self.draw, 0, None);

        let mut resources = input.resources().to_vec();
        resources.push(("options", self.options.as_entire_binding()));
        resources.push(("large", self.large.as_entire_binding()));
        resources.push(("draw", self.draw.as_entire_binding()));
        let group = triage.bind(rec.gpu, &resources);
        triage.dispatch(&mut rec.encoder, &group, [input.triangles.triangle_count, 1, 1]);

        let mut resources = input.resources().to_vec();
        resources.push(("deferred", self.large.as_entire_binding()));
        let draw = Draw::Indirect(&self.draw);
        raster.record(rec, grid.cells.truncate(), &resources, draw);
        Ok(())
    }
}
