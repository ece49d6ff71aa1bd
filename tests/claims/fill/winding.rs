//! The fill against another truth than rays: the winding number of the mesh about each cell's centre.

use super::{around, distance, odd_columns, spot, turned};
use crate::stages::Stages;
use crate::support::left_out;
use glam::{DMat3, DMat4, DVec2, DVec3, UVec3, Vec3};
use murrine::grid::Grid;
use murrine::scene::description::{Model, Scene, Shape, Source};
use murrine::scene::{World, framing};
use std::f64::consts::TAU;
use std::path::Path;

/// How often the surface goes around a point, by the solid angles of its triangles (van Oosterom and Strackee).
fn winding(p: DVec3, corners: &[[DVec3; 3]]) -> f64 {
    let solid_angle = |t: &[DVec3; 3]| {
        let [a, b, c] = t.map(|corner| corner - p);
        let (la, lb, lc) = (a.length(), b.length(), c.length());
        let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        2.0 * a.dot(b.cross(c)).atan2(below)
    };
    corners.iter().map(solid_angle).sum::<f64>() / (2.0 * TAU)
}

/// Whether an odd number of times.
fn is_inside(p: DVec3, corners: &[[DVec3; 3]]) -> bool {
    (winding(p, corners).round() as i64).rem_euclid(2) == 1
}

/// Compares every `step`th cell of the fill with the winding number; how many of those are inside.
fn compare(name: &str, stages: &mut Stages, grid: Grid, step: usize) -> u32 {
    let corners = stages.corners();
    let words = stages.filled(grid, false);
    assert_eq!(odd_columns(stages), 0, "{name} leaks");
    let mut inside = 0;
    for (i, found) in (0_u32..).zip(grid.cell_bytes(&words)).step_by(step) {
        let across = grid.cells.x;
        let cell = UVec3::new(i % across, i / across % grid.cells.y, i / across / grid.cells.y).as_dvec3() + 0.5;
        let center = grid.world_point(DVec3::new(cell.x, cell.y, grid.slab(cell.z)));
        let expected = is_inside(center, &corners);
        inside += u32::from(expected);
        if (found == 1) != expected {
            let away = distance(center, &corners) / f64::from(grid.cell_size);
            assert!(away < 1.0 / 128.0, "{name}: cell {cell} is {away} cells from the surface");
        }
    }
    inside
}

#[test]
fn the_interior_is_where_the_winding_number_says() {
    let tilt = Vec3::new(13.0, 31.0, 7.0);
    for (name, shape, half) in [
        ("ball", Shape::Icosphere { radius: 1.0, subdivisions: 2 }, 1.1),
        ("torus", Shape::Torus { radius: 0.8, tube: 0.25, segments: 16 }, 1.2),
        ("box", Shape::Box { min: Vec3::splat(-0.7), max: Vec3::new(0.7, 0.6, 0.5) }, 1.2),
    ] {
        let mut stages = Stages::of_scene(&turned(shape, tilt, vec![]));
        for grid in [around(half, UVec3::new(24, 31, 20)), spot(UVec3::new(30, 25, 28))] {
            let inside = compare(name, &mut stages, grid, 3);
            assert!(inside > 50, "{name}: {inside} cells inside");
        }
    }
    // The truth itself: once around inside, not at all outside.
    let corners = Stages::of(&[Shape::Icosphere { radius: 1.0, subdivisions: 2 }]).corners();
    assert!((winding(DVec3::splat(0.3), &corners) - 1.0).abs() < 1e-9);
    assert!(winding(DVec3::splat(0.9), &corners).abs() < 1e-9);
}

/// A perspective grid that holds a ball.
fn seen(center: DVec3, radius: f64) -> Grid {
    let away = DVec3::new(0.4, 0.5, 0.77).normalize();
    let x = (-away).cross(DVec3::Y).normalize();
    let axes = DMat3::from_cols(x, (-away).cross(x), -away);
    let world_from_eye = DMat4::from_translation(center + away * 3.0 * radius) * DMat4::from_mat3(axes);
    let (near, far) = (1.9 * radius as f32, 4.1 * radius as f32);
    Grid::perspective(world_from_eye, DVec2::splat(-0.4), DVec2::splat(0.4), near, far, UVec3::new(70, 60, 50))
}

/// A model's file, and grids that hold it.
fn in_grids(path: &Path) -> (Stages, [Grid; 2]) {
    let source = Source::File(path.file_name().unwrap().into());
    let scene = Scene {
        models: vec![Model { source, ..Model::default() }],
        folder: path.parent().unwrap().to_owned(),
        ..Scene::default()
    };
    let world = World::load(&scene, None).unwrap();
    let bounds = framing::bounds_at(&scene, &world, 0.0);
    let cell = (bounds.max - bounds.min).max_element() * 1.03 / 64.0;
    let aligned = Grid::world_aligned(bounds.center() - cell * 32.0, cell, UVec3::splat(64));
    (Stages::of_world(&scene, &world), [aligned, seen(bounds.center(), bounds.radius())])
}

#[test]
fn an_open_model_reports_its_leaky_columns() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/shell.glb");
    let (mut stages, grids) = in_grids(&path);
    for grid in grids {
        stages.filled(grid, false);
        let odd = odd_columns(&stages);
        assert!(odd > 10 && odd < grid.cells.x * grid.cells.y / 2, "{odd} odd columns");
    }
}

/// Other people's models, where they are; all of these are closed.
#[test]
fn the_interior_of_scanned_and_animated_bodies_is_where_the_winding_number_says() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/models");
    for (file, step) in [
        ("static/bunny_69666_closed.glb", 4001),
        ("static/dragon_100000.glb", 3203),
        ("static/spot_5856.glb", 1009),
        ("animated/Fox.glb", 97),
    ] {
        let path = folder.join(file);
        if !path.exists() {
            left_out(file, &format!("{} is not there", path.display()));
            continue;
        }
        let (mut stages, grids) = in_grids(&path);
        for grid in grids {
            let inside = compare(file, &mut stages, grid, step);
            assert!(inside > 0, "{file}: no cell inside");
        }
    }
}
