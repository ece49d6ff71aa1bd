//! Where the laboratory measures: which grid, from where, of what shape.

use crate::grid::Grid;
use glam::{DMat3, DMat4, DVec3, UVec3, Vec3};

/// How much wider than the body a grid is, so that no surface lies on its rim.
const RIM: f64 = 1.0 + 1e-4;
/// Of a turn, between one direction and the next (the golden angle): they never line up.
const GOLDEN_RAD: f64 = 2.399_963_229_728_653;

/// What a station is compared with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Series {
    /// Cubes of other sizes, all along the world's axes.
    Grid,
    /// Cubes of one size seen from elsewhere: which direction, of how many.
    Angle(u32, u32),
    /// Grids along the world's axes whose cells are no cubes.
    Aspect,
}

/// One grid that every method marks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Station {
    /// What it is compared with.
    pub series: Series,
    /// Resolution.
    pub cells: UVec3,
}

impl Station {
    /// A grid of a series.
    #[must_use]
    pub fn new(series: Series, cells: UVec3) -> Self {
        Self { series, cells }
    }

    /// Such as `64³` or `64×64×256`, and from where.
    #[must_use]
    pub fn name(&self) -> String {
        let UVec3 { x, y, z } = self.cells;
        let cells = if x == y && y == z { format!("{x}³") } else { format!("{x}×{y}×{z}") };
        match self.series {
            Series::Grid | Series::Aspect => cells,
            Series::Angle(..) => format!("{cells} angle {}°", self.angle_deg().round()),
        }
    }

    /// Between the columns and the z axis, degrees.
    #[must_use]
    pub fn angle_deg(&self) -> f64 {
        self.columns().z.clamp(-1.0, 1.0).acos().to_degrees()
    }

    /// Along the columns, unit: spread evenly over half a sphere, from the z axis to the rim.
    fn columns(&self) -> DVec3 {
        match self.series {
            Series::Grid | Series::Aspect => DVec3::Z,
            Series::Angle(index, count) => {
                let z = 1.0 - f64::from(index) / f64::from(count.max(1));
                let (sin, cos) = (GOLDEN_RAD * f64::from(index)).sin_cos();
                let across = (1.0 - z * z).max(0.0).sqrt();
                DVec3::new(across * cos, across * sin, z)
            }
        }
    }

    /// The grid over the bounding cube of a body, turned so that its columns run as the station says.
    #[must_use]
    pub fn grid(&self, world_triangles: &[[Vec3; 3]]) -> Grid {
        let world_from_frame = match self.series {
            Series::Grid | Series::Aspect => DMat3::IDENTITY,
            Series::Angle(..) => {
                let (x, y) = self.columns().any_orthonormal_pair();
                DMat3::from_cols(x, y, self.columns())
            }
        };
        let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for point in world_triangles.iter().flatten() {
            let p = world_from_frame.transpose() * point.as_dvec3();
            (min, max) = (min.min(p), max.max(p));
        }
        if !(min.is_finite() && max.is_finite()) {
            (min, max) = (DVec3::ZERO, DVec3::ONE);
        }
        let side = ((max - min).max_element() * RIM).max(1e-9);
        let cell = DVec3::splat(side) / self.cells.as_dvec3();
        let origin = (min + max) * 0.5 - side * 0.5;
        let world_from_grid =
            DMat4::from_mat3(world_from_frame) * DMat4::from_translation(origin) * DMat4::from_scale(cell);
        Grid::orthographic(world_from_grid, cell.element_product().cbrt(), self.cells)
    }
}

/// Cells in these proportions, `cells` along each axis on average.
pub(super) fn stretched(cells: u32, aspect: UVec3) -> UVec3 {
    let aspect = aspect.max(UVec3::ONE).as_dvec3();
    let unit = f64::from(cells) / aspect.element_product().cbrt();
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to what a grid takes")]
    let whole = |n: f64| (n * unit).round().clamp(1.0, 512.0) as u32;
    UVec3::from_array(aspect.to_array().map(whole))
}
