//! The channel `ground-light` against closed forms: for the first opaque surface on a pixel's straight ray, the share of
//! light 0 that absorption lets through.
#![expect(clippy::cast_possible_truncation, reason = "shapes are f32")]

use super::support::{glass, model, opaque, sun};
use super::{AMBER, absorbed, ball, chord, slab};
use crate::support::{pixel_direction, render};
use glam::{DVec3, UVec2, Vec3};
use murrine::march::Channel;
use murrine::scene::description::{Background, Camera, Light, LightKind, Model, Scene, Shadow, Shape};

const SIZE: UVec2 = UVec2::new(96, 80);
const GROUND_Y: f64 = -1.5;
const GROUND_HALF: f64 = 3.0;
const FOV_DEG: f32 = 44.0;

/// Bodies over a ground of side 6, seen from high in front: the picture's upper edge looks past the ground.
fn scene(mut bodies: Vec<Model>, light: Light) -> Scene {
    let mut ground = model(Shape::Plane { size: 2.0 * GROUND_HALF as f32 }, opaque());
    ground.translate.y = GROUND_Y as f32;
    bodies.push(ground);
    Scene {
        models: bodies,
        lights: vec![light],
        background: Background::Color { color: Vec3::ZERO },
        camera: Camera {
            eye: Vec3::new(0.0, 0.5, 7.0),
            target: Vec3::new(0.0, 0.5, 0.0),
            fov_deg: FOV_DEG,
            ..Camera::default()
        },
        ..Scene::default()
    }
}

/// Every pixel's point on the ground with the channel's answer there; rays that pass the ground by must have none.
fn on_ground(scene: &Scene) -> Vec<(DVec3, DVec3)> {
    let picture = render(scene, SIZE, Channel::GroundLight);
    let mut found = Vec::new();
    let mut beside = 0;
    for y in 0..SIZE.y {
        for x in 0..SIZE.x {
            let (eye, d) = (scene.camera.eye.as_dvec3(), pixel_direction(SIZE, f64::from(FOV_DEG), x, y));
            let p = eye + d * ((GROUND_Y - eye.y) / d.y);
            let got = picture.channel_at(x, y);
            if d.y < 0.0 && p.x.abs().max(p.z.abs()) < GROUND_HALF {
                assert!(!got.is_nan(), "({x}, {y}) has no light at {p}");
                found.push((p, got));
            } else {
                beside += 1;
                assert!(got.is_nan(), "({x}, {y}) looks past the ground and has {got}");
            }
        }
    }
    assert!(found.len() > 1500 && beside > 1500, "{} pixels on the ground, {beside} beside it", found.len());
    found
}

/// Mean and largest difference where `truth` has an answer, and over how many pixels that `truth` darkens.
fn compare(found: &[(DVec3, DVec3)], truth: impl Fn(DVec3) -> Option<DVec3>) -> (f64, f64, usize) {
    let (mut sum, mut most, mut count, mut dark) = (0.0, 0.0_f64, 0.0, 0);
    for (p, got) in found {
        let Some(truth) = truth(*p) else { continue };
        let off = (*got - truth).abs();
        sum += off.element_sum() / 3.0;
        most = most.max(off.max_element());
        count += 1.0;
        dark += usize::from(truth.min_element() < 0.9);
    }
    (sum / count, most, dark)
}

fn lights() -> [(&'static str, Light); 3] {
    let position = Vec3::new(0.8, 3.5, -1.0);
    let spot = LightKind::Spot { position, direction: (-position).normalize(), angle_deg: 35.0, blend: 0.1 };
    let lamp = |kind| Light { kind, ..Light::default() };
    [
        ("directional", sun(Vec3::new(0.3, -1.0, 0.45).normalize())),
        ("point", lamp(LightKind::Point { position })),
        ("spot", lamp(spot)),
    ]
}

/// Where light that arrives at `p` comes from.
fn source(light: &Light, p: DVec3) -> DVec3 {
    match light.kind {
        LightKind::Directional { direction } => p - direction.as_dvec3() * 20.0,
        LightKind::Point { position } | LightKind::Spot { position, .. } => position.as_dvec3(),
    }
}

#[test]
fn the_ground_below_a_ball_gets_what_its_chord_leaves_of_every_kind_of_light() {
    for (name, light) in lights() {
        for shadow in [Shadow::BeerLambert, Shadow::Linear] {
            let mut scene = scene(vec![model(ball(1.0), glass(0.5 * AMBER))], light);
            scene.effect.shadow = shadow;
            let found = on_ground(&scene);
            let left = |p: DVec3, radius: f64| {
                let from = source(&light, p);
                let way = (p - from).normalize();
                let off = (from - from.dot(way) * way).length();
                let length = chord(from, p, DVec3::ZERO, radius);
                let left = match shadow {
                    Shadow::Linear => (DVec3::ONE - 0.5 * AMBER.as_dvec3() * length).max(DVec3::ZERO),
                    _ => absorbed(0.5 * AMBER, length),
                };
                // Along the outline a column is half in the clear.
                ((off - 1.0).abs() > 0.07).then_some(left)
            };
            let (mean, most, dark) = compare(&found, |p| left(p, 1.0));
            assert!(dark > 150, "{name}: {dark} pixels lie in the shadow");
            assert!(mean < 2e-3 && most < 0.06, "{name}, {shadow:?}: mean {mean}, most {most}");
            let clear = found.iter().filter(|(p, _)| left(*p, 1.0) == Some(DVec3::ONE));
            assert!(clear.clone().count() > 300 && clear.clone().all(|(_, got)| *got == DVec3::ONE), "{name}");
            let (wrong, ..) = compare(&found, |p| left(p, 0.9));
            assert!(wrong > 2.0 * mean + 4e-3, "{name}: a smaller ball passes as well: {wrong}");
        }
    }
}

/// Length of the way from `a` to `b` between two heights.
fn between(a: DVec3, b: DVec3, low: f64, high: f64) -> f64 {
    (a.y.clamp(low, high) - b.y.clamp(low, high)).abs() / (b - a).normalize().y.abs()
}

#[test]
fn the_ground_below_a_slab_gets_what_its_thickness_leaves_whether_in_one_piece_or_in_two_that_touch() {
    let (low, middle, high) = (-0.4, 0.1, 0.5);
    let sigma = 0.4 * AMBER;
    for (name, light) in lights() {
        let pieces = |edges: &[f32]| edges.windows(2).map(|e| model(slab(e[0], e[1]), glass(sigma))).collect();
        for edges in [&[-0.4, 0.5][..], &[-0.4, 0.1, 0.5]] {
            let found = on_ground(&scene(pieces(edges), light));
            let left = |p: DVec3, high: f64| {
                let from = source(&light, p);
                // Well within the slab's outline, or well without.
                let at = |y: f64| from + (p - from) * ((y - from.y) / (p.y - from.y));
                let ends = [at(-0.4), at(0.5)].map(|e| e.x.abs().max(e.z.abs()));
                let within = ends.iter().all(|e| *e < 0.95);
                within.then(|| absorbed(sigma, between(from, p, low, high)))
            };
            let (mean, most, dark) = compare(&found, |p| left(p, high));
            assert!(dark > 150, "{name}: {dark} pixels lie in the shadow");
            assert!(mean < 2e-3 && most < 0.03, "{name}, {edges:?}: mean {mean}, most {most}");
            let (wrong, ..) = compare(&found, |p| left(p, middle));
            assert!(wrong > 0.02, "{name}: half a slab passes as well: {wrong}");
        }
    }
}

#[test]
fn without_shadows_all_of_the_light_is_left() {
    let mut scene = scene(vec![model(ball(1.0), glass(AMBER))], lights()[0].1);
    scene.effect.shadow = Shadow::None;
    assert!(on_ground(&scene).iter().all(|(_, got)| *got == DVec3::ONE));
}
