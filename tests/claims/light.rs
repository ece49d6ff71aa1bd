//! The light volume: what is left of a light at a point is what absorption on the straight way to it leaves.
//!
//! Truths are worked out here, in f64, from the shapes themselves. Grids are the program's own, about 128 cells long.

mod ground;
mod support;

use crate::probe;
use glam::{DVec3, Vec3, Vec3Swizzles};
use murrine::scene::World;
use murrine::scene::description::{Cells, Light, LightKind, Model, Scene, Shadow, Shape};
use murrine::scene::material::Material;
use std::sync::Arc;
use support::{Lit, glass, model, opaque, sun};

/// Mean and largest difference, over all points and channels.
fn compare(answers: &[Vec3], truth: impl Fn(usize) -> DVec3) -> (f64, f64) {
    let differences = answers.iter().enumerate().map(|(i, answer)| (answer.as_dvec3() - truth(i)).abs());
    let (sum, most) =
        differences.fold((0.0, 0.0_f64), |(sum, most), d| (sum + d.element_sum() / 3.0, most.max(d.max_element())));
    (sum / answers.len() as f64, most)
}

fn absorbed(sigma: Vec3, length: f64) -> DVec3 {
    (sigma.as_dvec3() * -length).exp()
}

/// Length of the segment from `a` to `b` inside a ball.
fn chord(a: DVec3, b: DVec3, center: DVec3, radius: f64) -> f64 {
    let along = (b - a).normalize();
    let middle = (center - a).dot(along);
    let off = (a + along * middle - center).length();
    let half = (radius * radius - off * off).max(0.0).sqrt();
    ((middle + half).clamp(0.0, (b - a).length()) - (middle - half).clamp(0.0, (b - a).length())).max(0.0)
}

/// Points evenly over a disc in the plane y = `height`.
fn disc(center: Vec3, radius: f32, height: f32) -> Vec<Vec3> {
    (0..900)
        .map(|i| {
            let r = radius * ((i as f32 + 0.5) / 900.0).sqrt();
            let (s, c) = (i as f32 * 2.399_963).sin_cos();
            Vec3::new(center.x + r * c, height, center.z + r * s)
        })
        .collect()
}

const AMBER: Vec3 = Vec3::new(0.3, 0.9, 1.8);

fn ball(radius: f32) -> Shape {
    Shape::Icosphere { radius, subdivisions: 6 }
}

fn slab(low: f32, high: f32) -> Shape {
    Shape::Box { min: Vec3::new(-1.0, low, -1.0), max: Vec3::new(1.0, high, 1.0) }
}

/// Three slabs one over another, each with its own colour.
fn stack() -> (Vec<Model>, [(f32, f32, Vec3); 3]) {
    let slabs = [
        (0.2, 0.5, Vec3::new(1.0, 0.2, 0.1)),
        (0.7, 0.8, Vec3::new(0.5, 3.0, 1.0)),
        (1.0, 1.3, Vec3::new(0.0, 0.4, 2.0)),
    ];
    (slabs.iter().map(|(low, high, sigma)| model(slab(*low, *high), glass(*sigma))).collect(), slabs)
}

#[test]
fn the_shadow_of_stacked_slabs_is_the_product_of_their_absorptions_at_every_depth() {
    let (models, slabs) = stack();
    for direction in [Vec3::NEG_Y, Vec3::new(0.3, -1.0, -0.2).normalize()] {
        let lit = Lit::new(&Scene { models: models.clone(), lights: vec![sun(direction)], ..Scene::default() });
        for height in [-0.5, 0.1, 0.33, 0.6, 0.77, 0.9, 1.1, 1.4] {
            // Well within the slabs as the light sees them.
            let points = disc(direction * (1.0 / -direction.y) * (0.7 - height), 0.4, height);
            let truth = |share: f64| {
                let depth = |(low, high, sigma): &(f32, f32, Vec3)| {
                    let above = f64::from((high - height.clamp(*low, *high)) / -direction.y);
                    sigma.as_dvec3() * above
                };
                (slabs.iter().map(depth).sum::<DVec3>() * -share).exp()
            };
            let answers = lit.absorption(0, &points, Vec3::ZERO);
            let (mean, most) = compare(&answers, |_| truth(1.0));
            assert!(mean < 2e-3 && most < 0.02, "height {height}, light {direction}: mean {mean}, most {most}");
            if height < 0.5 {
                let (wrong, _) = compare(&answers, |_| truth(0.5));
                assert!(wrong > 0.05, "half the absorption must not pass: {wrong}");
            }
        }
    }
}

#[test]
fn the_shadow_of_a_ball_follows_its_chords_in_every_colour() {
    let direction = Vec3::new(0.4, -1.0, 0.25).normalize();
    let scene =
        Scene { models: vec![model(ball(1.0), glass(AMBER))], lights: vec![sun(direction)], ..Scene::default() };
    let lit = Lit::new(&scene);
    let points = in_shadow_of_ball(direction, 0.95);
    let answers = lit.absorption(0, &points, Vec3::ZERO);
    let truth = |i: usize, share: f64| {
        let p = points[i].as_dvec3();
        absorbed(AMBER, share * chord(p - direction.as_dvec3() * 10.0, p, DVec3::ZERO, 1.0))
    };
    let (mean, most) = compare(&answers, |i| truth(i, 1.0));
    assert!(mean < 4e-3 && most < 0.04, "mean {mean}, most {most}");
    assert!(compare(&answers, |i| truth(i, 0.5)).0 > 0.05, "half the absorption must not pass");
    assert!(compare(&answers, |i| truth(i, 1.0).zxy()).0 > 0.05, "mixed up channels must not pass");

    let beside = in_shadow_of_ball(direction, 1.3).into_iter().filter(|p| {
        let off = p.as_dvec3() - direction.as_dvec3() * p.as_dvec3().dot(direction.as_dvec3());
        off.length() > 1.05
    });
    let beside: Vec<Vec3> = beside.collect();
    let answers = lit.absorption(0, &beside, Vec3::ZERO);
    assert!(answers.iter().all(|a| *a == Vec3::ONE), "beside the shadow all light arrives");
    assert!(lit.absorption(0, &[Vec3::new(40.0, 0.0, 0.0), Vec3::new(0.0, 9.0, 0.0)], Vec3::ZERO) == [Vec3::ONE; 2]);
}

/// Points of the ground y = −1.5 that the light meets after passing the unit ball within `radius` of its middle.
fn in_shadow_of_ball(direction: Vec3, radius: f32) -> Vec<Vec3> {
    let x = direction.any_orthonormal_vector();
    let y = direction.cross(x);
    disc(Vec3::ZERO, radius, 0.0)
        .into_iter()
        .map(|p| {
            let across = x * p.x + y * p.z;
            across + direction * ((-1.5 - across.y) / direction.y)
        })
        .collect()
}

#[test]
fn light_falls_on_a_ball_within_a_ball_and_the_inner_glass_rules() {
    let (outer, inner) = (AMBER, Vec3::new(2.0, 0.1, 0.5));
    let center = Vec3::new(0.1, -0.1, 0.05);
    let mut core = model(ball(0.5), glass(inner));
    core.translate = center;
    core.materials[0].priority = Some(1);
    let direction = Vec3::new(-0.2, -1.0, 0.5).normalize();
    let scene =
        Scene { models: vec![core, model(ball(1.0), glass(outer))], lights: vec![sun(direction)], ..Scene::default() };
    let lit = Lit::new(&scene);
    let from = |p: DVec3| p - direction.as_dvec3() * 10.0;
    let left = |p: DVec3| {
        let within = chord(from(p), p, center.as_dvec3(), 0.5);
        absorbed(outer, chord(from(p), p, DVec3::ZERO, 1.0) - within) * absorbed(inner, within)
    };
    let ground = in_shadow_of_ball(direction, 0.9);
    let (mean, most) = compare(&lit.absorption(0, &ground, Vec3::ZERO), |i| left(ground[i].as_dvec3()));
    assert!(mean < 5e-3 && most < 0.1, "through both: mean {mean}, most {most}");

    // On the inner ball's lit side, and in the middle of both.
    let sunny = |i: i32| {
        let (s, c) = (i as f32 * 2.4).sin_cos();
        let x = direction.any_orthonormal_vector();
        let off = (x * c + direction.cross(x) * s) * (i as f32 / 50.0) * 0.9;
        center + 0.5 * (off - direction).normalize()
    };
    let points: Vec<Vec3> = (0..50).map(sunny).chain([center, Vec3::new(0.6, 0.1, 0.0)]).collect();
    let answers = lit.absorption(0, &points, Vec3::ZERO);
    let (mean, most) = compare(&answers, |i| left(points[i].as_dvec3()));
    assert!(mean < 0.01 && most < 0.06, "on and in the inner ball: mean {mean}, most {most}");
    assert!(answers.iter().all(|a| a.x < 0.99), "the outer ball must dim the inner one");
}

#[test]
fn the_papers_linear_sum_is_one_minus_absorption_times_length() {
    let direction = Vec3::new(0.1, -1.0, 0.1).normalize();
    let (models, sigma) = (vec![model(slab(0.2, 0.5), glass(Vec3::new(0.5, 1.5, 9.0)))], DVec3::new(0.5, 1.5, 9.0));
    let mut scene = Scene { models, lights: vec![sun(direction)], ..Scene::default() };
    let length = 0.3 / f64::from(-direction.y);
    let points = disc(Vec3::ZERO, 0.4, 0.0);
    scene.effect.shadow = Shadow::Linear;
    let linear = Lit::new(&scene).absorption(0, &points, Vec3::ZERO);
    let (mean, most) = compare(&linear, |_| (DVec3::ONE - sigma * length).max(DVec3::ZERO));
    assert!(mean < 2e-3 && most < 0.02, "mean {mean}, most {most}");
    let (wrong, _) = compare(&linear, |_| (sigma * -length).exp());
    assert!(wrong > 0.02, "the linear sum must not be the exponential: {wrong}");
    scene.effect.shadow = Shadow::None;
    assert!(Lit::new(&scene).absorption(0, &points, Vec3::ZERO).iter().all(|a| *a == Vec3::ONE));
}

#[test]
fn an_opaque_body_blocks_all_light_behind_it_and_none_before_it_nor_on_itself() {
    for direction in [Vec3::NEG_Y, Vec3::new(0.7, -1.0, 0.3).normalize(), Vec3::new(2.0, -1.0, 0.0).normalize()] {
        let models = vec![model(slab(0.2, 0.5), opaque()), model(ball(0.3), opaque())];
        let mut scene = Scene { models, lights: vec![sun(direction)], ..Scene::default() };
        scene.models[1].translate = Vec3::new(0.0, 1.4, 0.0);
        let lit = Lit::new(&scene);
        let below = disc(direction * (0.35 / -direction.y), 0.4, 0.0);
        assert!(lit.absorption(0, &below, Vec3::ZERO).iter().all(|a| *a == Vec3::ZERO), "below: {direction}");
        let above = disc(Vec3::ZERO, 0.4, 1.9);
        assert!(lit.absorption(0, &above, Vec3::ZERO).iter().all(|a| *a == Vec3::ONE), "above: {direction}");
        // On the slab's own top, where the ball's shadow does not fall.
        let shadow = Vec3::new(0.0, 1.4, 0.0) + direction * (0.9 / -direction.y);
        let clear = |p: &Vec3| (*p - shadow).reject_from_normalized(direction).length() > 0.4;
        let top: Vec<Vec3> = disc(Vec3::ZERO, 0.9, 0.5).into_iter().filter(clear).collect();
        let answers = lit.absorption(0, &top, Vec3::Y);
        let dark = answers.iter().filter(|a| a.x < 0.99).count();
        assert!(dark == 0, "{dark} of {} points shade themselves: {direction}", answers.len());
        // On the ball's lit side.
        let lit_side = |p: &Vec3| p.dot(direction) < -0.3;
        let normals: Vec<Vec3> = disc(Vec3::ZERO, 1.0, 0.0)
            .into_iter()
            .flat_map(|p| {
                [1.0, -1.0].map(|side| Vec3::new(p.x, side * (1.0 - p.length_squared()).max(0.0).sqrt(), p.z))
            })
            .filter(lit_side)
            .collect();
        let points: Vec<Vec3> = normals.iter().map(|n| Vec3::new(0.0, 1.4, 0.0) + *n * 0.3).collect();
        let answers = lit.absorption_at(0, &points, &normals);
        let dark = answers.iter().filter(|a| a.x < 0.99).count();
        assert!(dark == 0, "{dark} of {} points of the ball shade themselves: {direction}", answers.len());
    }
}

#[test]
fn lamps_shine_through_grids_in_perspective_as_along_straight_ways() {
    let position = Vec3::new(0.6, 3.0, -0.4);
    let spot = LightKind::Spot { position, direction: (-position).normalize(), angle_deg: 30.0, blend: 0.1 };
    for kind in [LightKind::Point { position }, spot] {
        let light = Light { kind, ..Light::default() };
        let scene = Scene { models: vec![model(ball(1.0), glass(AMBER))], lights: vec![light], ..Scene::default() };
        let lit = Lit::new(&scene);
        let toward = |p: &Vec3| {
            let way = (*p - position).normalize();
            ((Vec3::ZERO - position) - way * (-position).dot(way)).length() < 0.93
        };
        let points: Vec<Vec3> = disc(Vec3::new(-0.4, 0.0, 0.2), 2.5, -1.3).into_iter().filter(toward).collect();
        assert!(points.len() > 100);
        let truth = |i: usize, share: f64| {
            let p = points[i].as_dvec3();
            absorbed(AMBER, share * chord(position.as_dvec3(), p, DVec3::ZERO, 1.0))
        };
        let answers = lit.absorption(0, &points, Vec3::ZERO);
        let (mean, most) = compare(&answers, |i| truth(i, 1.0));
        assert!(mean < 6e-3 && most < 0.06, "{kind:?}: mean {mean}, most {most}");
        assert!(compare(&answers, |i| truth(i, 0.5)).0 > 0.05, "half the absorption must not pass");
    }
}

#[test]
fn a_lamp_inside_a_ball_of_glass_shines_evenly_to_all_sides() {
    let lamp = Light { kind: LightKind::Point { position: Vec3::ZERO }, ..Light::default() };
    let mut scene = Scene { models: vec![model(ball(0.5), glass(AMBER))], lights: vec![lamp], ..Scene::default() };
    scene.light_grid.cells = Cells::Longest(64);
    let lit = Lit::new(&scene);
    assert_eq!(lit.grid_count(), 6);
    for distance in [2.0, 0.3] {
        let points: Vec<Vec3> = (0..600)
            .map(|i| {
                let y = 1.0 - 2.0 * (i as f32 + 0.5) / 600.0;
                let (s, c) = (i as f32 * 2.399_963).sin_cos();
                distance * Vec3::new(c * (1.0 - y * y).sqrt(), y, s * (1.0 - y * y).sqrt())
            })
            .collect();
        let answers = lit.absorption(0, &points, Vec3::ZERO);
        let (mean, most) = compare(&answers, |_| absorbed(AMBER, f64::from(distance).min(0.5)));
        assert!(mean < 3e-3 && most < 0.03, "{distance} away: mean {mean}, most {most}");
        assert!(compare(&answers, |_| DVec3::ONE).0 > 0.1, "the glass about the lamp must dim it");
    }
}

#[test]
fn a_leaky_ball_casts_no_dark_streaks() {
    let direction = Vec3::new(0.4, -1.0, 0.25).normalize();
    let coarse = Shape::Icosphere { radius: 1.0, subdivisions: 3 };
    let scene = Scene { models: vec![model(coarse, glass(AMBER))], lights: vec![sun(direction)], ..Scene::default() };
    let whole = World::load(&scene, None).unwrap();
    // Holes eight cells wide, one triangle in forty; planes of records close smaller ones.
    let mut leaky = whole.clone();
    let geometry = Arc::make_mut(&mut leaky.models[0]);
    let mut number = 0;
    geometry.triangles.retain(|_| {
        number += 1;
        number % 40 != 0
    });
    geometry.parts[0].triangles.end = u32::try_from(geometry.triangles.len()).unwrap();
    let questionable = |lit: &Lit| lit.bytes().chunks(8).filter(|record| record[6] & 8 != 0).count();
    let lit = Lit::of(&scene, &leaky);
    assert!(questionable(&lit) > 200, "columns through holes must be marked: {}", questionable(&lit));
    assert_eq!(questionable(&Lit::of(&scene, &whole)), 0, "a whole ball has none");

    let near = in_shadow_of_ball(direction, 0.95);
    // Far below, where a column that never closed would have gone dark.
    let far: Vec<Vec3> = near.iter().map(|p| *p + direction * 20.0).collect();
    for points in [&near, &far] {
        let answers = lit.absorption(0, points, Vec3::ZERO);
        let truth = |i: usize| {
            let p = near[i].as_dvec3();
            absorbed(AMBER, chord(p - direction.as_dvec3() * 10.0, p, DVec3::ZERO, 1.0))
        };
        let (mean, _) = compare(&answers, truth);
        assert!(mean < 0.03, "mean {mean}");
        let darkest = (0..answers.len()).map(|i| (answers[i].as_dvec3() - truth(i)).min_element()).fold(0.0, f64::min);
        assert!(darkest > -0.1, "a streak: {darkest}");
    }
}

#[test]
fn a_ground_of_80_units_does_not_coarsen_the_shadow() {
    let direction = Vec3::new(0.4, -1.0, 0.25).normalize();
    let mut ground = model(Shape::Plane { size: 80.0 }, opaque());
    ground.translate.y = -1.5;
    let scene = Scene {
        models: vec![ground, model(ball(1.0), glass(AMBER))],
        lights: vec![sun(direction)],
        ..Scene::default()
    };
    let points = in_shadow_of_ball(direction, 0.95);
    let answers = Lit::new(&scene).absorption(0, &points, Vec3::ZERO);
    let (mean, _) = compare(&answers, |i| {
        let p = points[i].as_dvec3();
        absorbed(AMBER, chord(p - direction.as_dvec3() * 10.0, p, DVec3::ZERO, 1.0))
    });
    assert!(mean < 4e-3, "mean {mean}");
}

#[test]
fn light_loses_at_clear_surfaces_what_they_mirror_and_absorption_does_not_count_it() {
    let points = disc(Vec3::ZERO, 0.4, 0.0);
    let lit = |edges: &[f32]| {
        let models = edges.windows(2).map(|e| model(slab(e[0], e[1]), glass(Vec3::ZERO))).collect();
        let lit = Lit::new(&Scene { models, lights: vec![sun(Vec3::NEG_Y)], ..Scene::default() });
        assert!(lit.absorption(0, &points, Vec3::ZERO).iter().all(|a| *a == Vec3::ONE));
        lit.transmittance(0, &points, Vec3::ZERO)
    };
    // ((n − 1)/(n + 1))² is mirrored at each of the two faces, and nothing where two bodies of one glass touch.
    for edges in [&[0.2, 0.5][..], &[0.2, 0.4, 0.5]] {
        let left = lit(edges);
        let (mean, _) = compare(&left, |_| DVec3::splat(0.96 * 0.96));
        assert!(mean < 2e-3, "{edges:?}: mean {mean}");
        assert!(compare(&left, |_| DVec3::splat(0.96_f64.powi(4))).0 > 0.02, "four faces pass for two");
    }
}

#[test]
fn the_light_volume_is_the_same_bytes_every_time() {
    let (mut models, _) = stack();
    models.push(model(ball(0.4), glass(AMBER)));
    let scene = Scene { models, lights: vec![sun(Vec3::new(0.3, -1.0, 0.1).normalize())], ..Scene::default() };
    let first = Lit::new(&scene).bytes();
    assert!(first.len() > 100_000 && first == Lit::new(&scene).bytes());
}

/// A ground at y = 0 and one body over it.
fn over_ground(body: Model, direction: Vec3) -> Scene {
    let ground = model(Shape::Plane { size: 80.0 }, opaque());
    Scene { models: vec![ground, body], lights: vec![sun(direction)], ..Scene::default() }
}

#[test]
fn soft_shadows_on_a_plane_take_as_much_light_as_sharp_ones() {
    let direction = Vec3::new(0.4, -1.0, 0.25).normalize();
    let mut body = model(ball(0.5), glass(2.0 * AMBER));
    body.translate.y = 1.2;
    let lit = Lit::new(&over_ground(body, direction));
    let middle = direction * (1.2 / -direction.y);
    let points: Vec<Vec3> = (0..160 * 160)
        .map(|i| {
            Vec3::new(middle.x, 0.0, middle.z + 1.2)
                + Vec3::new((i % 160) as f32 / 66.0 - 1.2, 0.0, (i / 160) as f32 / 66.0 - 2.4)
        })
        .collect();
    let missing = |answers: Vec<Vec3>| answers.iter().map(|a| 1.0 - a.as_dvec3()).sum::<DVec3>() / points.len() as f64;
    let (sharp, soft) = (missing(lit.transmittance(0, &points, Vec3::ZERO)), missing(lit.on_plane(0, &points)));
    assert!(((soft - sharp) / sharp).abs().max_element() < 0.02, "missing {soft} instead of {sharp}");
    assert!(sharp.z > 0.1, "the shadow must lie on the points: {sharp}");
}

#[test]
fn shadows_on_a_plane_are_crisp_near_the_body_and_soft_far_from_it() {
    let mut widths = Vec::new();
    for (height, angular_radius_deg) in [(0.02, 3.44), (0.5, 3.44), (0.9, 3.44), (0.9, 1.72)] {
        let body =
            model(Shape::Box { min: Vec3::new(-1.0, height, -1.0), max: Vec3::new(1.0, height + 0.1, 1.0) }, opaque());
        let mut scene = over_ground(body, Vec3::NEG_Y);
        scene.lights[0].angular_radius_deg = angular_radius_deg;
        let lit = Lit::new(&scene);
        // Across an edge, from dark to light.
        let points: Vec<Vec3> = (0..800).map(|i| Vec3::new(0.7 + i as f32 * 0.75e-3, 0.0, 0.1)).collect();
        let answers = lit.on_plane(0, &points);
        let at = |level: f32| points[answers.iter().position(|a| a.x > level).unwrap()].x;
        assert!(answers[0].x < 0.01 && answers[799].x > 0.99, "{} {}", answers[0], answers[799]);
        assert!((at(0.5) - 1.0).abs() < 0.02, "the edge stays where it is: {}", at(0.5));
        widths.push(at(0.9) - at(0.1));
    }
    // A disc of angular radius 0.06 seen past an edge: from 10% to 90% over 1.28 of its radius. Half as large, half as soft.
    for (width, height) in widths[1..].iter().zip([0.5, 0.9, 0.45]) {
        let truth = 1.28 * 0.06 * height;
        assert!((width / truth - 1.0).abs() < 0.35, "{width} wide instead of {truth}");
    }
    assert!(widths[0] < 0.035 && widths[2] > 1.3 * widths[1], "{widths:?}");
}

#[test]
fn thin_walls_tint_the_light_once_each_and_do_not_fill_their_body() {
    let tint = Vec3::new(0.9, 0.5, 0.25);
    let scene =
        Scene { models: vec![model(slab(0.2, 0.5), opaque())], lights: vec![sun(Vec3::NEG_Y)], ..Scene::default() };
    let mut world = World::load(&scene, None).unwrap();
    let part = &mut Arc::make_mut(&mut world.models[0]).parts[0];
    let (thin_wall, double_sided) = (true, true);
    part.material =
        Material { thin_wall, double_sided, base_color: tint, sigma: Vec3::splat(9.0), ..Material::default() };
    let scene = Scene { models: vec![Model { materials: Vec::new(), ..scene.models[0].clone() }], ..scene };
    let lit = Lit::of(&scene, &world);
    let below = lit.absorption(0, &disc(Vec3::ZERO, 0.4, 0.0), Vec3::ZERO);
    let (mean, _) = compare(&below, |_| (tint * tint).as_dvec3());
    assert!(mean < 2e-3, "below both walls: mean {mean}");
    let between = lit.absorption(0, &disc(Vec3::ZERO, 0.4, 0.35), Vec3::ZERO);
    let (mean, _) = compare(&between, |_| tint.as_dvec3());
    assert!(mean < 2e-3, "between the walls: mean {mean}");
    assert!(compare(&below, |_| tint.as_dvec3()).0 > 0.05, "one wall must not look like two");
}

#[test]
fn light_records_come_back_as_they_were_packed() {
    let pass = probe::compile(
        r#"
#include "lib/light_record.inc.wgsl"
struct Question { absorption: vec3f, surfaces: f32, medium: u32, questionable: u32, _pad: vec2u }
@group(0) @binding(0) var<storage, read> questions: array<Question>;
@group(0) @binding(1) var<storage, read_write> answers: array<Question>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x < arrayLength(&questions) {
        let q = questions[id.x];
        let r = LightRecord(q.absorption, q.surfaces, q.medium, q.questionable == 1u);
        let back = unpack_light_record(pack_light_record(r));
        answers[id.x] = Question(back.absorption, back.surfaces, back.medium, u32(back.questionable), vec2u(0u));
    }
}
"#,
        &[],
    );
    let share = |i: u32, k: u32| f32::from(u16::try_from(i * k % 1001).unwrap()) / 1000.0;
    let record = |i: u32| {
        let shares = [share(i, 1), share(i, 37), share(i, 101), share(i, 13)].map(f32::to_bits);
        [shares[0], shares[1], shares[2], shares[3], i * 41 % 4096, i % 2, 0, 0]
    };
    let records: Vec<[u32; 8]> = (0..3000).map(record).collect();
    let answers: Vec<[u32; 8]> = probe::ask(&pass, &[], &records);
    for (before, after) in records.iter().zip(&answers) {
        for k in 0..4 {
            let (a, b) = (f32::from_bits(before[k]), f32::from_bits(after[k]));
            let step = if k == 3 { 1.3e-4 } else { 6.5e-5 };
            assert!((a.sqrt() - b.sqrt()).abs() <= step && (a != 1.0 || b == 1.0), "share {k}: {a} came back as {b}");
        }
        assert_eq!(before[4..6], after[4..6]);
    }
}
