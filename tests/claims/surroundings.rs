//! Background, planes, lights: what rays meet outside the volume is what the scene says.

use crate::{gpu, probe};
use glam::{Mat4, Vec3, Vec3Swizzles, Vec4};
use murrine::gpu::{GpuStruct, buffer};
use murrine::plane_light::PlaneLight;
use murrine::scene::description::{Background, Camera, Light, LightKind};
use murrine::scene::geometry::{Geometry, Part};
use murrine::scene::material::{Material, PartMaterial, flags};
use murrine::scene::world::{EnvironmentMap, WorldPart};
use murrine::scene::{Scene, World};
use murrine::surroundings::{LightData, PlaneData, Surroundings, SurroundingsBuffers, surroundings};
use murrine::volume::Volume;
use std::sync::Arc;

const PROBE: &str = r#"
#include "lib/shading.inc.wgsl"
struct Question { origin: vec3f, what: u32, direction: vec3f, index: u32 }
@group(0) @binding(0) var<uniform> surroundings: Surroundings;
@group(0) @binding(1) var environment: texture_2d<f32>;
@group(0) @binding(2) var environment_sampler: sampler;
@group(0) @binding(3) var<storage, read> materials: array<PartMaterial>;
@group(0) @binding(4) var<storage, read> questions: array<Question>;
@group(0) @binding(5) var<storage, read_write> answers: array<vec4f>;
@group(0) @binding(6) var<uniform> grids: array<Grid, MAX_GRIDS>;
@group(0) @binding(7) var<storage, read> occupancy: array<u32>;
@group(0) @binding(8) var<storage, read> ranks: array<u32>;
@group(0) @binding(9) var<storage, read> records: array<Record>;
@group(0) @binding(10) var<storage, read> light_records: array<vec2u>;
@group(0) @binding(11) var plane_light: texture_2d_array<f32>;

fn floor_at(p: vec3f) -> Seen {
    let up = vec3f(0.0, 1.0, 0.0);
    return Seen(true, p, up, NO_PLANE, vec3f(0.5), 0.0, vec3f(0.0), 0.0, -1.0);
}

// What a clear mirror that faces up shows of the lights alone.
fn mirrored_lights(p: vec3f, direction: vec3f) -> vec3f {
    let up = vec3f(0.0, 1.0, 0.0);
    let way = reflect(direction, up);
    let seen = radiance_of(seen_nothing(p, up, mirror_width(0.0)), p, way, straight_spread())
        - background_from(p, way, straight_spread());
    return fresnel_schlick(-dot(up, direction), 0.04) * seen;
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= arrayLength(&questions) {
        return;
    }
    let q = questions[id.x];
    var answer = vec4f(0.0);
    switch q.what {
        case 0u: { answer = vec4f(background_from(q.origin, q.direction, straight_spread()), 0.0); }
        case 1u: { answer = vec4f(background_irradiance(q.direction), 0.0); }
        case 2u: {
            let hit = nearest_plane(q.origin, q.direction, 1e9);
            answer = vec4f(hit.t, f32(i32(hit.plane)), 0.0, 0.0);
        }
        case 3u: { answer = vec4f(plane_base_color(q.index, q.origin, footprint_from_eye(q.index, q.origin)), 0.0); }
        case 4u: { answer = vec4f(radiance_of(floor_at(q.origin), q.origin - q.direction, q.direction, straight_spread()), 0.0); }
        case 5u: { answer = vec4f(light_arriving(q.index, q.origin).irradiance, 0.0); }
        case 6u: { answer = vec4f(mirrored_lights(q.origin, q.direction), 0.0); }
        default: { answer = vec4f(view_direction(q.direction.xy), 0.0); }
    }
    answers[id.x] = answer;
}
"#;

const BACKGROUND: u32 = 0;
const IRRADIANCE: u32 = 1;
const NEAREST_PLANE: u32 = 2;
const PLANE_COLOR: u32 = 3;
const SHADE_FLOOR: u32 = 4;
const LIGHT_ARRIVING: u32 = 5;
const HIGHLIGHT: u32 = 6;
const VIEW_DIRECTION: u32 = 7;

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Question {
    origin: Vec3,
    what: u32,
    direction: Vec3,
    index: u32,
}

/// A world of one plane of side 8, base colour (1, 0, 0), squares of 1 unit of colour (0, 0, 1).
fn world_with_plane() -> (World, Vec<Material>) {
    let part = Part {
        name: "plane".to_owned(),
        vertices: 0..0,
        triangles: 0..0,
        morph_first: 0,
        morph_count: 0,
        node: 0,
        flat: true,
        vertex_colors: false,
        material: Material::default(),
        variant_materials: Vec::new(),
        plane_half: Some(4.0),
    };
    let geometry = Geometry { parts: vec![part], ..Geometry::default() };
    let world = World {
        models: vec![Arc::new(geometry)],
        parts: vec![WorldPart { model: 0, part: 0, name: "ground/plane".to_owned() }],
        ..World::default()
    };
    let material = Material {
        opaque: true,
        base_color: Vec3::X,
        checker_color: Vec3::Z,
        checker_square: 1.0,
        ..Material::default()
    };
    (world, vec![material])
}

fn ask(scene: &Scene, world: &World, materials: &[Material], questions: &[Question]) -> Vec<Vec4> {
    let pass =
        probe::compile(PROBE, &[Surroundings::LAYOUT, LightData::LAYOUT, PlaneData::LAYOUT, PartMaterial::LAYOUT]);
    let data = surroundings(scene, world, materials, (1.5, 512), &[], None);
    let buffers = SurroundingsBuffers::new(gpu(), world).unwrap();
    buffers.write(gpu(), &data);
    let parts: Vec<PartMaterial> = materials
        .iter()
        .chain([&Material::default()]) // a binding must hold at least one
        .map(|m| PartMaterial { base_color: m.base_color, flags: flags::OPAQUE, ..bytemuck::Zeroable::zeroed() })
        .collect();
    let parts = buffer::storage_with(gpu(), "materials", &parts).unwrap();
    let volume = Volume::new(gpu()).unwrap();
    let plane_light = PlaneLight::new(gpu()).unwrap();
    let bound = [
        ("plane_light", wgpu::BindingResource::TextureView(plane_light.view())),
        ("surroundings", buffers.data.as_entire_binding()),
        ("environment", wgpu::BindingResource::TextureView(&buffers.environment)),
        ("environment_sampler", wgpu::BindingResource::Sampler(&buffers.sampler)),
        ("materials", parts.as_entire_binding()),
        ("grids", volume.grid_data.as_entire_binding()),
        ("occupancy", volume.occupancy.as_entire_binding()),
        ("ranks", volume.ranks.as_entire_binding()),
        ("records", volume.records.as_entire_binding()),
        ("light_records", volume.light_records.as_entire_binding()),
    ];
    probe::ask(&pass, &bound, questions)
}

fn question(what: u32, origin: Vec3, direction: Vec3) -> Question {
    Question { origin, what, direction, index: 0 }
}

fn close(a: Vec4, b: Vec3, tolerance: f32) -> bool {
    (a.truncate() - b).abs().max_element() <= tolerance
}

fn directions() -> Vec<Vec3> {
    (0..200)
        .map(|i| {
            let y = 1.0 - 2.0 * (i as f32 + 0.5) / 200.0;
            let (s, c) = (i as f32 * 2.399_963).sin_cos();
            Vec3::new(c * (1.0 - y * y).sqrt(), y, s * (1.0 - y * y).sqrt())
        })
        .collect()
}

#[test]
fn the_sky_is_the_gradient_that_the_scene_gives() {
    let (horizon, zenith, ground) = (Vec3::new(0.9, 0.8, 0.7), Vec3::new(0.1, 0.2, 0.9), Vec3::new(0.3, 0.2, 0.1));
    let background = Background::Sky { horizon, zenith, ground, exponent: 0.6, intensity: 2.0 };
    let scene = Scene { background, ..Scene::default() };
    let far_from_horizon: Vec<Vec3> = directions().into_iter().filter(|d| d.y.abs() > 0.01).collect();
    let questions: Vec<_> = far_from_horizon.iter().map(|d| question(BACKGROUND, Vec3::ZERO, *d)).collect();
    let answers = ask(&scene, &World::default(), &[], &questions);
    for (direction, answer) in far_from_horizon.iter().zip(&answers) {
        let truth = 2.0 * if direction.y < 0.0 { ground } else { horizon.lerp(zenith, direction.y.powf(0.6)) };
        assert!(close(*answer, truth, 2e-3), "{direction}: {answer} instead of {truth}");
        assert!(!close(*answer, truth.zxy(), 2e-3), "channels must not be mixed up");
    }
}

#[test]
fn an_environment_is_seen_where_its_picture_says_and_sheds_light_that_is_finite() {
    // Each texel a colour of its own; one is no number, one brighter than a half float can say.
    let (width, height) = (16_u32, 8_u32);
    let color = |x: u32, y: u32| [x as f32 / 16.0, y as f32 / 8.0, 0.5];
    let mut rgb: Vec<[f32; 3]> = (0..width * height).map(|i| color(i % width, i / width)).collect();
    rgb[0] = [f32::NAN, f32::INFINITY, 1e30];
    let world = World { environment: Some(Arc::new(EnvironmentMap { width, height, rgb })), ..World::default() };
    let rotate_deg = 33.0;
    let background = Background::Environment { file: "sky.hdr".into(), rotate_deg, intensity: 3.0 };
    let scene = Scene { background, ..Scene::default() };
    let texel_center = |x: u32, y: u32| {
        let theta = std::f32::consts::PI * (y as f32 + 0.5) / height as f32;
        let phi = std::f32::consts::TAU * ((x as f32 + 0.5) / width as f32 - 0.5);
        let map = Vec3::new(theta.sin() * phi.sin(), theta.cos(), -theta.sin() * phi.cos());
        Mat4::from_rotation_y(rotate_deg.to_radians()).transform_vector3(map)
    };
    let texels: Vec<(u32, u32)> = (1..height).flat_map(|y| (1..width - 1).map(move |x| (x, y))).collect();
    let mut questions: Vec<_> =
        texels.iter().map(|(x, y)| question(BACKGROUND, Vec3::ZERO, texel_center(*x, *y))).collect();
    questions.extend(directions().into_iter().map(|d| question(IRRADIANCE, Vec3::ZERO, d)));
    let answers = ask(&scene, &world, &[], &questions);
    for ((x, y), answer) in texels.iter().zip(&answers) {
        let truth = 3.0 * Vec3::from(color(*x, *y));
        assert!(close(*answer, truth, 0.02), "texel {x}, {y}: {answer} instead of {truth}");
    }
    for answer in &answers[texels.len()..] {
        assert!(answer.is_finite() && answer.truncate().min_element() >= 0.0, "irradiance {answer}");
    }
}

#[test]
fn the_checkerboard_backdrop_stands_beyond_the_target_and_has_parallax() {
    let camera = Camera { eye: Vec3::new(0.0, 0.0, 5.0), target: Vec3::ZERO, up: Vec3::Y, fov_deg: 30.0 };
    let background = Background::Checker { a: Vec3::ONE, b: Vec3::ZERO, square: 0.5, distance: 2.0 };
    let scene = Scene { camera, background, ..Scene::default() };
    // The plane z = −2; squares alternate from its middle.
    let shade = |x: f32, y: f32| 1.0 - ((x / 0.5).floor() + (y / 0.5).floor()).rem_euclid(2.0);
    let points = [(0.2, 0.2), (0.7, 0.2), (-0.2, 0.2), (0.8, 0.8), (-1.3, 0.4), (2.2, -1.7)];
    for origin in [camera.eye, Vec3::new(1.0, -0.5, 1.0)] {
        let questions: Vec<_> = points
            .iter()
            .map(|(x, y)| question(BACKGROUND, origin, (Vec3::new(*x, *y, -2.0) - origin).normalize()))
            .collect();
        for ((x, y), answer) in points.iter().zip(ask(&scene, &World::default(), &[], &questions)) {
            assert!(close(answer, Vec3::splat(shade(*x, *y)), 0.01), "({x}, {y}) from {origin}: {answer}");
        }
    }
}

#[test]
fn planes_are_met_where_they_are_and_their_squares_blend_far_away() {
    let (world, materials) = world_with_plane();
    let mut scene = Scene { models: vec![murrine::scene::description::Model::default()], ..Scene::default() };
    scene.models[0].translate = Vec3::new(0.0, -1.0, 0.0);
    scene.camera.eye = Vec3::new(0.0, 1.0, 3.0);
    let down = Vec3::new(0.3, -1.0, 0.1).normalize();
    let questions = [
        question(NEAREST_PLANE, Vec3::new(0.5, 2.0, 0.5), down),
        question(NEAREST_PLANE, Vec3::new(0.5, 2.0, 0.5), -down),
        question(NEAREST_PLANE, Vec3::new(4.5, 2.0, 0.5), down),
        question(PLANE_COLOR, Vec3::new(0.5, -1.0, 0.5), Vec3::ZERO),
        question(PLANE_COLOR, Vec3::new(-0.5, -1.0, 0.5), Vec3::ZERO),
        question(PLANE_COLOR, Vec3::new(-0.5, -1.0, -0.5), Vec3::ZERO),
    ];
    let answers = ask(&scene, &world, &materials, &questions);
    assert!((answers[0].x - 3.0 / -down.y).abs() < 1e-4 && answers[0].y == 0.0, "{}", answers[0]);
    assert!(answers[1].y < 0.0, "a ray that leaves meets nothing: {}", answers[1]);
    assert!(answers[2].y < 0.0, "a ray beyond the edge meets nothing: {}", answers[2]);
    assert!(close(answers[3], Vec3::X, 1e-3) && close(answers[4], Vec3::Z, 1e-3) && close(answers[5], Vec3::X, 1e-3));

    // From 2,000 units away a pixel holds several squares: their mean.
    scene.camera.eye = Vec3::new(0.0, 2000.0, 0.0);
    let far = ask(&scene, &world, &materials, &questions[3..5]);
    assert!(far.iter().all(|c| close(*c, Vec3::new(0.5, 0.0, 0.5), 0.1)), "{far:?}");
}

#[test]
fn a_matte_floor_sends_back_albedo_over_pi_of_what_arrives() {
    let sun = Light {
        kind: LightKind::Directional { direction: Vec3::new(0.6, -0.8, 0.0) },
        color: Vec3::new(1.0, 0.5, 0.25),
        intensity: 4.0,
        angular_radius_deg: 3.0,
        casts_shadow: true,
    };
    let bulb = Light { kind: LightKind::Point { position: Vec3::new(0.0, 2.0, 0.0) }, color: Vec3::ONE, ..sun };
    let cone =
        LightKind::Spot { position: Vec3::new(0.0, 2.0, 0.0), direction: Vec3::NEG_Y, angle_deg: 30.0, blend: 0.2 };
    let spot = Light { kind: cone, ..bulb };
    let sky = Vec3::new(0.2, 0.3, 0.4);
    let scene =
        Scene { background: Background::Color { color: sky }, lights: vec![sun, bulb, spot], ..Scene::default() };
    let outside_cone = Vec3::new(2.0, 0.0, 0.0);
    let mut questions = vec![
        question(SHADE_FLOOR, Vec3::ZERO, Vec3::NEG_Y),
        question(SHADE_FLOOR, outside_cone, Vec3::NEG_Y),
        question(LIGHT_ARRIVING, outside_cone, Vec3::ZERO),
    ];
    questions[2].index = 2;
    let answers = ask(&scene, &World::default(), &[], &questions);
    let irradiance = |p: Vec3, in_cone: f32| {
        let from_bulb = p - Vec3::new(0.0, 2.0, 0.0);
        let bulb = 4.0 / from_bulb.length_squared() * -from_bulb.normalize().y;
        std::f32::consts::PI * sky + Vec3::new(4.0, 2.0, 1.0) * 0.8 + Vec3::splat(bulb * (1.0 + in_cone))
    };
    for (answer, (p, in_cone)) in answers.iter().zip([(Vec3::ZERO, 1.0), (outside_cone, 0.0)]) {
        let truth = 0.5 / std::f32::consts::PI * irradiance(p, in_cone);
        assert!(close(*answer, truth, 2e-3), "{p}: {answer} instead of {truth}");
        assert!(!close(*answer, 0.5 * truth, 2e-3), "half the light must not pass");
    }
    assert_eq!(answers[2], Vec4::ZERO, "outside its cone a spot sheds nothing");
}

#[test]
fn the_sun_mirrored_in_glass_is_a_bright_disc_and_only_where_the_mirror_points() {
    let sun = Light { kind: LightKind::Directional { direction: Vec3::new(0.6, -0.8, 0.0) }, ..Light::default() };
    let scene = Scene { lights: vec![sun], ..Scene::default() };
    let mirrored = question(HIGHLIGHT, Vec3::ZERO, Vec3::new(-0.6, -0.8, 0.0));
    let aside = question(HIGHLIGHT, Vec3::ZERO, Vec3::new(-0.5, -0.8, 0.3).normalize());
    let answers = ask(&scene, &World::default(), &[], &[mirrored, aside]);
    assert!(answers[0].x > 5.0 && answers[0].is_finite(), "{}", answers[0]);
    assert_eq!(answers[1].truncate(), Vec3::ZERO);
}

#[test]
fn the_pictures_corners_look_where_a_pinhole_does() {
    let camera = Camera { eye: Vec3::ZERO, target: Vec3::NEG_Z, up: Vec3::Y, fov_deg: 60.0 };
    let scene = Scene { camera, ..Scene::default() };
    let at = |x, y| question(VIEW_DIRECTION, Vec3::ZERO, Vec3::new(x, y, 0.0));
    let answers = ask(&scene, &World::default(), &[], &[at(0.5, 0.5), at(0.0, 0.0), at(1.0, 0.5)]);
    let half = 30_f32.to_radians().tan();
    assert!(close(answers[0], Vec3::NEG_Z, 1e-6));
    assert!(close(answers[1], Vec3::new(-1.5 * half, half, -1.0).normalize(), 1e-5), "{}", answers[1]);
    assert!(close(answers[2], Vec3::new(1.5 * half, 0.0, -1.0).normalize(), 1e-5), "{}", answers[2]);
}
