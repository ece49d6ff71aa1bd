//! Fits grids to bounds and snaps them, so that a slow move shifts a picture by whole cells or not at all.
//!
//! A cell's size is one of 2^(k/8) and the origin a whole number of cells from the frame's: a pure function of the current
//! bounds, without history. An orthographic frame is the world's, turned; a perspective one stands in the eye, and there
//! the slopes x/z and y/z and the depth z are what is snapped.

use super::Grid;
use crate::scene::description::{Align, Bounds, CELLS, Camera, Cells, GridSettings, Light, LightKind, Projection};
use glam::{BVec3, DMat3, DMat4, DVec2, DVec3, UVec3};

/// Steps of cell size from one power of two to the next.
const STEPS_PER_OCTAVE: f64 = 8.0;

/// Cells of an axis that the body never fills: a margin of one at each end, and one that snapping the origin takes.
const SPARE_CELLS: f64 = 3.0;

/// Fewest and most cells along an axis.
const CELLS_RANGE: (u32, u32) = (*CELLS.start(), *CELLS.end());

/// The shorter axes of a grid of cubes are rounded up to this many cells, so that a moving body seldom changes them.
const CELLS_STEP: u32 = 8;

/// A perspective grid's least near depth, as a fraction of its far one: cells beside the eye would be too fine to tell
/// apart, and the far ones too coarse.
const LEAST_NEAR: f64 = 1.0 / 64.0;

/// The steepest slope x/z or y/z of a column, 75° off the axis.
const STEEPEST: f64 = 3.75;

impl Grid {
    /// The view's grid, fitted to `bounds` and snapped so that a slow move doesn't shimmer. The text is why it is not
    /// as `settings` ask, if it isn't.
    ///
    /// A perspective grid needs the eye outside the bounds and all of them before it, within 75° of the way it looks.
    #[must_use]
    pub fn for_camera(settings: &GridSettings, camera: &Camera, bounds: &Bounds) -> (Self, Option<String>) {
        let forward = (camera.target - camera.eye).as_dvec3();
        let frame = match settings.align {
            Align::World => DMat3::IDENTITY,
            Align::Camera => frame_along(forward, camera.up.as_dvec3()),
        };
        if settings.projection == Projection::Orthographic {
            return (orthographic(frame, settings.cells, bounds), None);
        }
        let eye = camera.eye.as_dvec3();
        let eye_frame = match settings.align {
            Align::World => axis_frame(usable(bounds).center() - eye),
            Align::Camera => frame,
        };
        match seen_from(eye, eye_frame, bounds).and_then(|seen| perspective(eye, eye_frame, settings.cells, seen)) {
            Some(grid) => (grid, None),
            None => (
                orthographic(frame, settings.cells, bounds),
                Some("the view's grid is orthographic: a perspective one needs every body before the camera, and not at its lens; move back or set grid.projection".to_owned()),
            ),
        }
    }

    /// A light's grids: one, or six where a point light is too near to `bounds` for one. Columns always run along the
    /// light: of `settings` only the resolution counts.
    #[must_use]
    pub fn for_light(settings: &GridSettings, light: &Light, bounds: &Bounds) -> Vec<Self> {
        let cells = settings.cells;
        match light.kind {
            LightKind::Directional { direction } => {
                vec![orthographic(frame_along(direction.as_dvec3(), DVec3::Y), cells, bounds)]
            }
            LightKind::Spot { position, direction, angle_deg, .. } => {
                let frame = frame_along(direction.as_dvec3(), DVec3::Y);
                let steepest = f64::from(angle_deg).to_radians().clamp(0.01, STEEPEST.atan()).tan();
                let seen = seen_in_cone(position.as_dvec3(), frame, steepest, bounds);
                let grid = seen.and_then(|seen| perspective(position.as_dvec3(), frame, cells, seen));
                vec![grid.unwrap_or_else(|| orthographic(frame, cells, bounds))]
            }
            LightKind::Point { position } => {
                let eye = position.as_dvec3();
                // Along an axis of the world, not to the body's middle, so that a moving body doesn't turn the grid.
                let frame = axis_frame(usable(bounds).center() - eye);
                let one = seen_from(eye, frame, bounds).and_then(|seen| perspective(eye, frame, cells, seen));
                one.map_or_else(|| around(eye, cells, bounds), |grid| vec![grid])
            }
        }
    }
}

/// An orthographic grid turned to `world_from_frame`, a rotation.
fn orthographic(world_from_frame: DMat3, cells: Cells, bounds: &Bounds) -> Grid {
    let bounds = usable(bounds);
    let frame_from_world = world_from_frame.transpose();
    let (lo, hi) = span(bounds.corners().map(|corner| frame_from_world * corner));
    let extent = hi - lo;
    let longest = extent.max_element();
    let (cell_size, cells) = match cells {
        Cells::Longest(count) => {
            let cell_size = snapped_up(longest / (in_range(count) - SPARE_CELLS));
            (cell_size, cells_along(extent / cell_size, extent.cmpge(DVec3::splat(longest)), count))
        }
        Cells::Each(each) => {
            let each = UVec3::from_array(each.to_array().map(|n| n.clamp(CELLS_RANGE.0, CELLS_RANGE.1)));
            (snapped_up((extent / (each.as_dvec3() - SPARE_CELLS)).max_element()), each)
        }
    };
    let origin_cells = ((lo + hi) * 0.5 / cell_size - cells.as_dvec3() * 0.5).round();
    let world_from_grid = DMat4::from_mat3(world_from_frame)
        * DMat4::from_scale(DVec3::splat(cell_size))
        * DMat4::from_translation(origin_cells);
    Grid::orthographic(world_from_grid, cell_size, cells)
}

/// What an eye sees of bounds: slopes x/z and y/z, and depths z.
#[derive(Debug, Clone, Copy)]
struct Seen {
    lo: DVec3,
    hi: DVec3,
}

/// All of `bounds` from `eye`; nothing if some of them are beside it, behind it or too near.
fn seen_from(eye: DVec3, world_from_frame: DMat3, bounds: &Bounds) -> Option<Seen> {
    let corners = usable(bounds).corners().map(|corner| world_from_frame.transpose() * (corner - eye));
    let (lo, hi) = span(corners.map(|p| DVec3::new(p.x / p.z, p.y / p.z, p.z)));
    let fits =
        lo.z > LEAST_NEAR * hi.z && lo.z > 0.0 && lo.truncate().abs().max(hi.truncate().abs()).max_element() < STEEPEST;
    (fits && eye.is_finite()).then_some(Seen { lo, hi })
}

/// What a cone of light meets of `bounds`; nothing if it misses them.
fn seen_in_cone(eye: DVec3, world_from_frame: DMat3, steepest: f64, bounds: &Bounds) -> Option<Seen> {
    let cone = DVec2::splat(steepest);
    let (_, far) = span(usable(bounds).corners().map(|corner| world_from_frame.transpose() * (corner - eye)));
    let whole = Seen { lo: (-cone).extend(LEAST_NEAR * far.z), hi: cone.extend(far.z) };
    let seen = seen_from(eye, world_from_frame, bounds).map_or(whole, |all| Seen {
        lo: all.lo.truncate().max(-cone).extend(all.lo.z),
        hi: all.hi.truncate().min(cone).extend(all.hi.z),
    });
    (eye.is_finite() && seen.lo.cmplt(seen.hi).all()).then_some(seen)
}

/// A perspective grid over what is seen; nothing if snapping would bring it to the eye.
fn perspective(eye: DVec3, world_from_frame: DMat3, cells: Cells, seen: Seen) -> Option<Grid> {
    let middle_depth = 0.5 * (seen.lo.z + seen.hi.z);
    let extent = (seen.hi - seen.lo).max(DVec3::new(1e-6, 1e-6, 1e-6 * middle_depth));
    // A middle cell's extents are slope · middle_depth, slope · middle_depth, depth.
    let unit = DVec3::new(1.0 / middle_depth, 1.0 / middle_depth, 1.0);
    let (size, cells) = match cells {
        Cells::Longest(count) => {
            let lengths = extent / unit;
            let longest = lengths.max_element();
            let size = (longest / (in_range(count) - SPARE_CELLS) * unit).map(snapped_up);
            (size, cells_along(extent / size, lengths.cmpge(DVec3::splat(longest)), count))
        }
        Cells::Each(each) => {
            let each = UVec3::from_array(each.to_array().map(|n| n.clamp(CELLS_RANGE.0, CELLS_RANGE.1)));
            let size = (extent / (each.as_dvec3() - SPARE_CELLS)).map(snapped_up);
            (DVec3::new(size.x.max(size.y), size.x.max(size.y), size.z), each)
        }
    };
    let origin = ((seen.lo + seen.hi) * 0.5 / size - cells.as_dvec3() * 0.5).round() * size;
    let end = origin + cells.as_dvec3() * size;
    let world_from_eye = DMat4::from_translation(eye) * DMat4::from_mat3(world_from_frame);
    (origin.z > 0.5 * LEAST_NEAR * end.z).then(|| {
        Grid::perspective(world_from_eye, origin.truncate(), end.truncate(), single(origin.z), single(end.z), cells)
    })
}

/// Six grids about a point light that the bounds surround: ±x, ±y, ±z, each a quarter turn wide and a cell more.
fn around(eye: DVec3, cells: Cells, bounds: &Bounds) -> Vec<Grid> {
    let bounds = usable(bounds);
    if !eye.is_finite() {
        return vec![orthographic(DMat3::IDENTITY, cells, &bounds)];
    }
    let reach = (bounds.min - eye).abs().max((bounds.max - eye).abs()).max_element();
    let cells = match cells {
        Cells::Longest(count) => UVec3::splat(count),
        Cells::Each(each) => each,
    };
    let cells = UVec3::from_array(cells.to_array().map(|n| n.clamp(CELLS_RANGE.0, CELLS_RANGE.1)));
    let far = snapped_up(reach * 1.01);
    let n = cells.as_dvec3().truncate();
    let half = n / (n - 2.0);
    let frames = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z].map(axis_frame);
    let grid = |frame| {
        let world_from_eye = DMat4::from_translation(eye) * DMat4::from_mat3(frame);
        Grid::perspective(world_from_eye, -half, half, single(far * LEAST_NEAR), single(far), cells)
    };
    frames.map(grid).to_vec()
}

/// Cells of each axis of a grid of cubes: `count` along the longest, as many as needed along the others.
fn cells_along(extent_cells: DVec3, is_longest: BVec3, count: u32) -> UVec3 {
    let longest = count.clamp(CELLS_RANGE.0, CELLS_RANGE.1);
    let needed = extent_cells.to_array().map(|n| whole(n + SPARE_CELLS).next_multiple_of(CELLS_STEP));
    let needed = UVec3::from_array(needed).clamp(UVec3::splat(CELLS_RANGE.0), UVec3::splat(longest));
    UVec3::select(is_longest, UVec3::splat(longest), needed)
}

fn in_range(count: u32) -> f64 {
    f64::from(count.clamp(CELLS_RANGE.0, CELLS_RANGE.1))
}

/// The least step of cell size that is not below `size`.
fn snapped_up(size: f64) -> f64 {
    // The slack keeps a size that is a step already, up to rounding, from going one further.
    ((size.log2() * STEPS_PER_OCTAVE - 1e-9).ceil() / STEPS_PER_OCTAVE).exp2()
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

/// The frame along the world axis nearest to `direction`.
fn axis_frame(direction: DVec3) -> DMat3 {
    let axis = (0..3).max_by(|&a, &b| direction[a].abs().total_cmp(&direction[b].abs())).unwrap_or(2);
    let mut forward = DVec3::ZERO;
    forward[axis] = if direction[axis] < 0.0 { -1.0 } else { 1.0 };
    frame_along(forward, DVec3::Y)
}

/// Least and greatest coordinates.
fn span(points: [DVec3; 8]) -> (DVec3, DVec3) {
    points.into_iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), p| (lo.min(p), hi.max(p)))
}

/// Bounds that a grid can stand on: finite, not empty, and large enough for f32 to tell their cells apart.
fn usable(bounds: &Bounds) -> Bounds {
    const FARTHEST: DVec3 = DVec3::splat(1e12);
    let proper = bounds.min.is_finite() && bounds.max.is_finite() && !bounds.is_empty();
    let (min, max) = if proper { (bounds.min, bounds.max) } else { (DVec3::splat(-0.5), DVec3::splat(0.5)) };
    let (min, max) = (min.clamp(-FARTHEST, FARTHEST), max.clamp(-FARTHEST, FARTHEST));
    let center = (min + max) * 0.5;
    let least = (center.abs().max_element() * 1e-5).max(1e-6);
    let half = ((max - min) * 0.5).max(DVec3::splat(0.5 * least));
    Bounds { min: center - half, max: center + half }
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to what fits")]
fn whole(cells: f64) -> u32 {
    cells.ceil().clamp(0.0, 1e6) as u32
}

#[expect(clippy::cast_possible_truncation, reason = "shaders work in f32")]
fn single(value: f64) -> f32 {
    value as f32
}
