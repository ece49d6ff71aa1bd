//! Small triangles at once, a thread each; large ones deferred to fragments by one indirect draw.
//!
//! Source: [`papers::RAUWENDAAL_BAILEY_2013`], §3.4 and Figs. 12 and 15.
//!
//! | paper                          | here                        | meaning                                       |
//! |--------------------------------|-----------------------------|-----------------------------------------------|
//! | area(T), projected             | `size_measure = "area"`     | what decides, cells²; the one that RB chose   |
//! | area(T′)                       | `"dilated-area"`            | of what is rasterized, cells²                 |
//! | 2D-projected voxel-extents     | `"extent-2d"`               | columns of the triangle's box                 |
//! | 3D voxel-extents               | `"extent-3d"`               | cells of its box                              |
//! | area(T) / area(T′)             | `"area-ratio"`              | 0 for small triangles, 1 for large ones       |
//! | cutoff value                   | `cutoff_cells2`             | the largest size of a small triangle          |
//! | classification, Fig. 12        | `classify`, `mark_small`    | two lists first, then both are worked off     |
//! | pass 1, Fig. 15 (§3.4.2)       | `triage`                    | marks the small ones, lists the large ones    |
//! | index buffers                  | `large`, `small`            | triangles' numbers                            |
//! | pass 2                         | `outline`, `mark`           | draws the list                                |
//!
//! Differs: sizes are seen along z, which is what either half's time goes with here; see `fragment_parallel`. Where RB
//! compares another measure than the area, an automatic cut-off is that of a triangle of equal sides.
//! Promises: exact, 26- or 6-separating, whatever the cut-off. Costs: as `triangle-parallel` on small triangles, as
//! `fragment-parallel` on large ones, and an empty draw when there are none. Figures beside both halves:
//! `docs/measurements.md`.

use super::cutoff::{self, Costs, Search};
use super::raster::{Draw, Raster};
use super::survey::Survey;
use super::variant::{Variant, Variants};
use super::{Cutoff, CutoffFrom, Input, Method, Promise, Voxelizer};
use crate::animate::Vertex;
use crate::gpu::{ComputePass, Gpu, GpuError, GpuStruct, Recorder, buffer, pass};
use crate::grid::Grid;
use crate::papers;
use crate::scene::description::{Classify, SizeMeasure};
use crate::scene::material::PartMaterial;

pub(super) const SHADER: &str = "voxelize/hybrid.wgsl";

/// Byte offset of `count` in the shader's `Dispatch`.
const COUNT_OFFSET: u64 = 12;

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
        cutoff: f32,
    }
}

/// The compute passes, by entry point and variant, compiled when they are first asked for.
#[derive(Debug, Default)]
struct Passes(pass::Variants<(&'static str, Variant, SizeMeasure)>);

impl Passes {
    fn get(&mut self, gpu: &Gpu, entry: &'static str, key: (Variant, SizeMeasure)) -> Result<&ComputePass, GpuError> {
        self.0.pass((entry, key.0, key.1), |(entry, variant, measure)| {
            let layouts = [Grid::LAYOUT, Vertex::LAYOUT, PartMaterial::LAYOUT, Options::LAYOUT];
            let [thin, perspective] = variant.constants();
            let constants = [thin, perspective, ("size_measure", f64::from(*measure as u8))];
            ComputePass::with_constants(gpu, SHADER, entry, &layouts, &constants)
        })
    }

    /// Runs an entry point with a thread for each of the input's triangles.
    fn run(
        &mut self,
        rec: &mut Recorder<'_>,
        entry: &'static str,
        input: &Input<'_>,
        resources: &[(&str, wgpu::BindingResource<'_>)],
    ) -> Result<(), GpuError> {
        let pass = self.get(rec.gpu, entry, key_of(input))?;
        let group = pass.bind_used(rec.gpu, resources);
        pass.dispatch(&mut rec.encoder, &group, [input.triangles.triangle_count, 1, 1]);
        Ok(())
    }
}

fn key_of(input: &Input<'_>) -> (Variant, SizeMeasure) {
    (Variant::of(input), input.settings.size_measure)
}

#[derive(Debug)]
struct Hybrid {
    passes: Passes,
    rasters: Variants<Raster>,
    options: wgpu::Buffer,
    draw: wgpu::Buffer,
    small_dispatch: wgpu::Buffer,
    listed_count: wgpu::Buffer,
    lists: Option<Lists>,
    auto: Auto,
    /// What the last grid was marked with.
    used: Cutoff,
}

/// The lists, for up to so many triangles.
#[derive(Debug)]
struct Lists {
    triangle_count: u32,
    large: wgpu::Buffer,
    small: wgpu::Buffer,
    classes: wgpu::Buffer,
}

impl Lists {
    fn new(gpu: &Gpu, triangle_count: u32) -> Result<Self, GpuError> {
        let bytes = u64::from(triangle_count) * 4;
        Ok(Self {
            triangle_count,
            large: buffer::storage(gpu, "large", bytes)?,
            small: buffer::storage(gpu, "small", bytes)?,
            classes: buffer::storage(gpu, "classes", bytes.div_ceil(32))?,
        })
    }
}

/// The cut-off that is found without being asked for.
#[derive(Debug)]
struct Auto {
    costs: &'static Costs,
    survey: Survey,
    /// The triangles and the resolution that the rest is for.
    found_for: Option<(u32, u32)>,
    search: Option<Search>,
    is_measured: bool,
}

impl Auto {
    fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let costs = if gpu.is_software() { &cutoff::SOFTWARE } else { &cutoff::HARDWARE };
        Ok(Self { costs, survey: Survey::new(gpu)?, found_for: None, search: None, is_measured: false })
    }

    /// The cut-off for the view's grid; asks for the triangles' sizes where they are not known.
    fn now(&mut self, rec: &mut Recorder<'_>, input: &Input<'_>, passes: &mut Passes) -> Result<Cutoff, GpuError> {
        let key = (input.triangles.triangle_count, input.volume.grids[input.grid].cells.max_element());
        if let Some(sizes) = self.survey.arrived(rec.gpu) {
            self.search = Some(Search::from(cutoff::octave_for(&sizes, self.costs)));
            self.is_measured = false;
        }
        if self.found_for != Some(key) && !self.survey.is_pending() {
            self.survey.ask(rec, input, passes.get(rec.gpu, "survey", key_of(input))?);
            (self.found_for, self.search) = (Some(key), None);
        }
        Ok(self.latest())
    }

    fn latest(&self) -> Cutoff {
        let Some(search) = &self.search else {
            #[expect(clippy::cast_possible_truncation, reason = "a constant of a few digits")]
            return Cutoff { cells2: self.costs.cutoff_cells2 as f32, from: CutoffFrom::Device };
        };
        let from = match (self.is_measured, search.is_settled()) {
            (false, _) => CutoffFrom::Sizes,
            (true, false) => CutoffFrom::Search,
            (true, true) => CutoffFrom::Times,
        };
        #[expect(clippy::cast_precision_loss, reason = "an octave")]
        let cells2 = f32::exp2(search.octave() as f32);
        Cutoff { cells2, from }
    }
}

/// The size by a measure of a triangle of equal sides whose area is given, cells².
fn in_unit_of(measure: SizeMeasure, area: f32) -> f32 {
    // Half the side; l·P / 2A of it, with l half of a pixel's diagonal.
    let side = (area * 4.0 / 3.0_f32.sqrt()).sqrt();
    let dilated = (area.sqrt() + std::f32::consts::FRAC_1_SQRT_2 * 1.5 * side / area.max(1e-20).sqrt()).powi(2);
    let spanned = side + 1.0;
    match measure {
        SizeMeasure::Area => area,
        SizeMeasure::DilatedArea => dilated,
        SizeMeasure::Extent2d => spanned * spanned,
        SizeMeasure::Extent3d => spanned * spanned * spanned,
        SizeMeasure::AreaRatio => area / dilated.max(1e-20),
    }
}

impl Hybrid {
    fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let mut passes = Passes::default();
        // At once, so that a faulty shader is told at once.
        passes.get(gpu, "triage", Default::default())?;
        let rasters = Variants::new(gpu, |gpu, variant: Variant| {
            let layouts = [Grid::LAYOUT, Vertex::LAYOUT, PartMaterial::LAYOUT, Options::LAYOUT];
            Raster::new(gpu, SHADER, ["outline", "mark"], &layouts, &variant.constants())
        })?;
        let arguments = buffer::STORAGE | wgpu::BufferUsages::INDIRECT;
        let auto = Auto::new(gpu)?;
        Ok(Self {
            passes,
            rasters,
            options: buffer::uniform(gpu, "options", &Options { cutoff: 0.0 }),
            draw: buffer::with_usage(gpu, "draw", 16, arguments)?,
            small_dispatch: buffer::with_usage(gpu, "small_dispatch", 16, arguments)?,
            listed_count: buffer::uniform(gpu, "listed_count", &[0_u32; 4]),
            lists: None,
            used: auto.latest(),
            auto,
        })
    }

    /// Finds the cut-off for this grid and tells the device.
    fn begin(&mut self, rec: &mut Recorder<'_>, input: &Input<'_>) -> Result<(), GpuError> {
        let measure = input.settings.size_measure;
        let cutoff = match input.settings.cutoff_cells2 {
            Some(cells2) => {
                self.used = Cutoff { cells2, from: CutoffFrom::Scene };
                cells2
            }
            // One for all grids of a frame.
            None => {
                self.used =
                    if input.grid == 0 { self.auto.now(rec, input, &mut self.passes)? } else { self.auto.latest() };
                in_unit_of(measure, self.used.cells2)
            }
        };
        // The same for every grid of a frame.
        rec.gpu.queue.write_buffer(&self.options, 0, bytemuck::bytes_of(&Options { cutoff }));
        let triangle_count = input.triangles.triangle_count;
        if self.lists.as_ref().is_none_or(|lists| lists.triangle_count < triangle_count) {
            self.lists = Some(Lists::new(rec.gpu, triangle_count)?);
        }
        Ok(())
    }
}

impl Voxelizer for Hybrid {
    fn record(&mut self, rec: &mut Recorder<'_>, input: &Input<'_>) -> Result<(), GpuError> {
        self.begin(rec, input)?;
        let Some(lists) = &self.lists else { return Ok(()) };
        rec.encoder.clear_buffer(&self.draw, 0, None);
        let mut all = input.resources().to_vec();
        all.push(("options", self.options.as_entire_binding()));
        all.push(("large", lists.large.as_entire_binding()));
        all.push(("draw", self.draw.as_entire_binding()));
        all.push(("deferred", lists.large.as_entire_binding()));
        all.push(("small", lists.small.as_entire_binding()));
        all.push(("small_dispatch", self.small_dispatch.as_entire_binding()));
        all.push(("listed", lists.small.as_entire_binding()));
        all.push(("listed_count", self.listed_count.as_entire_binding()));
        match input.settings.classify {
            Classify::OnTheFly => self.passes.run(rec, "triage", input, &all)?,
            Classify::First => {
                rec.encoder.clear_buffer(&self.small_dispatch, 0, None);
                self.passes.run(rec, "classify", input, &all)?;
                rec.encoder.copy_buffer_to_buffer(&self.small_dispatch, COUNT_OFFSET, &self.listed_count, 0, 4);
                let pass = self.passes.get(rec.gpu, "mark_small", key_of(input))?;
                let group = pass.bind_used(rec.gpu, &all);
                pass.dispatch_indirect(&mut rec.encoder, &group, &self.small_dispatch, 0);
            }
        }
        let raster = self.rasters.get(rec.gpu, Variant::of(input))?;
        raster.record(rec, input.volume.grids[input.grid].cells.truncate(), &all, Draw::Indirect(&self.draw));
        Ok(())
    }

    fn classes(&mut self, rec: &mut Recorder<'_>, input: &Input<'_>) -> Result<Option<&wgpu::Buffer>, GpuError> {
        self.begin(rec, input)?;
        let Some(lists) = &self.lists else { return Ok(None) };
        rec.encoder.clear_buffer(&lists.classes, 0, None);
        let mut resources = input.resources().to_vec();
        resources.push(("options", self.options.as_entire_binding()));
        resources.push(("classes", lists.classes.as_entire_binding()));
        self.passes.run(rec, "show_classes", input, &resources)?;
        Ok(Some(&lists.classes))
    }

    fn cutoff(&self) -> Option<Cutoff> {
        Some(self.used)
    }

    fn took(&mut self, ms: f64) {
        if let Some(search) = self.auto.search.as_mut().filter(|_| self.used.from != CutoffFrom::Scene) {
            self.auto.is_measured = true;
            search.take(ms);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cut_off_in_any_unit_parts_triangles_of_equal_sides_alike() {
        let measures = [
            SizeMeasure::Area,
            SizeMeasure::DilatedArea,
            SizeMeasure::Extent2d,
            SizeMeasure::Extent3d,
            SizeMeasure::AreaRatio,
        ];
        for measure in measures {
            let sizes: Vec<f32> = [0.25, 1.0, 8.0, 100.0, 8192.0].map(|area| in_unit_of(measure, area)).to_vec();
            assert!(sizes.is_sorted_by(|a, b| a < b), "{measure:?}: {sizes:?}");
        }
        // RB's T′ of a triangle of side 2: sides moved out by l, so 1 + l / r times as long, r = 1/√3.
        let larger = (1.0 + std::f32::consts::FRAC_1_SQRT_2 * 3.0_f32.sqrt()).powi(2);
        let area = 3.0_f32.sqrt();
        assert!((in_unit_of(SizeMeasure::DilatedArea, area) / (area * larger) - 1.0).abs() < 1e-5);
        assert!((in_unit_of(SizeMeasure::AreaRatio, area) * larger - 1.0).abs() < 1e-5);
    }
}
