//! Fits grids to bounds and snaps them, so that a slow move shifts a picture by whole cells or not at all.
//!
//! A cell's size is one of 2^(k/8) world units and the origin a whole number of cells from the world's, in the grid's own
//! frame: a pure function of the current bounds, without history.

use super::Grid;
use crate::scene::description::{Bounds, Cells};
use glam::{DMat3, DMat4, DVec3, UVec3};

/// Steps of cell size from one power of two to the next.
const STEPS_PER_OCTAVE: f64 = 8.0;

/// Cells of an axis that the body never fills: a margin of one at each end, and one that snapping the origin takes.
const SPARE_CELLS: f64 = 3.0;

/// Fewest and most cells along an axis.
const CELLS_RANGE: (u32, u32) = (16, 512);

/// The shorter axes of a grid of cubes are rounded up to this many cells, so that a moving body seldom changes them.
const CELLS_STEP: u32 = 8;

/// An orthographic grid turned to `world_from_frame`, a rotation.
pub(super) fn orthographic(world_from_frame: DMat3, cells: Cells, bounds: &Bounds) -> Grid {
    let bounds = usable(bounds);
    let frame_from_world = world_from_frame.transpose();
    let mut lo = DVec3::INFINITY;
    let mut hi = DVec3::NEG_INFINITY;
    for corner in bounds.corners() {
        lo = lo.min(frame_from_world * corner);
        hi = hi.max(frame_from_world * corner);
    }
    let extent = hi - lo;
    let (cell_size, cells) = match cells {
        Cells::Longest(longest) => {
            let longest = longest.clamp(CELLS_RANGE.0, CELLS_RANGE.1);
            let cell_size = snapped_up(extent.max_element() / (f64::from(longest) - SPARE_CELLS));
            let along = |extent: f64| whole(extent / cell_size + SPARE_CELLS).next_multiple_of(CELLS_STEP);
            let shorter = UVec3::from_array(extent.to_array().map(along));
            let cells = shorter.clamp(UVec3::splat(CELLS_RANGE.0), UVec3::splat(longest));
            let is_longest = extent.cmpge(DVec3::splat(extent.max_element()));
            (cell_size, UVec3::select(is_longest, UVec3::splat(longest), cells))
        }
        Cells::Each(cells) => {
            let cells = cells.clamp(UVec3::splat(CELLS_RANGE.0), UVec3::splat(CELLS_RANGE.1));
            (snapped_up((extent / (cells.as_dvec3() - SPARE_CELLS)).max_element()), cells)
        }
    };
    let origin_cells = ((lo + hi) * 0.5 / cell_size - cells.as_dvec3() * 0.5).round();
    let world_from_grid = DMat4::from_mat3(world_from_frame)
        * DMat4::from_scale(DVec3::splat(cell_size))
        * DMat4::from_translation(origin_cells);
    Grid::orthographic(world_from_grid, cell_size, cells)
}

/// The least step of cell size that is not below `size`.
fn snapped_up(size: f64) -> f64 {
    // The slack keeps a size that is a step already, up to rounding, from going one further.
    ((size.log2() * STEPS_PER_OCTAVE - 1e-9).ceil() / STEPS_PER_OCTAVE).exp2()
}

/// Bounds that a grid can stand on: finite, not empty, and large enough for f32 to tell their cells apart.
fn usable(bounds: &Bounds) -> Bounds {
    const FARTHEST: f64 = 1e12;
    let whole = bounds.min.is_finite() && bounds.max.is_finite() && !bounds.is_empty();
    let (min, max) = if whole { (bounds.min, bounds.max) } else { (DVec3::splat(-0.5), DVec3::splat(0.5)) };
    let (min, max) = (
        min.clamp(DVec3::splat(-FARTHEST), DVec3::splat(FARTHEST)),
        max.clamp(DVec3::splat(-FARTHEST), DVec3::splat(FARTHEST)),
    );
    let center = (min + max) * 0.5;
    let least = (center.abs().max_element() * 1e-5).max(1e-6);
    let half = ((max - min) * 0.5).max(DVec3::splat(0.5 * least));
    Bounds { min: center - half, max: center + half }
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to what fits")]
fn whole(cells: f64) -> u32 {
    cells.ceil().clamp(0.0, 1e6) as u32
}
