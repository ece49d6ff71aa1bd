//! Every effect runs on what every method marks.

use crate::gpu;
use crate::support::{glass, render_with, scene_of};
use glam::{UVec2, Vec3};
use murrine::frame::Frame;
use murrine::march::Channel;
use murrine::scene::World;
use murrine::scene::description::{Background, Cells, Fill, GridSettings, Hit, Light, Projection, Refraction, Shape};
use murrine::scene::words::Words;
use murrine::voxelize::METHODS;

#[test]
fn every_method_feeds_every_effect() {
    let size = UVec2::splat(24);
    let mut scene =
        scene_of(vec![glass("ball", Shape::Icosphere { radius: 0.7, subdivisions: 3 }, 1.3, Vec3::new(0.1, 0.4, 0.8))]);
    scene.background = Background::default();
    scene.lights = vec![Light::default()];
    scene.grid.cells = Cells::Longest(24);
    scene.light_grid.cells = Cells::Longest(24);
    let world = World::load(&scene, None).unwrap();
    let mut frame = Frame::new(gpu()).unwrap();
    for method in METHODS {
        let mut pictures = Vec::new();
        scene.voxelizer.method = method.name.into();
        let ways = Refraction::WORDS
            .iter()
            .flat_map(|(refraction, ..)| Hit::WORDS.iter().map(|(hit, ..)| (*refraction, *hit)));
        // The other choices take turns.
        let turns = Fill::WORDS.iter().cycle().zip(Projection::WORDS.iter().cycle());
        for ((refraction, hit), ((fill, ..), (projection, ..))) in ways.zip(turns) {
            scene.grid = GridSettings { projection: *projection, ..scene.grid };
            (scene.effect.refraction, scene.effect.hit, scene.voxelizer.fill) = (refraction, hit, *fill);
            let seen = render_with(&mut frame, &scene, &world, size, Channel::Transmittance);
            let what = format!("{}, {projection:?}, {refraction:?}, {hit:?}, {fill:?}", method.name);
            assert!(seen.radiance.iter().flatten().all(|v| v.is_finite()), "{what}");
            let [r, _, b] = seen.channel_at(12, 12).to_array();
            assert!(b > 0.0 && b < 0.9 && r > b, "{what}: {r} {b} is no glass of this colour");
            pictures.push(seen.radiance);
        }
        assert!(pictures.iter().any(|p| *p != pictures[0]), "{}: no effect changes the picture", method.name);
    }
}
