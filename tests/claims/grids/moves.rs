//! The grids of a whole scene while its camera or a body moves slowly: cells keep their size and shift by whole cells.

use super::phase;
use glam::{DVec3, Vec3};
use murrine::grid::Grid;
use murrine::scene::World;
use murrine::scene::description::{Align, Light, LightKind, MaterialOverride, Model, Scene, Shape, Source};
use murrine::voxel_cameras::VoxelCameras;

fn scene(align: Align) -> Scene {
    let model = |shape, opaque| Model {
        source: Source::Shape(shape),
        materials: vec![MaterialOverride { opaque: Some(opaque), ..MaterialOverride::default() }],
        ..Model::default()
    };
    let mut scene = Scene {
        models: vec![
            model(Shape::Torus { radius: 0.8, tube: 0.25, segments: 32 }, false),
            model(Shape::Icosphere { radius: 0.2, subdivisions: 2 }, true),
            model(Shape::Plane { size: 60.0 }, true),
        ],
        lights: vec![Light {
            kind: LightKind::Directional { direction: Vec3::new(0.4, -1.0, 0.3).normalize() },
            ..Light::default()
        }],
        ..Scene::default()
    };
    scene.camera.eye = Vec3::new(2.0, 1.0, 4.0);
    scene.grid.align = align;
    scene
}

/// View, scene and light.
fn grids(scene: &Scene, world: &World) -> Vec<Grid> {
    let grids = VoxelCameras::fit(scene, world, &world.materials(scene), &world.pose(scene, 0.0)).grids;
    assert_eq!(grids.len(), 3);
    grids
}

#[test]
fn a_body_that_drifts_shifts_every_grid_by_whole_cells_and_changes_no_cell() {
    let fixed = DVec3::new(0.05, -0.04, 0.03);
    for align in [Align::Camera, Align::World] {
        let mut scene = scene(align);
        let world = World::load(&scene, None).unwrap();
        let first = grids(&scene, &world);
        let mut shifts = [0; 3];
        let mut last = first.clone();
        for step in 0..80_u8 {
            let off = Vec3::new(0.9, 0.5, -0.7) * 1.3e-3 * f32::from(step);
            for model in &mut scene.models[..2] {
                model.translate = off;
            }
            let now = grids(&scene, &world);
            for (number, (grid, was)) in now.iter().zip(&first).enumerate() {
                assert_eq!(grid.cell_size, was.cell_size, "grid {number}, step {step}");
                assert_eq!(grid.cells, was.cells, "grid {number}, step {step}");
                let moved = phase(grid, fixed) - phase(was, fixed);
                let moved = (moved - moved.round()).abs().max_element();
                assert!(moved < 2e-3, "{align:?}, grid {number}, step {step}: cells swim by {moved}");
                shifts[number] += i32::from(grid != &last[number]);
            }
            last = now;
        }
        // They follow, by a cell now and then, not at every step.
        assert!(shifts.iter().all(|s| (2..60).contains(s)), "{align:?}: {shifts:?} shifts in 80 steps");
    }
}

#[test]
fn a_camera_that_walks_moves_no_grid_and_one_that_turns_moves_its_own_alone() {
    for align in [Align::Camera, Align::World] {
        let mut scene = scene(align);
        let world = World::load(&scene, None).unwrap();
        let first = grids(&scene, &world);
        // Sideways and forward, by steps that are exact in f32, so that the direction is the same to the last bit.
        for step in [Vec3::new(0.25, 0.0, 0.0), Vec3::new(0.0, 0.5, -0.125)] {
            scene.camera.eye += step;
            scene.camera.target += step;
            assert!(grids(&scene, &world) == first, "{align:?}: a walk changes a grid");
        }
        scene.camera.eye.x += 0.01;
        let turned = grids(&scene, &world);
        assert!(turned[1..] == first[1..], "{align:?}: the scene's and the light's grids know no camera");
        assert_eq!(turned[0] == first[0], align == Align::World);
    }
}
