//! A saved volume is a model: it is shown, lit and refracted with the materials it was saved with.

use super::{file, material};
use crate::gpu;
use crate::optics::{exit_errors, spread};
use crate::support::scene_of;
use glam::{DVec3, UVec2, UVec3, Vec3};
use murrine::grid::Grid;
use murrine::headless;
use murrine::scene::description::{Camera, Cells, MaterialOverride, Model, Scene, Shape, Source};
use murrine::scene::{World, voxels};
use murrine::voxel_file::{VoxelFormat, write};
use std::collections::HashMap;
use std::path::Path;

/// Saves the voxels of a scene in a grid of `cells`³ about the origin.
fn save(scene: &Scene, half: f64, cells: u32, solid: bool, path: &Path) {
    let world = World::load(scene, None).unwrap();
    let grid = Grid::world_aligned(DVec3::splat(-half), 2.0 * half / f64::from(cells), UVec3::splat(cells));
    let (body, _) = headless::voxel_body(gpu(), scene, &world, 0.0, grid, solid).unwrap();
    write(path, VoxelFormat::Npz, &body).unwrap();
}

#[test]
fn parts_come_back_closed_with_their_materials_and_on_the_surface_that_was_saved() {
    for solid in [true, false] {
        let loaded = voxels::parse(&file("npz", solid), "a.npz").unwrap();
        let geometry = &loaded.geometry;
        assert!(loaded.warnings.is_empty());
        let names: Vec<&str> = geometry.parts.iter().map(|p| p.name.as_str()).collect();
        assert_eq!(names, ["ball/icosphere", "box/box"]);
        let (ball, boxed) = (&geometry.parts[0].material, &geometry.parts[1].material);
        let saved = material(0);
        assert_eq!((ball.ior, ball.sigma, ball.opaque), (saved.ior, saved.sigma, false));
        assert_eq!((boxed.opaque, boxed.priority, boxed.roughness), (true, 3, 0.5));
        for part in &geometry.parts {
            let own = &geometry.triangles[part.triangles.start as usize..part.triangles.end as usize];
            let mut edges: HashMap<(u32, u32), i32> = HashMap::new();
            for t in own {
                for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                    *edges.entry((a.min(b), a.max(b))).or_default() += if a < b { 1 } else { -1 };
                }
            }
            assert!(own.len() > 1000 && edges.values().all(|n| *n == 0), "{}: open", part.name);
        }
        let ball = &geometry.parts[0];
        let mut worst = (0.0_f32, 1.0_f32);
        for vertex in &geometry.vertices[ball.vertices.start as usize..ball.vertices.end as usize] {
            let radius = vertex.position.length();
            worst = (worst.0.max((radius - 0.8).abs()), worst.1.min(vertex.normal.dot(vertex.position / radius)));
        }
        // A cell is 0.1: the faces themselves lie up to 0.09 off the ball, and lean by up to 55°.
        assert!(worst.0 < 0.02, "solid {solid}: corners are off the ball by {}", worst.0);
        assert!(worst.1 > 0.99, "solid {solid}: normals are off by {}°", worst.1.acos().to_degrees());
    }
}

#[test]
fn a_saved_ball_of_glass_refracts_nearly_as_the_ball_did() {
    let folder = tempfile::tempdir().unwrap();
    let glass = MaterialOverride { ior: Some(1.5), ..MaterialOverride::default() };
    let ball = Model {
        name: "ball".to_owned(),
        source: Source::Shape(Shape::Icosphere { radius: 1.0, subdivisions: 5 }),
        materials: vec![glass],
        ..Model::default()
    };
    let scene = Scene { models: vec![ball], ..Scene::default() };
    let medians = [32, 64].map(|cells| {
        let path = folder.path().join(format!("{cells}.npz"));
        save(&scene, 1.1, cells, true, &path);
        let file = path.file_name().unwrap().into();
        let model = Model { name: "saved".to_owned(), source: Source::File(file), ..Model::default() };
        let mut scene = scene_of(vec![model]);
        scene.folder = folder.path().to_owned();
        scene.camera = Camera { eye: Vec3::new(0.0, 0.0, 5.0), fov_deg: 30.0, ..Camera::default() };
        scene.grid.cells = Cells::Longest(128);
        spread(exit_errors(&scene, UVec2::splat(96), 1.5).0).0
    });
    // Straight through it would be 31°; the mesh itself is below 0.01°.
    assert!(medians[0] < 3.0 && medians[1] < 1.2, "{medians:?} degrees");
    assert!(medians[1] < medians[0], "{medians:?} degrees: finer is truer");
}

#[test]
fn glass_within_glass_keeps_both_media() {
    let folder = tempfile::tempdir().unwrap();
    let ball = |name: &str, radius: f32, ior: f32, priority: i32| Model {
        name: name.to_owned(),
        source: Source::Shape(Shape::Icosphere { radius, subdivisions: 4 }),
        materials: vec![MaterialOverride { ior: Some(ior), priority: Some(priority), ..MaterialOverride::default() }],
        ..Model::default()
    };
    let scene = Scene { models: vec![ball("outer", 1.0, 1.5, 0), ball("inner", 0.5, 1.1, 1)], ..Scene::default() };
    let path = folder.path().join("nested.npz");
    save(&scene, 1.1, 44, true, &path);
    let geometry = voxels::read(&path).unwrap().geometry;
    let volume = |part: usize| -> f64 {
        let range = &geometry.parts[part].triangles;
        let of_triangle = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| geometry.vertices[v as usize].position.as_dvec3());
            a.dot(b.cross(c)) / 6.0
        };
        geometry.triangles[range.start as usize..range.end as usize].iter().map(of_triangle).sum()
    };
    let ball = |radius: f64| 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    // Each cell has one part: the outer one is a shell about the inner.
    assert!((volume(1) / ball(0.5) - 1.0).abs() < 0.03, "{}", volume(1) / ball(0.5));
    assert!((volume(0) / (ball(1.0) - ball(0.5)) - 1.0).abs() < 0.03, "{}", volume(0) / (ball(1.0) - ball(0.5)));
    assert_eq!(geometry.parts[1].material.ior, 1.1);
}
