//! Two-surface refraction against its own closed form: the body's thickness along the unbent ray, gone along the bent
//! one, and the normal of the back face that the camera has there (CL §3.2.1, Fig. 5).

use super::balls::refract;
use crate::support::{glass, pixel_direction, quantile, render, scene_of};
use glam::{DVec3, UVec2, Vec3};
use murrine::march::Channel;
use murrine::scene::description::{Camera, Hit, Model, Refraction, Scene, Shape};

const SIZE: UVec2 = UVec2::splat(80);

/// Where a ray is bent for the second time, and its way from there.
type Exit = (DVec3, DVec3);

fn scene(model: Model, distance: f32, fov_deg: f32, hit: Hit) -> Scene {
    let mut scene = scene_of(vec![model]);
    scene.camera = Camera { eye: Vec3::new(0.0, 0.0, distance), fov_deg, ..Camera::default() };
    scene.effect.refraction = Refraction::TwoSurface;
    scene.effect.hit = hit;
    scene.effect.fill_questionable = false;
    scene
}

/// Median and 95th percentile of the direction's error in degrees and of the place's in world units.
fn errors(scene: &Scene, truth: impl Fn(DVec3, DVec3) -> Option<Exit>) -> [(f64, f64); 2] {
    let [ways, places] = [Channel::ExitDirection, Channel::ExitPosition].map(|channel| render(scene, SIZE, channel));
    let (mut degrees, mut lengths, mut lost) = (Vec::new(), Vec::new(), 0);
    for y in 0..SIZE.y {
        for x in 0..SIZE.x {
            let d = pixel_direction(SIZE, f64::from(scene.camera.fov_deg), x, y);
            let Some((place, way)) = truth(scene.camera.eye.as_dvec3(), d) else { continue };
            let got = ways.channel_at(x, y);
            if got.is_nan() {
                lost += 1;
                continue;
            }
            degrees.push(got.cross(way).length().atan2(got.dot(way)).to_degrees());
            lengths.push((places.channel_at(x, y) - place).length());
        }
    }
    assert!(degrees.len() > 1000 && lost * 50 < degrees.len(), "{lost} of {} rays are lost", degrees.len());
    [degrees, lengths].map(|mut all| (quantile(&mut all, 0.5), quantile(&mut all, 0.95)))
}

/// Through the unit ball: `length` of the way inside is worked out from the cosines before and behind its surface.
fn through_ball(eye: DVec3, d: DVec3, length: impl Fn(f64, f64) -> f64) -> Option<Exit> {
    let b = eye.dot(d);
    // Further out the second surface all but mirrors.
    if (eye - b * d).length() > 0.8 {
        return None;
    }
    let entry = eye + (-b - (b * b - eye.length_squared() + 1.0).sqrt()) * d;
    let inside = refract(d, entry, 1.0 / 1.3);
    let place = entry + length(-d.dot(entry), -inside.dot(entry)) * inside;
    let view = (place - eye).normalize();
    let middle = place.dot(view);
    let back = place + (-middle + (middle * middle - place.length_squared() + 1.0).sqrt()) * view;
    let way = refract(inside, -back, 1.3);
    way.is_finite().then_some((place, way))
}

#[test]
fn two_surfaces_of_a_ball_bend_by_its_thickness_along_the_unbent_ray() {
    let ball = || glass("ball", Shape::Icosphere { radius: 1.0, subdivisions: 5 }, 1.3, Vec3::ZERO);
    // Records' normals are their triangles', 1.9° apart, and the nearest voxel's is up to half a cell off.
    for (hit, degrees, cells) in [(Hit::Surfel, 0.4, 0.05), (Hit::Voxel, 0.9, 2.0)] {
        let scene = scene(ball(), 5.0, 28.0, hit);
        let cell = 2.0 / 120.0;
        let [way, place] = errors(&scene, |eye, d| through_ball(eye, d, |unbent, _| 2.0 * unbent));
        assert!(way.0 < degrees && way.1 < 4.0 * degrees, "{hit:?}: {way:?}°");
        assert!(place.0 < cells * cell && place.1 < 4.0 * cells * cell, "{hit:?}: off by {place:?}");
        // The true chord is another: the claim can tell this effect from the full one.
        let [_, place] = errors(&scene, |eye, d| through_ball(eye, d, |_, bent| 2.0 * bent));
        assert!(place.0 > 0.03, "{hit:?} passes for the true chord: {place:?}");
    }
}

#[test]
fn two_surfaces_of_a_slab_leave_the_rays_direction_and_overshoot_as_the_figure_does() {
    let turn = 30_f64.to_radians();
    let n = DVec3::new(turn.sin(), 0.0, turn.cos());
    let shape = Shape::Box { min: Vec3::new(-3.0, -3.0, -0.5), max: Vec3::new(3.0, 3.0, 0.5) };
    let slab = || Model { rotate_deg: Vec3::new(0.0, 30.0, 0.0), ..glass("slab", shape, 1.1, Vec3::ZERO) };
    let through_slab = |ior: f64| {
        move |eye: DVec3, d: DVec3| {
            let entry = eye + d * ((0.5 - eye.dot(n)) / d.dot(n));
            // As thick along the unbent ray, gone along the bent one.
            Some((entry + refract(d, n, 1.0 / ior) * (1.0 / -d.dot(n)), d))
        }
    };
    for (hit, cells) in [(Hit::Surfel, 0.05), (Hit::Voxel, 2.0)] {
        let scene = scene(slab(), 12.0, 8.0, hit);
        let cell = 6.0 / 120.0;
        let [way, place] = errors(&scene, through_slab(1.1));
        assert!(way.1 < 0.01, "{hit:?}: {way:?}°");
        assert!(place.0 < cells * cell && place.1 < 2.0 * cells * cell, "{hit:?}: off by {place:?}");
        let [_, place] = errors(&scene, through_slab(1.0));
        assert!(place.0 > 0.03, "{hit:?} passes for a ray that is not bent: {place:?}");
    }
}
