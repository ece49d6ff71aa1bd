//! Clips pass through their keys, and between them go as glTF says.

use super::maker::Maker;
use glam::{Quat, Vec3};
use murrine::scene::World;
use murrine::scene::clips::{Channel, Interpolation, Property};
use murrine::scene::description::{Model, Scene};
use murrine::scene::pose::pose_vertices;
use serde_json::json;
use std::sync::Arc;

fn channel(property: Property, interpolation: Interpolation, times: &[f32], values: &[f32]) -> Channel {
    Channel { node: 0, property, interpolation, times_secs: times.to_vec(), values: values.to_vec() }
}

#[test]
fn a_cubic_spline_is_the_hermite_curve_worked_by_hand() {
    // Keys at 1 s and 3 s: values 1 and 5, out-tangent 2, in-tangent −1; a segment of 2 s. In the middle
    // ½·1 + 2·⅛·2 + ½·5 − 2·⅛·(−1) = 3.75, at a quarter 27/32 + 2·9/64·2 + 5·5/32 + 2·3/64 = 2.28125.
    let values = [[0.0; 3], [1.0; 3], [2.0; 3], [-1.0; 3], [5.0; 3], [0.0; 3]].concat();
    let spline = channel(Property::Translation, Interpolation::CubicSpline, &[1.0, 3.0], &values);
    for (time, expected) in [(0.0, 1.0), (1.0, 1.0), (1.5, 2.28125), (2.0, 3.75), (3.0, 5.0), (9.0, 5.0)] {
        for value in spline.sample(time) {
            assert!((value - expected).abs() < 1e-12, "{value} at {time} s, not {expected}");
        }
    }
    let slope = (spline.sample(1.0 + 1e-6)[0] - spline.sample(1.0)[0]) / 1e-6;
    assert!((slope - 2.0).abs() < 1e-4, "the curve leaves its key with the out-tangent, not {slope}");
    let straight = channel(Property::Translation, Interpolation::Linear, &[1.0, 3.0], &[[1.0; 3], [5.0; 3]].concat());
    assert_eq!(straight.sample(2.0), [3.0; 3], "the straight line is another curve");
}

#[test]
fn steps_hold_and_lines_are_clamped_outside_their_keys() {
    let values = [[1.0; 3], [2.0; 3], [4.0; 3]].concat();
    let step = channel(Property::Scale, Interpolation::Step, &[0.5, 1.0, 2.0], &values);
    for (time, expected) in [(0.0, 1.0), (0.99, 1.0), (1.0, 2.0), (1.99, 2.0), (2.0, 4.0), (7.0, 4.0)] {
        assert_eq!(step.sample(time), [expected; 3], "at {time} s");
    }
    let line = Channel { interpolation: Interpolation::Linear, ..step };
    for (time, expected) in [(0.0, 1.0), (0.75, 1.5), (1.5, 3.0), (7.0, 4.0)] {
        assert_eq!(line.sample(time), [expected; 3], "at {time} s");
    }
    assert!(channel(Property::Scale, Interpolation::Linear, &[], &[]).sample(0.0).is_empty());
}

#[test]
fn rotations_take_the_short_way_at_constant_speed() {
    let about_y = |degrees: f32| Quat::from_rotation_y(degrees.to_radians());
    let from = about_y(10.0);
    // The same orientation as 110°, its sign turned: the long way round would pass 240°.
    let to = -about_y(110.0);
    let keys = [from.to_array(), to.to_array()].concat();
    let turn = channel(Property::Rotation, Interpolation::Linear, &[0.0, 1.0], &keys);
    for share in [0.0, 0.25, 0.5, 0.75, 1.0] {
        let [x, y, z, w] = turn.sample(f64::from(share)).try_into().unwrap();
        let found = glam::DQuat::from_xyzw(x, y, z, w);
        let expected = about_y(10.0 + 100.0 * share).as_dquat();
        assert!((found.length() - 1.0).abs() < 1e-12);
        assert!(found.dot(expected).abs() > 1.0 - 1e-7, "{found} at {share}");
    }
    let long = glam::DQuat::from_xyzw(0.0, 0.0, 0.0, 1.0).dot(about_y(240.0).as_dquat()).abs();
    assert!(long < 1.0 - 1e-3, "the test tells the two ways apart");
}

/// What glTF's interpolations make of two keys a second and a half apart, a share of the way between them.
fn by_the_book(how: &str, keys: [&[f32]; 2], out_tangent: &[f32], in_tangent: &[f32], t: f64) -> Vec<f64> {
    let each = |i: usize| {
        let [a, b] = keys.map(|key| f64::from(key[i]));
        let [leaving, coming] = [out_tangent, in_tangent].map(|tangent| 1.5 * f64::from(tangent[i]));
        match how {
            "STEP" => a,
            "LINEAR" => a + (b - a) * t,
            _ => {
                let (t2, t3) = (t * t, t * t * t);
                (2.0 * t3 - 3.0 * t2 + 1.0) * a
                    + (t3 - 2.0 * t2 + t) * leaving
                    + (-2.0 * t3 + 3.0 * t2) * b
                    + (t3 - t2) * coming
            }
        }
    };
    (0..keys[0].len()).map(each).collect()
}

#[test]
fn each_property_moves_in_each_way_as_the_file_says() {
    let (a, b) = (Quat::from_rotation_x(0.3).to_array(), Quat::from_rotation_x(1.1).to_array());
    let cases: [(&str, &[f32], &[f32]); 4] = [
        ("translation", &[1.0, 2.0, 3.0], &[-4.0, 0.5, 9.0]),
        ("rotation", &a, &b),
        ("scale", &[1.0, 2.0, 0.5], &[3.0, 1.0, 0.25]),
        ("weights", &[0.0, 0.75], &[1.0, 0.25]),
    ];
    let (out_tangent, in_tangent) = ([0.4, -0.3, 0.2, 0.1], [-0.5, 0.6, 0.1, -0.2]);
    let targets = || json!([{ "POSITION": 0 }, { "POSITION": 0 }]);
    for (path, first, second) in cases {
        for how in ["STEP", "LINEAR", "CUBICSPLINE"] {
            let width = first.len();
            let (leaving, coming) = (&out_tangent[..width], &in_tangent[..width]);
            let still = vec![0.0; width];
            let values = match how {
                "CUBICSPLINE" => [&still, first, leaving, coming, second, &still].concat(),
                _ => [first, second].concat(),
            };
            let mut maker = Maker::triangle();
            maker.json["meshes"][0]["primitives"][0]["targets"] = targets();
            maker.animate("move", 0, path, how, &[0.5, 2.0], &values);
            let geometry = maker.read_cleanly().geometry;
            let channel = &geometry.clips[0].channels[0];
            for t in [0.1, 0.5, 0.8] {
                let mut expected = by_the_book(how, [first, second], leaving, coming, t);
                if path == "rotation" && how == "LINEAR" {
                    // A turn about one axis: the angle goes straight.
                    expected = glam::DQuat::from_rotation_x(0.3 + 0.8 * t).to_array().to_vec();
                } else if path == "rotation" {
                    let length = expected.iter().map(|x| x * x).sum::<f64>().sqrt();
                    expected.iter_mut().for_each(|x| *x /= length);
                }
                let found = channel.sample(0.5 + 1.5 * t);
                let error = found.iter().zip(&expected).map(|(f, e)| (f - e).abs()).fold(0.0, f64::max);
                assert!(found.len() == width && error < 1e-6, "{path} {how} at {t}: {found:?}, not {expected:?}");
            }
        }
    }
    let ways = ["STEP", "LINEAR", "CUBICSPLINE"].map(|how| by_the_book(how, [&a, &b], &out_tangent, &in_tangent, 0.5));
    assert!(ways[0] != ways[1] && ways[1] != ways[2], "the ways differ");
}

#[test]
fn a_scene_plays_the_clip_it_names_looped_at_its_speed() {
    let mut maker = Maker::triangle();
    maker.animate("rise", 0, "translation", "LINEAR", &[0.0, 2.0], &[0.0, 0.0, 0.0, 0.0, 4.0, 0.0]);
    maker.animate("slide", 0, "translation", "STEP", &[0.0, 1.0], &[3.0, 0.0, 0.0, 5.0, 0.0, 0.0]);
    let geometry = Arc::new(maker.read_cleanly().geometry);
    let at = |animation: Option<&str>, speed: f32, time: f64| {
        let animation = animation.map(str::to_owned);
        let scene = Scene { models: vec![Model { animation, speed, ..Model::default() }], ..Scene::default() };
        let world = World::from_geometry(&scene, vec![Arc::clone(&geometry)]);
        let corner = pose_vertices(&world, &scene, &world.pose(&scene, time))[0].0;
        (corner, world.duration_secs(&scene))
    };
    assert_eq!(at(None, 1.0, 0.5), (Vec3::new(0.0, 1.0, 0.0), 2.0), "the first clip by itself");
    assert_eq!(at(None, 1.0, 4.5).0, Vec3::new(0.0, 1.0, 0.0), "looped");
    assert_eq!(at(None, 2.0, 0.5), (Vec3::new(0.0, 2.0, 0.0), 1.0), "twice as fast");
    assert_eq!(at(None, -1.0, 0.5).0, Vec3::new(0.0, 3.0, 0.0), "backwards");
    assert_eq!(at(Some("slide"), 1.0, 0.5), (Vec3::new(3.0, 0.0, 0.0), 1.0));
    assert_eq!(at(Some("rise"), 1.0, 0.5).0, Vec3::new(0.0, 1.0, 0.0));
}

#[test]
fn an_animation_that_cannot_play_is_left_out_with_a_word() {
    let sound = [0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
    type Case<'a> = (&'a str, &'a str, &'a [f32], &'a [f32], &'a str);
    let cases: [Case; 6] = [
        ("translation", "LINEAR", &[1.0, 0.0], &sound, "not ascending"),
        ("translation", "LINEAR", &[0.0, f32::NAN], &sound, "not ascending"),
        ("translation", "CUBICSPLINE", &[0.0, 1.0], &sound, "too few"),
        ("translation", "WOBBLE", &[0.0, 1.0], &sound, "unknown way"),
        ("weights", "LINEAR", &[0.0, 1.0], &[0.0, 1.0], "too few"),
        ("translation", "LINEAR", &[0.0, 1.0], &[0.0, 0.0, 0.0, 1.0, f32::INFINITY, 1.0], "not finite"),
    ];
    for (path, how, times, values, told) in cases {
        let mut maker = Maker::triangle();
        maker.animate("odd", 0, path, how, times, values);
        maker.animate("good", 0, "translation", "LINEAR", &[0.0, 1.0], &sound);
        let loaded = maker.read();
        assert_eq!(loaded.warnings.len(), 1);
        assert!(loaded.warnings[0].what.contains(told), "{}", loaded.warnings[0]);
        assert_eq!(loaded.geometry.clips[0].channels.len(), 0);
        assert_eq!(loaded.geometry.clips[1].channels.len(), 1);
    }
    let mut maker = Maker::triangle();
    maker.animate("pointer", 0, "pointer", "LINEAR", &[0.0, 1.0], &sound);
    maker.json["animations"][0]["channels"][0]["target"].as_object_mut().unwrap().remove("node");
    assert!(maker.read().warnings[0].what.contains("pointer"));
}
