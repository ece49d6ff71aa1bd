//! Stage 2: marks the voxels that triangles meet. Every method writes the same occupancy words.
//!
//! A voxelizer is one host file, one shader and one entry in [`METHODS`]. The list feeds the menu, the command line, the
//! docs' table, the tests and the benchmark.

mod boundary;
mod clip;
mod cpu_exact;
mod cutoff;
mod exact_columns;
mod fragment_parallel;
mod hybrid;
mod raster;
mod scan_fill;
mod separating_axes;
mod slice_amplified;
mod slicemap;
mod slicemap_solid;
mod slices;
mod survey;
mod three_axis;
mod triangle_parallel;
mod variant;

pub use cpu_exact::{ExactVoxels, TIE_BAND, exact_voxels, marked_voxels, world_triangles};
pub use cutoff::{Cutoff, CutoffFrom};
pub use three_axis::Sheets;

use crate::animate::Triangles;
use crate::gpu::{Gpu, GpuError, Recorder};
use crate::papers::Paper;
use crate::scene::description::{Conservative, VoxelizerSettings};
use crate::volume::Volume;

/// What a method's set of voxels is worth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Promise {
    /// Equals `cpu-exact` in every voxel, up to ties.
    Exact,
    /// May miss voxels or add some.
    Approximate,
}

/// A voxelizer, as the list knows it.
#[derive(Debug)]
pub struct Method {
    /// Its name everywhere.
    pub name: &'static str,
    /// One line for menus and `murrine list`.
    pub summary: &'static str,
    /// Its shader under `shaders/`, if it has one.
    pub shader: Option<&'static str>,
    /// Where it comes from.
    pub paper: &'static Paper,
    /// What it promises.
    pub promise: Promise,
    /// It writes the volume's `interior` words itself, with `fill = "eager"` at least, so no fill runs after it.
    pub interior: bool,
    /// Which ways of reaching every column it can take, beside [`Conservative::None`]; none if it needs none, because it
    /// solves for every cell that a triangle touches.
    pub conservative: &'static [Conservative],
    /// Compiles it.
    pub new: fn(&Gpu) -> Result<Box<dyn Voxelizer>, GpuError>,
}

/// A compiled voxelizer.
pub trait Voxelizer: std::fmt::Debug + Send {
    /// Marks grid `input.grid` of the volume. Its words are already cleared.
    ///
    /// # Errors
    /// When the device refuses a buffer or is lost.
    fn record(&mut self, rec: &mut Recorder<'_>, input: &Input<'_>) -> Result<(), GpuError>;

    /// Which of the input's triangles count as large, a bit each: of a method that makes a difference. For the eye alone.
    ///
    /// # Errors
    /// As [`Voxelizer::record`].
    fn classes(&mut self, _rec: &mut Recorder<'_>, _input: &Input<'_>) -> Result<Option<&wgpu::Buffer>, GpuError> {
        Ok(None)
    }

    /// The cut-off in use, of a method that has one.
    fn cutoff(&self) -> Option<Cutoff> {
        None
    }

    /// What a frame's marking took, or that of one a little before: for methods that choose their way by it. May change
    /// times to come, never a voxel.
    fn took(&mut self, _ms: f64) {}

    /// The sheet buffers of grid 0 as last marked, of a method that has them.
    fn sheets(&self) -> Option<&Sheets> {
        None
    }
}

/// What a voxelizer works on.
#[derive(Debug, Clone, Copy)]
pub struct Input<'a> {
    /// The volume, whose `occupancy` is written.
    pub volume: &'a Volume,
    /// Which of its grids.
    pub grid: usize,
    /// The animated triangles.
    pub triangles: &'a Triangles,
    /// Options.
    pub settings: &'a VoxelizerSettings,
}

impl<'a> Input<'a> {
    /// What the shaders of most methods bind.
    fn resources(&self) -> [(&'static str, wgpu::BindingResource<'a>); 6] {
        [
            ("grids", self.volume.grid_data.as_entire_binding()),
            ("grid_index", self.volume.grid_index[self.grid].as_entire_binding()),
            ("vertices", self.triangles.vertices.as_entire_binding()),
            ("indices", self.triangles.indices.as_entire_binding()),
            ("materials", self.triangles.materials.as_entire_binding()),
            ("occupancy", self.volume.occupancy.as_entire_binding()),
        ]
    }

    /// As [`Input::resources`], for shaders that write the interior.
    fn interior_resources(&self) -> [(&'static str, wgpu::BindingResource<'a>); 6] {
        let [grids, grid_index, vertices, indices, materials, _] = self.resources();
        [grids, grid_index, vertices, indices, materials, ("interior", self.volume.interior.as_entire_binding())]
    }

    /// Clears the grid's interior words.
    fn clear_interior(&self, rec: &mut Recorder<'_>) {
        let g = &self.volume.grids[self.grid];
        let (first, bytes) = (u64::from(g.word_base) * 4, u64::from(g.word_count()) * 4);
        rec.encoder.clear_buffer(&self.volume.interior, first, Some(bytes));
    }
}

/// All methods, in the order of the menu.
pub const METHODS: &[Method] = &[
    hybrid::METHOD,
    triangle_parallel::METHOD,
    fragment_parallel::METHOD,
    exact_columns::METHOD,
    slice_amplified::METHOD,
    slices::METHOD,
    slicemap::METHOD,
    slicemap_solid::METHOD,
    three_axis::METHOD,
    cpu_exact::METHOD,
];

/// Whether the method scans whole columns for the interior, so that a slab of a grid will not do.
#[must_use]
pub fn scans_whole_columns(method: &Method) -> bool {
    method.name == three_axis::METHOD.name
}

/// The method of this name.
///
/// # Errors
/// When there is none; the error lists those there are.
pub fn method(name: &str) -> Result<&'static Method, GpuError> {
    METHODS.iter().find(|m| m.name == name).ok_or_else(|| GpuError::Unknown {
        what: "voxelizer",
        name: name.to_owned(),
        known: METHODS.iter().map(|m| m.name).collect::<Vec<_>>().join(", "),
    })
}
