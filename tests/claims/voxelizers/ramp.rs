//! Attributes go on across what is drawn in a triangle's stead as they run across the triangle (RB §3.6).

use crate::gpu;
use crate::support::render_with;
use glam::{UVec2, Vec3};
use murrine::frame::Frame;
use murrine::march::Channel;
use murrine::scene::description::{
    Background, Camera, Cells, Conservative, Hit, Model, Scene, Shape, Source, VoxelizerSettings,
};
use murrine::scene::geometry::{Geometry, RestVertex, uv_from_color};
use murrine::scene::{World, shapes};
use std::sync::Arc;

/// Quads along a side of the sheet.
const QUADS: u16 = 9;
/// Half a side.
const HALF: f32 = 0.8;
/// Pixels along a side of the picture.
const PIXELS: u32 = 96;
/// The camera is so far away that its rays are all but parallel.
const FAR: f32 = 60.0;

/// A colour that runs evenly across the sheet.
fn even(p: Vec3) -> Vec3 {
    Vec3::new(0.5 + 0.4 * p.x, 0.5 + 0.4 * p.y, 0.5 + 0.2 * (p.x - p.y))
}

/// One that does not.
fn bent(p: Vec3) -> Vec3 {
    even(p) * even(p)
}

/// A leaning sheet of uneven triangles, opaque, that gives off its corners' colours.
fn sheet(color: fn(Vec3) -> Vec3) -> Geometry {
    let mut geometry = shapes::shape(&Shape::Box { min: Vec3::NEG_ONE, max: Vec3::ONE });
    let side = usize::from(QUADS) + 1;
    let at = |i: usize| {
        let [x, y] = [i % side, i / side].map(|n| n as f32 / f32::from(QUADS) * 2.0 - 1.0);
        // Inner corners stray, so that triangles are of all shapes.
        let inner = |v: f32| v.abs() < 0.99;
        let stray = if inner(x) && inner(y) { 0.07 * (7.0 * x + 11.0 * y).sin() } else { 0.0 };
        let (x, y) = (HALF * (x + stray), HALF * (y - stray));
        Vec3::new(x, y, 0.7 * x + 0.4 * y)
    };
    let vertex = |i| {
        let (u, v) = uv_from_color(color(at(i)));
        RestVertex { position: at(i), u, normal: Vec3::new(-0.7, -0.4, 1.0).normalize(), v }
    };
    geometry.vertices = (0..side * side).map(vertex).collect();
    geometry.influences = vec![geometry.influences[0]; side * side];
    let quad = |i: usize| {
        let corner = (i / usize::from(QUADS)) * side + i % usize::from(QUADS);
        let [a, b, c, d] = [corner, corner + 1, corner + side + 1, corner + side].map(|n| u32::try_from(n).unwrap());
        [[a, b, c], [a, c, d]]
    };
    geometry.triangles = (0..usize::from(QUADS).pow(2)).flat_map(quad).collect();
    let part = &mut geometry.parts[0];
    part.vertices = 0..u32::try_from(side * side).unwrap();
    part.triangles = 0..u32::from(QUADS).pow(2) * 2;
    (part.flat, part.vertex_colors, part.material.unlit, part.material.opaque) = (false, true, true, true);
    geometry.measure();
    geometry
}

/// The sheet's picture by its voxels: the largest error of a pixel against `even`, and how many pixels there are.
fn worst(color: fn(Vec3) -> Vec3, conservative: Conservative) -> (f32, u32) {
    let model = Model { source: Source::Shape(Shape::Box { min: Vec3::NEG_ONE, max: Vec3::ONE }), ..Model::default() };
    let mut scene = Scene {
        models: vec![model],
        background: Background::Color { color: Vec3::ZERO },
        camera: Camera { eye: Vec3::Z * FAR, fov_deg: 2.0 * (1.1 / FAR).atan().to_degrees(), ..Camera::default() },
        ..Scene::default()
    };
    scene.grid.cells = Cells::Longest(24);
    scene.effect.hit = Hit::Voxel;
    scene.effect.reflection = false;
    scene.voxelizer = VoxelizerSettings {
        method: "slicemap".into(),
        conservative,
        conservative_depth: conservative != Conservative::None,
        ..VoxelizerSettings::default()
    };
    let world = World::from_geometry(&scene, vec![Arc::new(sheet(color))]);
    let mut frame = Frame::new(gpu()).unwrap();
    let seen = render_with(&mut frame, &scene, &world, UVec2::splat(PIXELS), Channel::Beauty);
    let (mut worst, mut count) = (0.0_f32, 0);
    for (i, [r, g, b, _]) in (0_u32..).zip(&seen.radiance) {
        let radiance = Vec3::new(*r, *g, *b);
        if radiance == Vec3::ZERO {
            continue;
        }
        let place = |n: u32| ((n as f32 + 0.5) / PIXELS as f32 * 2.0 - 1.0) * 1.1;
        // Straight behind the pixel, on the sheet's plane.
        let p = Vec3::new(place(i % PIXELS), -place(i / PIXELS), 0.0);
        worst = worst.max((radiance - even(p)).abs().max_element());
        count += 1;
    }
    (worst, count)
}

/// What half a slice between a step and the leaning sheet moves a colour.
const STEP: f32 = 0.03;

#[test]
fn a_colour_that_runs_evenly_across_a_sheet_runs_on_in_voxels_that_only_dilated_triangles_reach() {
    let (error, plain) = worst(even, Conservative::None);
    assert!(error < STEP, "{error}");
    for way in [Conservative::Polygon, Conservative::Dilated] {
        let (error, pixels) = worst(even, way);
        assert!(error < STEP, "{way:?}: {error}");
        assert!(pixels * 10 > plain * 11, "{way:?}: {pixels} pixels, {plain} without");
    }
    let (error, _) = worst(bent, Conservative::Dilated);
    assert!(error > 5.0 * STEP, "{error}");
}
