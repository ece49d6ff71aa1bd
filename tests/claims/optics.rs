//! How rays go through glass, against what physics says in closed form.

use crate::support::{glass, pixel_direction, quantile, render, scene_of};
use glam::{DVec3, UVec2, Vec3};
use murrine::march::Channel;
use murrine::scene::Scene;
use murrine::scene::description::{Camera, Hit, Shape};

const SPHERE: Shape = Shape::Icosphere { radius: 1.0, subdivisions: 6 };

/// A glass sphere of 81,920 triangles seen from five radii.
fn sphere_scene(ior: f32, hit: Hit) -> Scene {
    let mut scene = scene_of(vec![glass("sphere", SPHERE, ior, Vec3::ZERO)]);
    scene.camera = Camera { eye: Vec3::new(0.0, 0.0, 5.0), fov_deg: 30.0, ..Camera::default() };
    scene.effect.hit = hit;
    scene.effect.fill_questionable = false;
    scene
}

fn refract(d: DVec3, n: DVec3, eta: f64) -> DVec3 {
    let c = -d.dot(n);
    let k = 1.0 - eta * eta * (1.0 - c * c);
    eta * d + (eta * c - k.sqrt()) * n
}

/// Where a ray leaves the unit sphere, and which way; `None` where it misses or passes further out than `impact`.
fn through_sphere(eye: DVec3, d: DVec3, ior: f64, impact: f64) -> Option<(DVec3, DVec3)> {
    let b = eye.dot(d);
    if (eye - b * d).length() > impact {
        return None;
    }
    let entry = eye + (-b - (b * b - eye.length_squared() + 1.0).sqrt()) * d;
    let inside = refract(d, entry, 1.0 / ior);
    let exit = entry - 2.0 * entry.dot(inside) * inside;
    Some((exit, refract(inside, -exit, ior)))
}

/// Errors of the exit direction in degrees, and the share of rays that have none.
fn exit_errors(scene: &Scene, size: UVec2, ior: f64) -> (Vec<f64>, f64) {
    let picture = render(scene, size, Channel::ExitDirection);
    let mut errors = Vec::new();
    let mut lost = 0.0;
    for y in 0..size.y {
        for x in 0..size.x {
            let d = pixel_direction(size, 30.0, x, y);
            if let Some((_, truth)) = through_sphere(DVec3::new(0.0, 0.0, 5.0), d, ior, 0.95) {
                let got = picture.channel_at(x, y);
                if got.is_nan() {
                    lost += 1.0;
                } else {
                    errors.push(got.cross(truth).length().atan2(got.dot(truth)).to_degrees());
                }
            }
        }
    }
    let all = errors.len() as f64 + lost;
    (errors, lost / all)
}

#[test]
fn rays_leave_a_sphere_where_snell_says() {
    let size = UVec2::splat(256);
    let (mut errors, lost) = exit_errors(&sphere_scene(1.5, Hit::Surfel), size, 1.5);
    let (median, p95) = (quantile(&mut errors, 0.5), quantile(&mut errors, 0.95));
    eprintln!("surfel: median {median:.5} p95 {p95:.5} lost {lost:.5} max {}", quantile(&mut errors, 1.0));
    assert!(median <= 0.01 && p95 <= 0.1, "median {median}°, p95 {p95}°");
    assert!(lost <= 0.001, "{lost} of the rays never left");
}
