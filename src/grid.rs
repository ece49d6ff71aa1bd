//! Voxel cameras: where a grid stands, how it maps world space to cells, how its occupancy is laid out.
//!
//! Shader side: `shaders/lib/grid.inc.wgsl`, which says what grid space is.

mod fit;

use crate::scene::description::{Align, Bounds, Camera, GridSettings, Light, LightKind};
use glam::{DMat3, DMat4, DVec3, Mat4, UVec3};

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

    /// The view's grid, fitted to `bounds` and snapped so that a slow move doesn't shimmer. The text is why it is not
    /// as `settings` ask, if it isn't.
    #[must_use]
    pub fn for_camera(settings: &GridSettings, camera: &Camera, bounds: &Bounds) -> (Self, Option<String>) {
        let forward = (camera.target - camera.eye).as_dvec3();
        let frame = match settings.align {
            Align::World => DMat3::IDENTITY,
            Align::Camera => frame_along(forward, camera.up.as_dvec3()),
        };
        (fit::orthographic(frame, settings.cells, bounds), None)
    }

    /// A light's grids: one, or six where a point light is surrounded by `bounds`.
    #[must_use]
    pub fn for_light(settings: &GridSettings, light: &Light, bounds: &Bounds) -> Vec<Self> {
        let direction = match light.kind {
            LightKind::Directional { direction } | LightKind::Spot { direction, .. } => direction.as_dvec3(),
            LightKind::Point { position } => bounds.center() - position.as_dvec3(),
        };
        vec![fit::orthographic(frame_along(direction, DVec3::Y), settings.cells, bounds)]
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

    /// Words of the whole grid.
    #[must_use]
    pub fn word_count(&self) -> u32 {
        self.cells.x * self.cells.y * self.words_per_column
    }
}

/// `world_from_frame` of a frame whose z runs along `forward` and whose y points against `up` as far as it can.
fn frame_along(forward: DVec3, up: DVec3) -> DMat3 {
    let z = forward.try_normalize().unwrap_or(DVec3::NEG_Z);
    let x = [up, DVec3::Y, DVec3::Z, DVec3::X]
        .into_iter()
        .find_map(|up| up.try_normalize().map(|up| z.cross(up)).filter(|x| x.length() > 1e-3))
        .map_or(DVec3::X, DVec3::normalize);
    DMat3::from_cols(x, z.cross(x), z)
}
