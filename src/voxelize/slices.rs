//! One pass a slice: all triangles, clipped to the slice, rendered into it.
//!
//! Source: [`papers::FANG_CHEN_2000`] and Llamas 2007, the "Grid" of CL Table 1 and §4.
//!
//! | paper                   | here                       | meaning                                                   |
//! |-------------------------|----------------------------|-----------------------------------------------------------|
//! | slice k                 | `slice`                    | one layer of cells, one pass                              |
//! | near and far planes     | `slab` k and k + 1         | what of a triangle belongs to it                          |
//! | XOR in the frame buffer | `toggle`, then `carry`     | the parity of the surfaces before, from slice to slice    |
//!
//! Differs: a pass writes a bit of each column's word, not a layer of a texture. Triangles beyond the planes are left out
//! by the vertex shader; where one is cut, the fragment decides by its depth: a clipper's new corners are rounded, and
//! parity would leak at them. The interior is taken at the cells' centres: its planes stand half a cell nearer.
//! Promises: approximate. A cell is marked where its column's middle line meets the surface, or with `conservative` where
//! the column does, at the depth of the middle line unless `conservative_depth`. The interior, with `fill = "eager"`, is
//! right for closed meshes; its passes are never conservative. `separability` does not count.
//! Costs: every triangle's vertices for every slice. This is what CL set out to beat: the slow baseline.

use super::raster::{Draw, Raster};
use super::variant::{EVERY_WAY, Variant, Variants};
use super::{Input, Method, Promise, Voxelizer};
use crate::animate::Vertex;
use crate::gpu::{Gpu, GpuError, GpuStruct, Recorder};
use crate::grid::Grid;
use crate::papers;
use crate::scene::description::Fill;
use crate::scene::material::PartMaterial;

const SHADER: &str = "voxelize/slices.wgsl";

/// Vertices of the triangle that covers the whole raster.
const WHOLE_VERTICES: u32 = 3;

/// From a cell's centre to its near end, slices.
const CENTER: f64 = 0.5;

pub(super) const METHOD: Method = Method {
    name: "slices",
    summary: "one pass a slice, its interior by parity from slice to slice; slow",
    shader: Some(SHADER),
    paper: &papers::FANG_CHEN_2000,
    promise: Promise::Approximate,
    interior: true,
    conservative: EVERY_WAY,
    new: |gpu| Ok(Box::new(Slices::new(gpu)?)),
};

#[derive(Debug)]
struct Slices {
    marks: Variants<Raster>,
    toggles: Variants<(Raster, Raster)>,
}

impl Slices {
    fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let marks = |gpu: &Gpu, variant| raster(gpu, ["slab_of", "mark"], variant, 0.0);
        let toggles = |gpu: &Gpu, variant| {
            let toggle = raster(gpu, ["slab_of", "toggle"], variant, CENTER)?;
            Ok((toggle, raster(gpu, ["whole", "carry"], variant, CENTER)?))
        };
        Ok(Self { marks: Variants::new(gpu, marks)?, toggles: Variants::new(gpu, toggles)? })
    }
}

/// Compiles two entry points, with slabs that begin so many slices nearer.
fn raster(gpu: &Gpu, entries: [&str; 2], variant: Variant, nearer_slices: f64) -> Result<Raster, GpuError> {
    let layouts = [Grid::LAYOUT, Vertex::LAYOUT, PartMaterial::LAYOUT];
    Raster::of_footprints(gpu, SHADER, entries, &layouts, variant, &[("nearer_slices", nearer_slices)])
}

impl Voxelizer for Slices {
    fn record(&mut self, rec: &mut Recorder<'_>, input: &Input<'_>) -> Result<(), GpuError> {
        let cells = input.volume.grids[input.grid].cells;
        let size = cells.truncate();
        let draw = |variant: Variant, slice| Draw::Slice {
            vertices: input.triangles.triangle_count * variant.footprint_vertices(),
            instances: variant.pieces(),
            slice,
        };
        let variant = Variant::footprint(input);
        let mark = self.marks.get(rec.gpu, variant)?;
        for slice in 0..cells.z {
            mark.record(rec, size, &input.resources(), draw(variant, slice));
        }
        if input.settings.fill != Fill::Eager {
            return Ok(());
        }
        input.clear_interior(rec);
        let variant = Variant::plain(input);
        let (toggle, carry) = self.toggles.get(rec.gpu, variant)?;
        for slice in 0..cells.z {
            toggle.record(rec, size, &input.interior_resources(), draw(variant, slice));
            if slice > 0 {
                let whole = Draw::Slice { vertices: WHOLE_VERTICES, instances: variant.pieces(), slice };
                carry.record(rec, size, &input.interior_resources(), whole);
            }
        }
        Ok(())
    }
}
