//! Voxel cameras: where a grid stands, how it maps world space to cells, how its occupancy is laid out.
//!
//! Shader side: `shaders/lib/grid.inc.wgsl`, which says what grid space is.

mod fit;
mod slabs;

pub use slabs::Slab;

use glam::{DMat4, DVec2, DVec3, DVec4, Mat4, UVec3};

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
    pub fn world_aligned(origin: DVec3, cell_size: f64, cells: UVec3) -> Self {
        let world_from_grid = DMat4::from_translation(origin) * DMat4::from_scale(DVec3::splat(cell_size));
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

    /// A perspective grid: its columns meet in the eye, the origin of `world_from_eye`, a rigid frame whose z looks into
    /// the grid. Columns fill the rectangle `tangent_min` … `tangent_max` of (x/z, y/z), slices the eye depths `near` …
    /// `far` evenly. `cell_size` is that of a middle cell, for what must know a length.
    #[must_use]
    pub fn perspective(
        world_from_eye: DMat4,
        tangent_min: DVec2,
        tangent_max: DVec2,
        near: f32,
        far: f32,
        cells: UVec3,
    ) -> Self {
        let (near_depth, far_depth) = (f64::from(near), f64::from(far));
        let n = cells.as_dvec3();
        let columns = n.truncate() / (tangent_max - tangent_min);
        let depth = n.z * far_depth / (far_depth - near_depth);
        // x = columns.x · (x_eye / z_eye − tangent_min.x), z = depth · (1 − near / z_eye), w = z_eye.
        let grid_from_eye = DMat4::from_cols(
            DVec4::new(columns.x, 0.0, 0.0, 0.0),
            DVec4::new(0.0, columns.y, 0.0, 0.0),
            DVec4::new(-columns.x * tangent_min.x, -columns.y * tangent_min.y, depth, 1.0),
            DVec4::new(0.0, 0.0, -depth * near_depth, 0.0),
        );
        let grid_from_world = grid_from_eye * world_from_eye.inverse();
        let across = 0.5 * (near_depth + far_depth) / columns;
        let cell_size = (across.x * across.y * (far_depth - near_depth) / n.z).cbrt();
        #[expect(clippy::cast_possible_truncation, reason = "shaders work in f32")]
        let cell_size = cell_size as f32;
        Self {
            grid_from_world: grid_from_world.as_mat4(),
            world_from_grid: (world_from_eye * grid_from_eye.inverse()).as_mat4(),
            projection: PERSPECTIVE,
            cell_size,
            near,
            far,
            ..Self::orthographic(DMat4::IDENTITY, 1.0, cells)
        }
    }

    /// Grid-space position of a world point; nothing to go by where a perspective grid's eye depth is not positive.
    #[must_use]
    pub fn grid_point(&self, p_world: DVec3) -> DVec3 {
        self.grid_from_world.as_dmat4().project_point3(p_world)
    }

    /// World position of a grid-space point.
    #[must_use]
    pub fn world_point(&self, p_grid: DVec3) -> DVec3 {
        self.world_from_grid.as_dmat4().project_point3(p_grid)
    }

    /// Grid-space z of the boundary below slice `k`; `slab(cells.z)` is the far end.
    #[must_use]
    pub fn slab(&self, k: f64) -> f64 {
        if self.projection == ORTHOGRAPHIC {
            return k;
        }
        let (near, far, n) = (f64::from(self.near), f64::from(self.far), f64::from(self.cells.z));
        let depth = near + k * (far - near) / n;
        n * far / (far - near) * (1.0 - near / depth)
    }

    /// The slice (fractional, not clamped) that grid-space `z` lies in: the inverse of [`Grid::slab`].
    #[must_use]
    pub fn slice_of(&self, z: f64) -> f64 {
        if self.projection == ORTHOGRAPHIC {
            return z;
        }
        let (near, far, n) = (f64::from(self.near), f64::from(self.far), f64::from(self.cells.z));
        let depth = near / (1.0 - z * (far - near) / (n * far));
        (depth - near) * n / (far - near)
    }

    /// Index of the word of cell (x, y, z) within the grid.
    #[must_use]
    pub fn word_of(&self, [x, y, z]: [u32; 3]) -> usize {
        ((y * self.cells.x + x) * self.words_per_column + (z >> 5)) as usize
    }

    /// One byte a cell, 1 where its bit is set, in the order [z][y][x], from the grid's own words.
    #[must_use]
    pub fn cell_bytes(&self, words: &[u32]) -> Vec<u8> {
        Slab { grid: *self, slices: 0..self.cells.z, skipped: 0 }.cell_bytes(words).flatten().collect()
    }

    /// Words of the whole grid.
    #[must_use]
    pub fn word_count(&self) -> u32 {
        self.cells.x * self.cells.y * self.words_per_column
    }
}
