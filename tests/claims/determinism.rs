//! The same scene gives the same bytes: a second time, in another process, and whatever was rendered before.

use crate::gpu;
use crate::support::{Rendered, render_with};
use glam::{UVec2, Vec3};
use murrine::frame::Frame;
use murrine::march::Channel;
use murrine::scene::World;
use murrine::scene::description::{
    Cells, Deformer, Fill, GridSettings, Hit, Light, LightKind, MaterialOverride, Model, Refraction, Scene, Shape,
    Source,
};
use murrine::voxelize;
use std::path::Path;
use std::process::Command;

/// One tile of a rasterizer is one thread's work: a picture of several tiles can tell.
const SIZE: UVec2 = UVec2::new(136, 130);

fn model(name: &str, shape: Shape, material: MaterialOverride) -> Model {
    Model { name: name.to_owned(), source: Source::Shape(shape), materials: vec![material], ..Model::default() }
}

/// Twisted glass with an opaque core over a ground, under a sun and a lamp.
fn scene() -> Scene {
    let glass =
        MaterialOverride { ior: Some(1.4), sigma: Some(Vec3::new(0.2, 0.5, 0.9)), ..MaterialOverride::default() };
    let stone = MaterialOverride { opaque: Some(true), ..MaterialOverride::default() };
    let mut ring = model("ring", Shape::Torus { radius: 0.8, tube: 0.3, segments: 48 }, glass.clone());
    ring.deformers = vec![Deformer::Twist { axis: 0, deg_per_unit: 60.0, hz: 0.0 }];
    ring.rotate_deg.x = 60.0;
    let mut ground = model("ground", Shape::Plane { size: 20.0 }, stone.clone());
    ground.translate.y = -1.2;
    let core = model("core", Shape::Icosphere { radius: 0.3, subdivisions: 3 }, stone);
    let grid = GridSettings { cells: Cells::Longest(48), ..GridSettings::default() };
    let lamp = LightKind::Point { position: Vec3::new(-2.0, 3.0, 1.0) };
    Scene {
        models: vec![ring, core, ground],
        lights: vec![Light::default(), Light { kind: lamp, intensity: 20.0, ..Light::default() }],
        grid,
        light_grid: grid,
        ..Scene::default()
    }
}

/// Each voxelizer with each way of refraction and of hitting; the eager fill beside the lazy one.
fn ways() -> Vec<Scene> {
    let mut ways = Vec::new();
    for method in voxelize::METHODS {
        for refraction in [Refraction::None, Refraction::Single, Refraction::TwoSurface, Refraction::MultipleSurface] {
            for hit in [Hit::Surfel, Hit::Voxel] {
                // The one on the host takes long: one way shows what its words do.
                if method.name == "cpu-exact" && (refraction, hit) != (Refraction::MultipleSurface, Hit::Surfel) {
                    continue;
                }
                let mut scene = scene();
                method.name.clone_into(&mut scene.voxelizer.method);
                scene.voxelizer.fill = if hit == Hit::Voxel { Fill::Eager } else { Fill::Lazy };
                (scene.effect.refraction, scene.effect.hit) = (refraction, hit);
                ways.push(scene);
            }
        }
    }
    ways
}

fn bytes(rendered: &Rendered) -> (Vec<u8>, Vec<u8>) {
    (bytemuck::cast_slice(&rendered.radiance).to_vec(), bytemuck::cast_slice(&rendered.channel).to_vec())
}

#[test]
fn every_way_gives_the_same_bytes_again_in_another_order_and_after_other_scenes() {
    let ways = ways();
    let world = World::load(&ways[0], None).unwrap();
    let mut other = scene();
    other.models[0].source = Source::Shape(Shape::Icosphere { radius: 1.3, subdivisions: 3 });
    other.grid.cells = Cells::Longest(100);
    let other_world = World::load(&other, None).unwrap();

    let mut frame = Frame::new(gpu()).unwrap();
    let first: Vec<_> =
        ways.iter().map(|way| bytes(&render_with(&mut frame, way, &world, SIZE, Channel::Transmittance))).collect();
    let mut frame = Frame::new(gpu()).unwrap();
    for (number, (way, first)) in ways.iter().zip(&first).enumerate().rev() {
        if number % 7 == 0 {
            other.voxelizer = way.voxelizer.clone();
            render_with(&mut frame, &other, &other_world, SIZE / 2, Channel::Normal);
        }
        let again = bytes(&render_with(&mut frame, way, &world, SIZE, Channel::Transmittance));
        let (voxelizer, effect) = (&way.voxelizer.method, way.effect);
        assert!(again == *first, "{voxelizer}, {:?}, {:?}", effect.refraction, effect.hit);
    }
    // Ways of one voxelizer differ from each other: what is compared is not blank.
    for (i, a) in first[..8].iter().enumerate() {
        assert!(first[i + 1..8].iter().all(|b| a.0 != b.0), "way {i} looks like another");
    }
}

#[test]
fn two_processes_write_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/two-lights.toml");
    let render = |name: &str, sets: &[&str]| {
        let file = folder.path().join(name);
        let mut command = Command::new(env!("CARGO_BIN_EXE_murrine"));
        command.arg("render").arg(&scene).arg("-o").arg(&file).args(["--size", "136x130", "--adapter", "software"]);
        let output = command.args(["--time", "0.3", "--grid", "64"]).args(sets).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        std::fs::read(file).unwrap()
    };
    let first = render("a.npy", &[]);
    assert!(first.len() > 136 * 130 * 12 && first == render("b.npy", &[]));
    assert!(first != render("c.npy", &["--set", "effect.hit=voxel"]), "another way gives other bytes");
}
