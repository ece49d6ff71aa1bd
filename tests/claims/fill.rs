//! The eager fill is exact parity.
#![expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small whole numbers")]

mod winding;

use crate::stages::Stages;
use glam::{DMat3, DMat4, DVec2, DVec3, UVec3, Vec3, Vec3Swizzles};
use murrine::grid::Grid;
use murrine::scene::description::{Deformer, Model, Scene, Shape, Source};
use murrine::scene::{World, shapes};
use std::sync::Arc;

const BALL: Shape = Shape::Icosphere { radius: 1.0, subdivisions: 3 };
const TORUS: Shape = Shape::Torus { radius: 0.8, tube: 0.25, segments: 40 };

fn turned(shape: Shape, rotate_deg: Vec3, deformers: Vec<Deformer>) -> Scene {
    let model = Model { source: Source::Shape(shape), rotate_deg, deformers, ..Model::default() };
    Scene { models: vec![model], ..Scene::default() }
}

fn around(half: f64, cells: UVec3) -> Grid {
    Grid::world_aligned(DVec3::splat(-half), 2.0 * half / f64::from(cells.max_element()), cells)
}

fn spot(cells: UVec3) -> Grid {
    let eye = DVec3::new(1.0, 3.0, 2.0);
    let z = -eye.normalize();
    let x = z.cross(DVec3::Y).normalize();
    let world_from_eye = DMat4::from_translation(eye) * DMat4::from_mat3(DMat3::from_cols(x, z.cross(x), z));
    Grid::perspective(world_from_eye, DVec2::splat(-0.55), DVec2::splat(0.55), 2.2, 5.3, cells)
}

fn odd_columns(stages: &Stages) -> u32 {
    stages.volume.counts()[0].odd_columns
}

/// Whether each cell's centre is inside, by rays along grid x: f64, from the corners that the device used.
fn truth(grid: &Grid, corners: &[[DVec3; 3]]) -> Vec<u8> {
    let UVec3 { x: across, y: rows, z: slices } = grid.cells;
    let mut inside = vec![0_u8; (across * rows * slices) as usize];
    for t in corners {
        let [a, b, c] = t.map(|p| {
            let p = grid.grid_point(p);
            DVec3::new(p.x, p.y, grid.slice_of(p.z))
        });
        // In slices a perspective triangle is not flat: rays run in grid space, where it is.
        let flat = t.map(|p| grid.grid_point(p));
        let low = a.min(b).min(c).floor().max(DVec3::ZERO);
        let high = a.max(b).max(c).ceil();
        for z in low.z as u32..(high.z as u32).min(slices) {
            let depth = grid.slab(f64::from(z) + 0.5);
            for y in low.y as u32..(high.y as u32).min(rows) {
                let line = DVec2::new(f64::from(y) + 0.5, depth);
                let side = |p: DVec3, q: DVec3| (q.yz() - p.yz()).perp_dot(line - p.yz());
                let sides = [side(flat[1], flat[2]), side(flat[2], flat[0]), side(flat[0], flat[1])];
                if sides.iter().all(|s| *s > 0.0) || sides.iter().all(|s| *s < 0.0) {
                    let sum: f64 = sides.iter().sum();
                    let met = (sides[0] * flat[0].x + sides[1] * flat[1].x + sides[2] * flat[2].x) / sum;
                    for x in (met - 0.5).ceil().max(0.0) as u32..across {
                        inside[((z * rows + y) * across + x) as usize] ^= 1;
                    }
                }
            }
        }
    }
    inside
}

/// Distance from a point to the nearest triangle.
fn distance(p: DVec3, corners: &[[DVec3; 3]]) -> f64 {
    let to_segment = |a: DVec3, b: DVec3| {
        let t = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
        p.distance(a + (b - a) * t)
    };
    let to_triangle = |[a, b, c]: [DVec3; 3]| {
        let n = (b - a).cross(c - a);
        let within = [(a, b), (b, c), (c, a)].iter().all(|(u, v)| (*v - *u).cross(p - *u).dot(n) >= 0.0);
        let plane = if within { (p - a).dot(n).abs() / n.length() } else { f64::INFINITY };
        plane.min(to_segment(a, b)).min(to_segment(b, c)).min(to_segment(c, a))
    };
    corners.iter().map(|t| to_triangle(*t)).fold(f64::INFINITY, f64::min)
}

#[test]
fn closed_meshes_have_no_odd_column_and_their_interior_is_that_of_rays() {
    let tilt = Vec3::new(13.0, 31.0, 7.0);
    let wave = Deformer::Wave { axis: 0, along: 1, amplitude: 0.15, wavelength: 0.8, hz: 0.0 };
    for (scene, half) in [
        (turned(BALL, Vec3::ZERO, vec![]), 1.1),
        (turned(BALL, tilt, vec![wave]), 1.3),
        (turned(TORUS, tilt, vec![]), 1.2),
        (turned(Shape::Box { min: Vec3::splat(-0.7), max: Vec3::new(0.7, 0.6, 0.5) }, tilt, vec![]), 1.2),
    ] {
        let mut stages = Stages::of_scene(&scene);
        let corners = stages.corners();
        for grid in [around(half, UVec3::splat(48)), around(half, UVec3::new(40, 70, 33)), spot(UVec3::new(50, 40, 45))]
        {
            let words = stages.filled(grid, false);
            assert_eq!(odd_columns(&stages), 0);
            let expected = truth(&grid, &corners);
            let inside: u32 = expected.iter().map(|b| u32::from(*b)).sum();
            assert!(inside > 1000, "{inside} cells inside");
            assert_inside("fill", &grid, &words, &expected, &corners);
            for method in SOLID {
                let [interior, surface] = stages.solid(grid, method);
                assert_inside(method, &grid, &interior, &expected, &corners);
                assert!(surface.iter().any(|w| *w != 0), "{method}");
            }
        }
    }
}

/// Methods that write the interior of closed meshes themselves.
const SOLID: [&str; 2] = ["slicemap-solid", "slices"];

/// Fails if a cell is told wrong whose centre is not at the surface, by the rounding of a rasterizer's corners.
fn assert_inside(what: &str, grid: &Grid, words: &[u32], expected: &[u8], corners: &[[DVec3; 3]]) {
    for (i, (found, expected)) in (0_u32..).zip(grid.cell_bytes(words).iter().zip(expected)) {
        if found != expected {
            let across = grid.cells.x;
            let cell = UVec3::new(i % across, i / across % grid.cells.y, i / across / grid.cells.y);
            let center = cell.as_dvec3() + 0.5;
            let center = grid.world_point(DVec3::new(center.x, center.y, grid.slab(center.z)));
            let away = distance(center, corners) / f64::from(grid.cell_size);
            assert!(away < 1.0 / 128.0, "{what}: cell {cell} is {away} cells from the surface");
        }
    }
}

#[test]
fn a_solid_slicemap_hands_on_the_cells_that_have_one_of_26_neighbours_outside() {
    let mut stages = Stages::of(&[TORUS]);
    // Neighbours across words, beside the grid's rim too.
    let grid = around(0.9, UVec3::new(40, 40, 70));
    let [interior, surface] = stages.solid(grid, "slicemap-solid");
    let (interior, surface) = (grid.cell_bytes(&interior), grid.cell_bytes(&surface));
    let size = grid.cells.as_ivec3();
    let at = |x: i32, y: i32, z: i32| {
        let within = (0..size.x).contains(&x) && (0..size.y).contains(&y) && (0..size.z).contains(&z);
        within && interior[((z * size.y + y) * size.x + x) as usize] == 1
    };
    let mut counts = [0; 2];
    for (i, (inside, surface)) in (0..).zip(interior.iter().zip(&surface)) {
        let (x, y, z) = (i % size.x, i / size.x % size.y, i / size.x / size.y);
        let deep = (0..27).all(|n| at(x + n % 3 - 1, y + n / 3 % 3 - 1, z + n / 9 - 1));
        assert_eq!(*surface == 1, *inside == 1 && !deep, "{x} {y} {z}");
        counts[usize::from(deep)] += u32::from(*inside);
    }
    assert!(counts.iter().all(|n| *n > 500), "{counts:?}");
}

#[test]
fn a_leak_is_solid_from_the_grids_near_end_in_a_solid_slicemap_and_to_its_far_end_from_slice_to_slice() {
    let scene = turned(BALL, Vec3::new(0.0, 20.0, 0.0), vec![]);
    let mut leaky = shapes::shape(&BALL);
    leaky.triangles.remove(700);
    leaky.parts[0].triangles.end -= 1;
    let grid = around(1.1, UVec3::splat(64));
    let world = World::from_geometry(&scene, vec![Arc::new(leaky)]);
    let mut stages = Stages::of_world(&scene, &world);
    let ends = |words: &[u32], z: u32| {
        let bytes = grid.cell_bytes(words);
        bytes[(z * 64 * 64) as usize..((z + 1) * 64 * 64) as usize].iter().map(|b| u32::from(*b)).sum::<u32>()
    };
    let filled = stages.filled(grid, false);
    let odd = odd_columns(&stages);
    assert!(odd > 3, "{odd}");
    let [solid, slices] = SOLID.map(|method| stages.solid(grid, method)[0].clone());
    assert_eq!([ends(&solid, 0), ends(&solid, 63)], [odd, 0]);
    assert_eq!([ends(&slices, 0), ends(&slices, 63)], [0, odd]);
    assert_eq!([ends(&filled, 0), ends(&filled, 63)], [0, odd]);
}

#[test]
fn lines_through_edges_and_corners_count_once() {
    // Every face and edge of the box, and its diagonals, run through centres of columns.
    let stages_of = |min, max| Stages::of(&[Shape::Box { min, max }]);
    let grid = Grid::world_aligned(DVec3::ZERO, 1.0, UVec3::splat(32));
    let mut stages = stages_of(Vec3::splat(4.5), Vec3::splat(20.5));
    let words = stages.filled(grid, false);
    assert_eq!(odd_columns(&stages), 0);
    assert_eq!(words.iter().map(|w| w.count_ones()).sum::<u32>(), 16 * 16 * 16);
}

#[test]
fn the_interior_of_a_ball_approaches_its_volume() {
    let volume = |cells: u32| {
        let mut stages = Stages::of(&[Shape::Icosphere { radius: 1.0, subdivisions: 5 }]);
        let grid = around(1.07, UVec3::splat(cells));
        let count: u32 = stages.filled(grid, false).iter().map(|w| w.count_ones()).sum();
        f64::from(count) * f64::from(grid.cell_size).powi(3)
    };
    let ball = 4.0 / 3.0 * std::f64::consts::PI;
    let error = |cells| (volume(cells) / ball - 1.0).abs();
    assert!(error(24) < 0.02, "{}", error(24));
    assert!(error(128) < 0.002, "{}", error(128));
}

#[test]
fn a_leak_makes_odd_columns_which_repair_takes_from_their_neighbours() {
    let scene = turned(BALL, Vec3::new(0.0, 20.0, 0.0), vec![]);
    let mut leaky = shapes::shape(&BALL);
    // Holes of several columns: those in the middle have no even neighbour at their side.
    let removed = [700, 900, 1100];
    for t in removed.iter().rev() {
        leaky.triangles.remove(*t);
    }
    leaky.parts[0].triangles.end -= 3;
    let grid = around(1.1, UVec3::splat(64));
    let whole = Stages::of_scene(&scene).filled(grid, false);
    let world = World::from_geometry(&scene, vec![Arc::new(leaky)]);
    let mut stages = Stages::of_world(&scene, &world);
    let wrong = |words: &[u32]| -> u32 { words.iter().zip(&whole).map(|(a, b)| (a ^ b).count_ones()).sum() };
    let unrepaired = wrong(&stages.filled(grid, false));
    let odd = odd_columns(&stages);
    assert!(odd > 9 && odd < 100, "{odd} odd columns");
    let repaired = wrong(&stages.filled(grid, true));
    assert_eq!(odd_columns(&stages), odd);
    assert!(unrepaired > 10 * odd, "{unrepaired} cells in {odd} columns");
    assert!(repaired < 3 * odd, "{repaired} cells in {odd} columns, {unrepaired} without repair");
}
