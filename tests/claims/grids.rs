//! Where grids stand: they enclose what they must, move by whole cells, and map both ways.

mod moves;

use crate::{gpu, probe};
use glam::{DVec3, DVec4, UVec3, Vec3, Vec4};
use murrine::gpu::{GpuStruct, buffer};
use murrine::grid::{Grid, ORTHOGRAPHIC, PERSPECTIVE};
use murrine::scene::description::{Align, Bounds, Camera, Cells, GridSettings, Light, LightKind, Projection};

fn settings(cells: Cells, align: Align, projection: Projection) -> GridSettings {
    GridSettings { cells, align, projection, region: None }
}

fn bounds_at(center: DVec3, half: DVec3) -> Bounds {
    Bounds { min: center - half, max: center + half }
}

fn point_light(position: Vec3) -> Light {
    Light { kind: LightKind::Point { position }, ..Light::default() }
}

fn spot_light(position: Vec3, target: Vec3, angle_deg: f32) -> Light {
    let direction = (target - position).normalize();
    Light { kind: LightKind::Spot { position, direction, angle_deg, blend: 0.1 }, ..Light::default() }
}

const HALF: DVec3 = DVec3::new(0.5, 1.1, 0.8);

/// A camera askew to all axes.
fn camera() -> Camera {
    Camera { eye: Vec3::new(3.0, 2.0, 4.5), target: Vec3::new(0.1, 0.2, 0.0), ..Camera::default() }
}

/// One grid of every kind, named, about a body at `center`; those of a point light inside the body last.
fn every_kind(center: DVec3, cells: Cells) -> Vec<(String, Grid)> {
    let bounds = bounds_at(center, HALF);
    let mut grids = Vec::new();
    for align in [Align::Camera, Align::World] {
        for projection in [Projection::Orthographic, Projection::Perspective] {
            let (grid, warning) = Grid::for_camera(&settings(cells, align, projection), &camera(), &bounds);
            assert_eq!(warning, None);
            let projected = if projection == Projection::Perspective { PERSPECTIVE } else { ORTHOGRAPHIC };
            assert_eq!(grid.projection, projected);
            grids.push((format!("view, {align:?}, {projection:?}"), grid));
        }
    }
    let lights = [
        ("directional", Light::default()),
        ("point", point_light(Vec3::new(-2.0, 4.0, 1.0))),
        ("spot", spot_light(Vec3::new(2.5, 3.0, -1.0), center.as_vec3(), 40.0)),
    ];
    let light_settings = settings(cells, Align::Camera, Projection::Orthographic);
    for (name, light) in lights {
        let made = Grid::for_light(&light_settings, &light, &bounds);
        assert_eq!(made.len(), 1, "{name}");
        grids.push((format!("light, {name}"), made[0]));
    }
    for grid in Grid::for_light(&light_settings, &point_light(center.as_vec3() + 0.1), &bounds) {
        grids.push(("light, point inside".to_owned(), grid));
    }
    grids
}

fn points_in(bounds: &Bounds) -> Vec<DVec3> {
    let steps = [0.0, 0.25, 0.5, 0.75, 1.0];
    let mut points = Vec::new();
    for x in steps {
        for y in steps {
            points.extend(steps.map(|z| bounds.min + (bounds.max - bounds.min) * DVec3::new(x, y, z)));
        }
    }
    points
}

/// Cells by which a point lies within the grid, the least over its six faces; negative outside.
fn depth_in_cells(grid: &Grid, p_world: DVec3) -> f64 {
    let h = grid.grid_from_world.as_dmat4() * p_world.extend(1.0);
    if h.w <= 0.0 {
        return f64::NEG_INFINITY;
    }
    let p = h.truncate() / h.w;
    let p = DVec3::new(p.x, p.y, grid.slice_of(p.z));
    p.min(grid.cells.as_dvec3() - p).min_element()
}

#[test]
fn everything_in_the_bounds_lands_inside_with_a_cell_to_spare() {
    let resolutions =
        [Cells::Longest(16), Cells::Longest(100), Cells::Longest(1024), Cells::Each(UVec3::new(33, 190, 71))];
    for cells in resolutions {
        for center in [DVec3::ZERO, DVec3::new(-0.3, 0.17, 0.4)] {
            let grids = every_kind(center, cells);
            let (around, single): (Vec<_>, Vec<_>) = grids.iter().partition(|(name, _)| name.ends_with("inside"));
            assert_eq!(around.len(), 6);
            for p in points_in(&bounds_at(center, HALF)) {
                for (name, grid) in &single {
                    let depth = depth_in_cells(grid, p);
                    assert!(depth >= 0.999, "{name}, {cells:?}: {p} lies {depth} cells inside");
                }
                // Beside the light itself no column begins.
                if (p - center).length() > 0.3 {
                    let depth = around.iter().map(|(_, g)| depth_in_cells(g, p)).fold(f64::NEG_INFINITY, f64::max);
                    assert!(depth >= 0.0, "six frusta, {cells:?}: {p} lies {depth} cells inside");
                }
            }
            for (name, grid) in &single {
                assert!(depth_in_cells(grid, center + 4.0 * HALF) < 0.0, "{name}: a point far outside is told");
            }
        }
    }
}

#[test]
fn the_longest_axis_has_the_cells_that_were_asked_for_and_the_body_fills_most_of_them() {
    for count in [16, 37, 128, 512] {
        for (name, grid) in every_kind(DVec3::ZERO, Cells::Longest(count)) {
            assert_eq!(grid.cells.max_element(), count, "{name}");
            assert!(grid.cells.min_element() >= 16, "{name}");
            if name.ends_with("inside") {
                continue;
            }
            let corners = bounds_at(DVec3::ZERO, HALF).corners().map(|c| grid.grid_point(c));
            let (lo, hi) = corners.iter().fold((corners[0], corners[0]), |(lo, hi), p| (lo.min(*p), hi.max(*p)));
            let extent = DVec3::new(hi.x - lo.x, hi.y - lo.y, grid.slice_of(hi.z) - grid.slice_of(lo.z)).max_element();
            let least = (f64::from(count) - 3.0) * 2_f64.powf(-1.0 / 8.0) - 0.01;
            assert!(extent >= least, "{name}, {count}: {extent} cells are used");
        }
    }
    let each = UVec3::new(17, 64, 200);
    assert!(every_kind(DVec3::ZERO, Cells::Each(each)).iter().all(|(_, grid)| grid.cells == each));
}

#[test]
fn cells_of_an_orthographic_grid_are_cubes_of_a_step_in_size() {
    for cells in [Cells::Longest(90), Cells::Each(UVec3::new(33, 190, 71))] {
        for scale in [0.9, 0.95, 1.0, 1.03, 1.08] {
            let asked = settings(cells, Align::Camera, Projection::Orthographic);
            let (grid, _) = Grid::for_camera(&asked, &camera(), &bounds_at(DVec3::ZERO, HALF * scale));
            let world = |p: [f64; 3]| grid.world_point(DVec3::from(p));
            for axis in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] {
                let side = (world(axis) - world([0.0; 3])).length();
                assert!((side / f64::from(grid.cell_size) - 1.0).abs() < 1e-5);
            }
            let step = f64::from(grid.cell_size).log2() * 8.0;
            assert!((step - step.round()).abs() < 1e-4, "cell size {}", grid.cell_size);
        }
    }
}

/// The part of a point's place that is not whole cells: slopes and slices for a perspective grid.
fn phase(grid: &Grid, p_world: DVec3) -> DVec3 {
    let p = grid.grid_point(p_world);
    let p = DVec3::new(p.x, p.y, grid.slice_of(p.z));
    p - p.floor()
}

#[test]
fn a_slow_move_shifts_the_cells_by_whole_cells_or_not_at_all() {
    let fixed = DVec3::new(0.05, -0.04, 0.03);
    let first = every_kind(DVec3::ZERO, Cells::Longest(96));
    let mut shifted = vec![false; first.len()];
    for step in 0..60 {
        // A twentieth of a cell or so a step. A spot light is aimed, so it turns; left out.
        let center = DVec3::new(1.0, 0.7, -0.4) * 1e-3 * f64::from(step);
        for (i, ((name, was), (_, is))) in first.iter().zip(every_kind(center, Cells::Longest(96))).enumerate() {
            if name.contains("spot") || name.ends_with("inside") {
                continue;
            }
            let perspective = is.projection == PERSPECTIVE;
            if perspective && (is.cell_size / was.cell_size - 1.0).abs() > 1e-3 {
                // The depth of a perspective body changes as it moves; its cells may take a step.
                continue;
            }
            assert!(perspective || is.cell_size == was.cell_size, "{name}: the cell's size");
            let moved = phase(&is, fixed) - phase(was, fixed);
            let moved = (moved - moved.round()).abs().max_element();
            assert!(moved < 2e-3, "{name}, step {step}: the cells swim by {moved}");
            shifted[i] |= (is.grid_point(fixed) - was.grid_point(fixed)).abs().max_element() > 0.5;
        }
    }
    let moving = first.iter().zip(&shifted).filter(|((name, _), _)| name.starts_with("view, World, Ortho"));
    assert!(moving.clone().count() == 1 && moving.clone().all(|(_, s)| *s), "the grid does follow the body");
}

#[test]
fn a_grid_is_a_pure_function_of_the_bounds() {
    let [a, b] = [0, 1].map(|_| every_kind(DVec3::new(0.2, 0.1, 0.3), Cells::Longest(77)));
    assert!(a.iter().zip(&b).all(|((_, a), (_, b))| a == b));
    let moved = every_kind(DVec3::new(0.6, 0.1, 0.3), Cells::Longest(77));
    assert!(a.iter().zip(&moved).any(|((_, a), (_, b))| a != b));
}

#[test]
fn maps_to_and_from_the_grid_are_inverses() {
    for (name, grid) in every_kind(DVec3::new(0.2, 0.1, 0.3), Cells::Longest(128)) {
        for i in 0..64 {
            let t = f64::from(i) / 63.0;
            let slice = grid.cells.as_dvec3() * DVec3::new(t, (t * 7.3).fract(), (t * 3.1).fract());
            let p_grid = slice.with_z(grid.slab(slice.z));
            let back = grid.grid_point(grid.world_point(p_grid));
            assert!((back - p_grid).abs().max_element() < 2e-3, "{name}: {p_grid} comes back as {back}");
            assert!((grid.slice_of(grid.slab(slice.z)) - slice.z).abs() < 1e-9, "{name}: slabs");
        }
        assert!(grid.slab(0.0).abs() < 1e-9);
        assert!((grid.slab(f64::from(grid.cells.z)) - f64::from(grid.cells.z)).abs() < 1e-9);
    }
}

#[test]
fn a_perspective_grid_keeps_lines_straight_and_its_slices_even_in_depth() {
    let asked = settings(Cells::Longest(64), Align::Camera, Projection::Perspective);
    let (grid, _) = Grid::for_camera(&asked, &camera(), &bounds_at(DVec3::ZERO, HALF));
    let (a, b) = (DVec3::new(-0.4, 1.0, 0.7), DVec3::new(0.45, -0.8, -0.6));
    let [a_grid, middle, b_grid] = [a, a.lerp(b, 0.37), b].map(|p| grid.grid_point(p));
    let off = (middle - a_grid).cross(b_grid - a_grid).length() / (b_grid - a_grid).length_squared();
    assert!(off < 1e-5, "bent by {off}");
    // Straight, but not evenly spaced: that is what makes it perspective.
    let fraction = (middle - a_grid).length() / (b_grid - a_grid).length();
    assert!((fraction - 0.37).abs() > 0.01, "{fraction}");

    let eye = camera().eye.as_dvec3();
    let forward = (camera().target.as_dvec3() - eye).normalize();
    let depth = |k: f64| (grid.world_point(DVec3::new(20.0, 30.0, grid.slab(k))) - eye).dot(forward);
    let thickness = depth(1.0) - depth(0.0);
    for k in 0..64 {
        let here = depth(f64::from(k) + 1.0) - depth(f64::from(k));
        assert!((here / thickness - 1.0).abs() < 1e-3, "slice {k}: {here}, not {thickness}");
    }
    // Columns meet in the eye.
    let [near, far] = [0.0, 64.0].map(|z| grid.world_point(DVec3::new(5.0, 50.0, z)) - eye);
    assert!(near.normalize().distance(far.normalize()) < 1e-5);
}

#[test]
fn a_perspective_grid_that_can_not_be_is_orthographic_and_says_so() {
    let asked = settings(Cells::Longest(64), Align::Camera, Projection::Perspective);
    let inside = Camera { eye: Vec3::new(0.1, 0.1, 0.1), target: Vec3::X, ..Camera::default() };
    let away = Camera { eye: Vec3::new(0.0, 0.0, 5.0), target: Vec3::new(0.0, 0.0, 9.0), ..Camera::default() };
    for camera in [inside, away] {
        let bounds = bounds_at(DVec3::ZERO, HALF);
        let (grid, word) = Grid::for_camera(&asked, &camera, &bounds);
        assert_eq!(grid.projection, ORTHOGRAPHIC);
        assert!(word.is_some_and(|w| w.contains("orthographic")));
        assert!(points_in(&bounds).iter().all(|&p| depth_in_cells(&grid, p) > 0.9));
    }
}

#[test]
fn odd_bounds_give_a_grid_that_does_no_harm() {
    let nan = DVec3::splat(f64::NAN);
    let bounds = [
        Bounds::EMPTY,
        Bounds { min: nan, max: nan },
        Bounds { min: DVec3::NEG_INFINITY, max: DVec3::INFINITY },
        bounds_at(DVec3::ZERO, DVec3::ZERO),
        bounds_at(DVec3::splat(1e9), DVec3::ZERO),
        bounds_at(DVec3::ZERO, DVec3::new(1e30, 0.0, 0.0)),
        bounds_at(DVec3::ZERO, DVec3::new(1.0, 0.0, 1.0)),
    ];
    let odd_camera = Camera { eye: Vec3::NAN, target: Vec3::ZERO, up: Vec3::ZERO, fov_deg: 30.0 };
    let straight_down = Camera { eye: Vec3::new(0.0, 5.0, 0.0), ..Camera::default() };
    let mut grids = Vec::new();
    for bounds in &bounds {
        for cells in [Cells::Longest(0), Cells::Longest(u32::MAX), Cells::Each(UVec3::new(0, 1_000_000, 64))] {
            for projection in [Projection::Orthographic, Projection::Perspective] {
                let asked = settings(cells, Align::Camera, projection);
                for camera in [camera(), odd_camera, straight_down] {
                    grids.push(Grid::for_camera(&asked, &camera, bounds).0);
                }
                for light in [
                    point_light(Vec3::NAN),
                    point_light(Vec3::ZERO),
                    spot_light(Vec3::X, Vec3::X, 30.0),
                    spot_light(Vec3::X, Vec3::ZERO, f32::NAN),
                ] {
                    grids.extend(Grid::for_light(&asked, &light, bounds));
                }
            }
        }
    }
    for grid in grids {
        assert!(grid.grid_from_world.is_finite() && grid.world_from_grid.is_finite(), "{grid:?}");
        assert!(grid.cell_size > 0.0 && grid.cell_size.is_finite() && grid.far > grid.near, "{grid:?}");
        assert!(grid.cells.min_element() >= 16 && grid.cells.max_element() <= 1024, "{grid:?}");
    }
}

#[test]
fn shaders_map_and_slice_as_the_host_does() {
    let source = r#"#include "lib/dispatch.inc.wgsl"
#include "lib/grid.inc.wgsl"
struct Answer { p_grid: vec3f, slab: f32, p_world: vec3f, slice: f32, low: vec3f, word: u32, high: vec3f, bit: u32 }
@group(0) @binding(0) var<uniform> grid: Grid;
@group(0) @binding(1) var<storage, read> questions: array<vec4f>;
@group(0) @binding(2) var<storage, read_write> answers: array<Answer>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= arrayLength(&questions) { return; }
    let q = questions[id.x];
    let g = grid;
    let p_grid = grid_from_world(g, q.xyz);
    let cell = vec3i(vec3f(p_grid.xy, q.w));
    let b = cell_box(g, cell);
    answers[id.x] = Answer(p_grid, slab(g, q.w), world_from_grid(g, p_grid), slice_of(g, p_grid.z),
        b.center - b.half, word_index(g, vec3u(cell)), b.center + b.half, word_bit(vec3u(cell).z));
}
"#;
    #[repr(C)]
    #[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
    struct Answer {
        p_grid: Vec3,
        slab: f32,
        p_world: Vec3,
        slice: f32,
        low: Vec3,
        word: u32,
        high: Vec3,
        bit: u32,
    }
    let pass = probe::compile(source, &[Grid::LAYOUT]);
    let points = points_in(&bounds_at(DVec3::ZERO, HALF));
    for (name, mut grid) in every_kind(DVec3::ZERO, Cells::Each(UVec3::new(100, 37, 211))) {
        if name.ends_with("inside") {
            continue;
        }
        grid.word_base = 12;
        let questions: Vec<Vec4> = (0_u16..).zip(&points).map(|(k, p)| p.as_vec3().extend(f32::from(k))).collect();
        let bound = buffer::uniform(gpu(), "grid", &grid);
        let answers: Vec<Answer> = probe::ask(&pass, &[("grid", bound.as_entire_binding())], &questions);
        for (q, a) in questions.iter().zip(&answers) {
            let p_grid = grid.grid_point(q.truncate().as_dvec3());
            let near = |got: Vec3, want: DVec3, by: f64| (got.as_dvec3() - want).abs().max_element() < by;
            assert!(near(a.p_grid, p_grid, 1e-3), "{name}: {} for {p_grid}", a.p_grid);
            assert!(near(a.p_world, q.truncate().as_dvec3(), 1e-4), "{name}: {} for {q}", a.p_world);
            let k = f64::from(q.w);
            let cell = a.p_grid.as_dvec3().truncate().floor();
            let numbers = DVec4::new(grid.slab(k), grid.slice_of(p_grid.z), grid.slab(k), grid.slab(k + 1.0));
            let got = Vec4::new(a.slab, a.slice, a.low.z, a.high.z).as_dvec4();
            assert!((got - numbers).abs().max_element() < 5e-3, "{name}: {got} for {numbers}");
            assert!(near(a.low.with_z(0.0), cell.extend(0.0), 1e-3), "{name}: {} for {cell}", a.low);
            let [x, y, z] = cell.extend(k).as_uvec3().to_array();
            assert_eq!(a.word as usize, 12 + grid.word_of([x, y, z]), "{name}");
            assert_eq!(a.bit, 1 << (z % 32), "{name}");
        }
    }
}

#[test]
fn cell_bytes_are_z_then_y_then_x() {
    let grid = Grid::world_aligned(DVec3::ZERO, 1.0, UVec3::new(17, 18, 40));
    let mut words = vec![0; grid.word_count() as usize];
    words[grid.word_of([3, 5, 37])] |= 1 << (37 - 32);
    let bytes = grid.cell_bytes(&words);
    assert_eq!(bytes.len(), 17 * 18 * 40);
    assert_eq!(bytes.iter().map(|b| u32::from(*b)).sum::<u32>(), 1);
    assert_eq!(bytes[(37 * 18 + 5) * 17 + 3], 1);
}
