//! The eye within glass.

use super::balls::{Ball, through};
use super::nested::scene_of_balls;
use crate::support::{pixel_direction, quantile, render};
use glam::{DVec3, UVec2};
use murrine::march::Channel;
use murrine::scene::Scene;

const SIZE: UVec2 = UVec2::splat(64);
const FOV_DEG: f64 = 60.0;

fn ball(center: DVec3, radius: f64, ior: f64, sigma: f64) -> Ball {
    Ball { center, radius, ior, sigma, priority: 0 }
}

/// Looking along −z from `eye`.
fn scene_from(eye: DVec3, balls: &[Ball]) -> Scene {
    let mut scene = scene_of_balls(balls);
    scene.camera.eye = eye.as_vec3();
    scene.camera.target = (eye - DVec3::Z).as_vec3();
    scene.camera.fov_deg = 60.0;
    scene
}

/// The 95th percentile of the exit direction's error in degrees and of the transmittance's, and the share of rays that
/// do not leave where they must.
fn off(scene: &Scene, eye: DVec3, balls: &[Ball]) -> (f64, f64, f64) {
    let (ways, left) = (render(scene, SIZE, Channel::ExitDirection), render(scene, SIZE, Channel::Transmittance));
    let (mut degrees, mut transmittance, mut lost) = (Vec::new(), Vec::new(), 0.0);
    for (x, y) in (0..SIZE.y).flat_map(|y| (0..SIZE.x).map(move |x| (x, y))) {
        let Some(truth) = through(balls, eye, pixel_direction(SIZE, FOV_DEG, x, y), 8) else { continue };
        let got = ways.channel_at(x, y);
        lost += f64::from(got.is_nan());
        if !got.is_nan() {
            degrees.push(got.cross(truth.direction).length().atan2(got.dot(truth.direction)).to_degrees());
            transmittance.push((left.channel_at(x, y).x - truth.transmittance).abs());
        }
    }
    assert!(degrees.len() > 1000, "{} rays to compare", degrees.len());
    let count = degrees.len() as f64;
    (quantile(&mut degrees, 0.95), quantile(&mut transmittance, 0.95), lost / count)
}

#[test]
fn an_eye_in_the_middle_of_a_ball_sees_straight_rays_through_its_radius_of_glass() {
    let balls = [ball(DVec3::ZERO, 1.0, 1.5, 0.7)];
    let scene = scene_from(DVec3::ZERO, &balls);
    let (ways, left) = (render(&scene, SIZE, Channel::ExitDirection), render(&scene, SIZE, Channel::Transmittance));
    for (x, y) in [(32, 32), (3, 60), (50, 7), (63, 0)] {
        let d = pixel_direction(SIZE, FOV_DEG, x, y);
        assert!((ways.channel_at(x, y) - d).length() < 2e-3, "({x}, {y}): {} instead of {d}", ways.channel_at(x, y));
        let (got, truth) = (left.channel_at(x, y).x, (-0.7_f64).exp());
        assert!((got - truth).abs() < 1e-3, "({x}, {y}): {got} is left instead of {truth}");
    }
    let outside = scene_from(DVec3::new(0.0, 0.0, 1.2), &balls);
    let left = render(&outside, SIZE, Channel::Transmittance).channel_at(32, 32).x;
    assert!((left - (-1.4_f64).exp()).abs() < 1e-3, "{left} from outside, through twice as much");
}

#[test]
fn an_eye_within_nested_balls_sees_what_two_spheres_bend() {
    let (inner, outer) = (ball(DVec3::new(0.1, 0.0, 0.1), 0.5, 1.25, 1.3), ball(DVec3::ZERO, 1.0, 1.6, 0.4));
    // The later of equals rules: the inner ball is the later, whatever is seen first.
    let balls = [outer, inner];
    for eye in [DVec3::new(0.2, 0.1, 0.2), DVec3::new(-0.1, 0.2, 0.75)] {
        let scene = scene_from(eye, &balls);
        let (degrees, transmittance, lost) = off(&scene, eye, &balls);
        assert!(
            degrees < 0.5 && transmittance < 5e-3 && lost < 0.005,
            "{eye}: {degrees}°, |ΔT| {transmittance}, {lost}"
        );
        let (wrong, ..) = off(&scene, eye, &[Ball { ior: 1.0, sigma: 0.0, ..outer }, inner]);
        assert!(wrong > 1.5, "{eye}: the inner ball alone passes as well: {wrong}°");
    }
}
